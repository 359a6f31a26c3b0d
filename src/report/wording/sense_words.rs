//! What recordings say of the senses of axes, as JSON and in words. It computes nothing.

use serde::Serialize;

use super::number::shown;
use crate::identify::{Fit, TurnedSense};
use crate::session::Session;

/// One axis that the tests move, or that stands off zero in them; or several that are not told together.
#[derive(Debug, Clone, Serialize)]
pub struct SenseJson {
    pub axis: String,
    /// The recordings tell its sense.
    pub told: bool,
    /// They speak for the other sense.
    pub looks_wrong: bool,
    /// χ² with the sense turned minus χ² as stated; at most 1e9.
    pub worse_by: f64,
    /// The marks of programs alone would tell the sense.
    pub shown_by_marks: bool,
    /// Errors that would come out otherwise with the sense turned.
    pub instead: Vec<InsteadJson>,
    /// In words, with a short test that tells; empty where the recordings tell the sense.
    pub says: String,
}

/// An error under both senses.
#[derive(Debug, Clone, Serialize)]
pub struct InsteadJson {
    pub error: String,
    pub value: f64,
    pub turned: f64,
    /// `um` or `arcsec`.
    pub unit: &'static str,
}

/// Most errors named in words; the farthest first.
const NAMED: usize = 3;

/// The senses of a fit.
pub fn senses_json(session: &Session, fit: &Fit, senses: &[TurnedSense]) -> Vec<SenseJson> {
    let machine = &session.machine;
    let of = |sense: &TurnedSense| {
        let instead: Vec<InsteadJson> = sense
            .moved
            .iter()
            .map(|moved| {
                let unknown = &fit.unknowns[moved.unknown];
                InsteadJson {
                    error: unknown.label.clone(),
                    value: unknown.measure.to_output(moved.stated),
                    turned: unknown.measure.to_output(moved.turned),
                    unit: unknown.measure.output_unit(),
                }
            })
            .collect();
        SenseJson {
            axis: sense.named(machine),
            told: sense.is_told(),
            looks_wrong: sense.looks_wrong(),
            worse_by: (sense.worse_by * 10.0).round() / 10.0 + 0.0,
            shown_by_marks: sense.is_shown_by_marks(),
            says: says(session, fit, sense),
            instead,
        }
    };
    senses.iter().map(of).collect()
}

/// Axes of which the marks of programs show that they go as stated, in a sentence; `None` where they show none.
pub fn as_marks_show(senses: &[SenseJson]) -> Option<String> {
    let shown = senses.iter().filter(|sense| sense.shown_by_marks && !sense.looks_wrong);
    let names: Vec<&str> = shown.map(|sense| sense.axis.as_str()).collect();
    let go = if names.len() == 1 { "goes" } else { "go" };
    (!names.is_empty()).then(|| format!("The marks in the captures show that {} {go} as stated.", names.join(", ")))
}

/// What an operator should know of a sense that the recordings do not tell.
fn says(session: &Session, fit: &Fit, sense: &TurnedSense) -> String {
    let name = sense.named(&session.machine);
    let mut words = match (sense.is_told(), sense.looks_wrong(), sense.axes.len()) {
        (true, false, _) => return String::new(),
        (_, true, 1) => format!("{name} seems to go the other way: with its sense turned the recordings fit better"),
        (_, true, _) => format!("{name} seem to go the other way: with their senses turned the recordings fit better"),
        (.., 1) => format!("these tests cannot tell {name}'s sense: with {name} reversed they fit as well"),
        _ => {
            format!("these tests cannot tell the senses of {name} together: with all of them reversed they fit as well")
        }
    };
    let instead: Vec<String> = sense
        .moved
        .iter()
        .take(NAMED)
        .map(|moved| {
            let (unknown, sigma) = (&fit.unknowns[moved.unknown], fit.estimates[moved.unknown].sigma);
            let out = |value: f64| shown(unknown.measure.to_output(value), unknown.measure.to_output(sigma)).0;
            let unit = unknown.measure.shown_unit();
            format!("{} {} for {} {unit}", unknown.label, out(moved.turned), out(moved.stated))
        })
        .collect();
    if !instead.is_empty() {
        words.push_str(&format!(" and give {}", instead.join(", ")));
        if sense.moved.len() > NAMED {
            words.push_str(&format!(" and {} more", sense.moved.len() - NAMED));
        }
    }
    format!("{words}; {}", sense.how_to_tell(session))
}

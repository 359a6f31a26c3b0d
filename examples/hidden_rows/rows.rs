//! Rows that are hidden, and how far predictions are from them.

use fiveaxis::chain::Composition;
use fiveaxis::diagnose::{Cause, as_found, diagnose};
use fiveaxis::identify::{Options, fitted_session, identify};
use fiveaxis::readings::Part;
use fiveaxis::session::Session;
use fiveaxis::simulate::simulate;

/// Which rows are hidden: of the rows with a reading every so many blocks one.
pub struct Hidden {
    pub part: usize,
    pub parts: usize,
    /// Rows of a block: neighbours are alike.
    pub block: usize,
}

/// What a part of the rows, predicted from the others, says.
pub struct Scored {
    /// Rows with a reading, hidden or not.
    pub readings: usize,
    /// Squared distance of prediction and reading, mm², by hidden row: of a fit of location errors alone, and with what was found.
    pub geometry_mm2: Vec<f64>,
    pub found_mm2: Vec<f64>,
    /// Effects in order.
    pub found: Vec<String>,
}

/// Root mean square of distances whose squares these are.
pub fn rms(squares: &[f64]) -> f64 {
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// Hides a part of the rows, fits the others and predicts what was hidden.
pub fn scored(whole: &Session, hidden: &Hidden) -> Scored {
    let is_hidden = hidden_rows(whole, hidden);
    let mut session = whole.clone();
    for (test, rows) in session.tests.iter_mut().zip(&is_hidden) {
        if let Some(recording) = &mut test.recording {
            for (reading, _) in recording.length_mm.iter_mut().zip(rows).filter(|(_, hidden)| **hidden) {
                *reading = f64::NAN;
            }
        }
    }
    let options = Options { free: None, prior: None };
    let fit = identify(&session, &options).expect("a fit");
    let geometry_mm2 = squared_distances(whole, &fitted_session(&session, &fit), &is_hidden);
    let diagnosis = diagnose(&session, &options).expect("a diagnosis");
    let (found_mm2, found) = match diagnosis.is_sound() {
        true => {
            let saved = as_found(&session, &diagnosis).expect("what was found");
            let name = |cause: &Cause| format!("{} {} {}", cause.effect, cause.place, cause.components.join(" "));
            let names = diagnosis.findings.iter().map(|finding| name(&finding.cause)).collect();
            (squared_distances(whole, &saved, &is_hidden), names)
        }
        false => (geometry_mm2.clone(), vec!["not to be judged".to_string()]),
    };
    Scored { readings: readings(whole), geometry_mm2, found_mm2, found }
}

/// By test and row; numbers of one reading are hidden together.
fn hidden_rows(session: &Session, hidden: &Hidden) -> Vec<Vec<bool>> {
    let mut counted = 0;
    let mut all: Vec<Vec<bool>> = Vec::new();
    for test in &session.tests {
        let leads = test.reading.part().is_none_or(Part::leads);
        let rows = match (leads, all.last()) {
            (false, Some(rows)) if !test.reading.is_gap() => rows.clone(),
            (false, _) => Vec::new(),
            (true, _) => {
                let readings = test.recording.as_ref().map_or(&[][..], |recording| &recording.length_mm);
                let row = |reading: &f64| {
                    let is_hidden = reading.is_finite() && (counted / hidden.block) % hidden.parts == hidden.part;
                    counted += usize::from(reading.is_finite());
                    is_hidden
                };
                readings.iter().map(row).collect()
            }
        };
        all.push(rows);
    }
    all
}

/// Squared distances of readings and what a session predicts of them, mm², by hidden row: of coordinates or lengths, not of turns.
fn squared_distances(whole: &Session, model: &Session, hidden: &[Vec<bool>]) -> Vec<f64> {
    let predicted = simulate(model, Composition::Exact).expect("a prediction");
    let mut squares: Vec<f64> = Vec::new();
    for ((test, trace), rows) in whole.tests.iter().zip(&predicted).zip(hidden) {
        let Some(recording) = test.recording.as_ref().filter(|_| !test.reading.is_turn()) else { continue };
        let hidden = rows.iter().enumerate().filter(|(_, hidden)| **hidden);
        let off = hidden.map(|(row, _)| (recording.length_mm[row] - trace.length_mm[row]).powi(2));
        match test.reading.part().is_none_or(Part::leads) {
            true => squares.extend(off),
            false => {
                let first = squares.len() - rows.iter().filter(|hidden| **hidden).count();
                squares[first..].iter_mut().zip(off).for_each(|(sum, off)| *sum += off);
            }
        }
    }
    squares
}

/// Rows with a reading.
fn readings(session: &Session) -> usize {
    let leading = session.tests.iter().filter(|test| test.reading.part().is_none_or(Part::leads));
    let of_test = |readings: &[f64]| readings.iter().filter(|reading| reading.is_finite()).count();
    leading.filter_map(|test| test.recording.as_ref()).map(|recording| of_test(&recording.length_mm)).sum()
}

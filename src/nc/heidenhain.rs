//! Programs in Heidenhain conversational. What is to be done is in `step`.

use std::fmt::Write as _;

use super::coordinates::Coordinates;
use super::dialect::{Dialect, feed, plain, seconds};
use super::step::Step;
use crate::units::rounded;

/// A program with numbered blocks.
pub(super) fn program(name: &str, head: &[String], steps: &[Step], coordinates: &Coordinates) -> String {
    let mut lines = vec![format!("BEGIN PGM {name} MM")];
    lines.extend(head.iter().map(|line| format!("; {}", plain(line))));
    // M129: no tool centre point control; M127: rotary axes go the way that is written, not the shorter one
    // M5, M9: the operator's hands are at the spindle next. A control starts programs with the first two by itself, and no
    // other mode is changed, so that nothing is to be restored at the end
    lines.extend(["M129", "M127", "M5", "M9"].map(String::from));
    // a tilted plane or a rotation that an earlier program left would turn what is written here; nothing moves
    lines.extend(["PLANE RESET STAY", "CYCL DEF 10.0 ROTATION", "CYCL DEF 10.1 ROT+0"].map(String::from));
    // M91: this block in machine coordinates
    let after = if coordinates.is_machine() { " M91" } else { "" };
    let decimals = Dialect::Heidenhain.decimals();
    let word = |axis: &str, value: f64| format!("{axis}{:+.decimals$}", rounded(value, decimals));
    for step in steps {
        match step {
            Step::Say(text) => lines.push(format!("; {}", plain(text))),
            Step::Stop(text) => {
                lines.push(format!("; {}", plain(text)));
                lines.push("STOP M0".into());
            }
            Step::Rapid { axis, to } => lines.push(format!("L {} R0 FMAX{after}", word(axis, *to))),
            Step::Feed { axis, to, per_minute } => {
                lines.push(format!("L {} R0 F{}{after}", word(axis, *to), feed(*per_minute)));
            }
            // FT: the time of the block, s
            Step::Move { to, minutes } => {
                let words: Vec<String> = to.iter().map(|(axis, value)| word(axis, *value)).collect();
                lines.push(format!("L {} R0 FT{}{after}", words.join(" "), seconds(minutes * 60.0)));
            }
            // conversational arcs carry no rotary axis: none is asked for
            Step::Arc { axes: [one, other], centre, end, counter_clockwise, feed_mm_per_min, .. } => {
                lines.push(format!("CC I{} I{}", word(one, centre[0]), word(other, centre[1])));
                let turn = if *counter_clockwise { '+' } else { '-' };
                let (one, other) = (word(one, end[0]), word(other, end[1]));
                lines.push(format!("C I{one} I{other} DR{turn} R0 F{}", feed(*feed_mm_per_min)));
            }
            Step::Dwell(seconds) => {
                lines.push("CYCL DEF 9.0 DWELL TIME".into());
                lines.push(format!("CYCL DEF 9.1 DWELL {seconds:.1}"));
            }
        }
    }
    lines.push(format!("END PGM {name} MM"));
    lines.iter().enumerate().fold(String::new(), |mut out, (number, line)| {
        let _ = writeln!(out, "{number} {line}");
        out
    })
}

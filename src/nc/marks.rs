//! What stands before and after each direction of a test: rests, and the moves along the bar that mark the run. The run is `step`'s.

use super::coordinates::Coordinates;
use super::step::Step;
use crate::machine::Machine;
use crate::plan::PlannedTest;
use crate::session::{Marks, marked};

/// Seconds that the machine rests at the ends of a run.
const REST_S: f64 = 3.0;

/// Positions that differ by less are the same, mm: programs state tens of nanometres.
const STANDS_MM: f64 = 1e-7;

/// Steps around the run of one direction.
pub(super) struct Rests {
    pub before: Vec<Step>,
    pub after: Vec<Step>,
}

/// Which of the two directions of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Direction {
    /// The rising one.
    First,
    /// The falling one.
    Second,
}

impl Rests {
    pub fn of(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates, direction: Direction) -> Rests {
        let rest = || vec![Step::Dwell(REST_S)];
        let (Some(marks), [low, .., high]) = (planned.test.marks, planned.run.as_slice()) else {
            return Rests { before: rest(), after: rest() };
        };
        let mark = |row: &[f64]| mark(machine, planned, coordinates, marks, row);
        // one gap between the two directions
        let (begin, end, lead, tail) = match direction {
            Direction::First => (low, high, Some(REST_S), marks.gap_s),
            Direction::Second => (high, low, None, REST_S),
        };
        let near = Step::Dwell(marks.rest_s);
        Rests {
            before: lead.map(Step::Dwell).into_iter().chain(mark(begin)).chain([near.clone()]).collect(),
            after: [near].into_iter().chain(mark(end)).chain([Step::Dwell(tail)]).collect(),
        }
    }
}

/// Out along the bar, hold, back.
fn mark(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates, marks: Marks, row: &[f64]) -> Vec<Step> {
    let Some(end) = marked(machine, &planned.test, row, marks.move_mm) else { return Vec::new() };
    let moving: Vec<usize> = (0..row.len()).filter(|&k| (end[k] - row[k]).abs() > STANDS_MM).collect();
    let to = |q: &[f64]| Step::Move {
        to: moving.iter().map(|&k| (machine.axes[k].name.clone(), coordinates.reading(machine, k, q[k]))).collect(),
        minutes: marks.move_s() / 60.0,
    };
    vec![to(&end), Step::Dwell(marks.hold_s), to(row)]
}

//! Programs that run a plan: approach, run-in, capture arc both ways, dwell, retreat, for four controls. It moves nothing itself.
//!
//! A program is a list of [`Step`]s, the same for every control; a dialect writes them down. It starts and ends at the
//! park position and travels one axis at a time, so that every control makes the motion that was checked. Feeds are those
//! of the moving ball converted to the turning axis, deg/min, which is how all four controls read F in a block that moves
//! one rotary axis alone; mm/min on circles; the time of each block where linear axes follow. Positions are machine
//! coordinates where `machine_zero` is known for every axis and the control feeds in them, else work coordinates with zero
//! at the machine file's zero.

mod coupled;
mod dialect;
mod head;
mod heidenhain;
mod iso;

pub use dialect::{Dialect, program};
pub use head::without_machine_zero;

use crate::machine::Machine;
use crate::plan::PlannedTest;
use crate::session::{Follow, Path};

/// One thing a program does.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Words for the operator.
    Say(String),
    /// Stop until the operator goes on.
    Stop(String),
    /// Move one axis fast; position in mm or deg.
    Rapid { axis: String, to: f64 },
    /// Move one rotary axis; position in deg, feed in deg/min.
    Turn { axis: String, to_deg: f64, feed_deg_per_min: f64 },
    /// Move several axes on a straight line; positions in mm or deg, and the time it takes, min.
    Move { to: Vec<(String, f64)>, minutes: f64 },
    /// An arc of two linear axes, the one that carries the cosine first; centre and end relative to where it begins, mm.
    Arc { axes: [String; 2], centre: [f64; 2], end: [f64; 2], counter_clockwise: bool, feed_mm_per_min: f64 },
    /// Wait, s.
    Dwell(f64),
}

/// Seconds that the machine rests at the ends of a run.
const REST_S: f64 = 3.0;
/// Feed of the approach relative to the capture's.
const APPROACH: f64 = 2.0;

/// What positions count from.
#[derive(Debug, Clone, PartialEq)]
pub enum Coordinates {
    /// Machine coordinates; offsets from the machine file's zero by axis, mm or deg.
    Machine(Vec<f64>),
    /// Work coordinates with zero at the machine file's zero.
    Work,
}

impl Coordinates {
    /// Machine coordinates where `machine_zero` is known for every axis.
    pub fn of(machine: &Machine) -> Coordinates {
        machine_offsets(machine).map_or(Coordinates::Work, Coordinates::Machine)
    }

    /// What the control reads at a position held in mm or rad, mm or deg.
    pub fn reading(&self, machine: &Machine, axis: usize, position: f64) -> f64 {
        machine.axes[axis].kind.to_file_unit(position) + self.offset(axis)
    }

    /// What is added to an axis's position, mm or deg.
    fn offset(&self, axis: usize) -> f64 {
        match self {
            Coordinates::Machine(offsets) => offsets[axis],
            Coordinates::Work => 0.0,
        }
    }
}

/// Positions offset from the machine file's zero to what the control reads, by axis; `None` in work coordinates.
pub fn machine_offsets(machine: &Machine) -> Option<Vec<f64>> {
    machine.machine_zero.iter().copied().collect()
}

/// Steps of one planned test, both directions.
pub fn steps(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> Vec<Step> {
    let test = &planned.test;
    let rapid =
        |k: usize, q: f64| Step::Rapid { axis: machine.axes[k].name.clone(), to: coordinates.reading(machine, k, q) };
    let approach = &planned.approach;
    let parked: Vec<String> = approach
        .park_order
        .iter()
        .map(|&k| format!("{} {:.3}", machine.axes[k].name, coordinates.reading(machine, k, approach.park[k])))
        .collect();
    let p = test.pivot.at;
    let mut steps = vec![
        Step::Say(format!("pivot on {} ball {:.3} mm above it", planned.mount, planned.height_mm)),
        Step::Say(format!("pivot ball at x {:.3} y {:.3} z {:.3} with all axes at zero", p.x, p.y, p.z)),
        Step::Say(format!("bring the axes to park by hand: {}", parked.join(" "))),
        Step::Stop(match test.spindle_ball.indexed_about {
            None => "at park, pivot and spindle cup mounted, bar off".into(),
            Some(_) => "at park, pivot and spindle cup mounted, spindle indexed by 180 deg, bar off".into(),
        }),
    ];
    steps.extend(approach.park_order.iter().map(|&k| rapid(k, approach.park[k])));
    steps.extend(approach.legs.iter().map(|leg| rapid(leg.axis, leg.to)));
    steps.push(Step::Stop("mount the bar and start the recording".into()));
    let (from, to) = (planned.sweep.from_deg, planned.sweep.to_deg);
    for (test, (first, second)) in planned.both_ways().iter().zip([(from, to), (to, from)]) {
        steps.push(Step::Say(format!("{} capture {first} to {second}", test.name)));
        match &test.path {
            Some(Path::Sweep { axis, follow: Follow::None, .. }) => {
                steps.extend(sweep(machine, planned, *axis, coordinates.offset(*axis), [first, second]));
            }
            // the machine stands where the run-in begins, or where the last run-out ended
            Some(Path::Sweep { .. }) => {
                steps.push(Step::Dwell(REST_S));
                steps.extend(coupled::follow(machine, planned, test, coordinates));
            }
            Some(Path::Circle { .. }) => {
                steps.push(Step::Dwell(REST_S));
                steps.extend(coupled::circle(machine, test, coordinates));
            }
            None => {}
        }
        steps.push(Step::Dwell(REST_S));
    }
    steps.push(Step::Stop("stop the recording and take the bar off".into()));
    steps.extend(approach.retreat().iter().map(|leg| rapid(leg.axis, leg.to)));
    steps
}

/// One direction of a sweep of one axis.
fn sweep(machine: &Machine, planned: &PlannedTest, axis: usize, offset: f64, [first, second]: [f64; 2]) -> Vec<Step> {
    let test = &planned.test;
    let name = machine.axes[axis].name.clone();
    let feed = (test.feed_mm_per_min.unwrap_or(500.0) / planned.rho_mm).to_degrees();
    let run_in = test.overshoot.unwrap_or(0.0) * (second - first).signum();
    let clamp =
        |deg: f64| machine.axes[axis].range.map_or(deg, |(low, high)| deg.clamp(low.to_degrees(), high.to_degrees()));
    let turn = |deg: f64, factor: f64| Step::Turn {
        axis: name.clone(),
        to_deg: clamp(deg) + offset,
        feed_deg_per_min: feed * factor,
    };
    vec![
        turn(first - run_in, APPROACH),
        Step::Dwell(REST_S),
        turn(first, 1.0),
        turn(second, 1.0),
        turn(second + run_in, 1.0),
    ]
}

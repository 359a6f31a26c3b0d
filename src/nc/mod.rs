//! Programs that run a plan: approach, run-in, capture arc both ways, dwell, retreat, for four controls. It moves nothing itself.
//!
//! A program is a list of [`Step`]s, the same for every control; a dialect writes them down. It starts and ends at the
//! park position and travels one axis at a time, so that every control makes the motion that was checked. Near the cups it
//! stops before every leg and goes at feed. Feeds are those of one ball as seen from the other, converted to the turning
//! axis, deg/min, which is how all four controls read F in a block that moves one rotary axis alone; mm/min along the arc on
//! circles and arcs that carry a rotary axis; the time of each block where slides follow on another curve. Positions are
//! machine coordinates where `machine_zero` is known for every axis and the control feeds in them, else work coordinates
//! with zero at the machine file's zero.

mod coupled;
mod dialect;
mod dry_run;
mod head;
mod heidenhain;
mod iso;
mod marks;
mod way;

pub use dialect::{Dialect, dry_run_program, program};
pub use dry_run::{dry_run_steps, little_words};
pub use head::{ball_speed, without_machine_zero};

use crate::machine::Machine;
use crate::plan::PlannedTest;
use crate::session::{Follow, Path, Test};

/// One thing a program does.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// Words for the operator.
    Say(String),
    /// Stop until the operator goes on.
    Stop(String),
    /// Move one axis fast; position in mm or deg.
    Rapid { axis: String, to: f64 },
    /// Move one axis; position in mm or deg, feed in mm/min or deg/min.
    Feed { axis: String, to: f64, per_minute: f64 },
    /// Move several axes on a straight line; positions in mm or deg, and the time it takes, min.
    Move { to: Vec<(String, f64)>, minutes: f64 },
    /// An arc of two linear axes, the one that carries the cosine first; centre and end relative to where it begins, mm; whole
    /// turns before the end; a rotary axis that turns evenly with it, by deg; feed along the arc.
    Arc {
        axes: [String; 2],
        centre: [f64; 2],
        end: [f64; 2],
        counter_clockwise: bool,
        turns: u32,
        turn: Option<(String, f64)>,
        feed_mm_per_min: f64,
    },
    /// Wait, s.
    Dwell(f64),
}

/// Which curves a control draws by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curves {
    /// Arcs in all coordinate planes, a rotary axis carried along, less than a turn in a block.
    Carrying,
    /// The same with any number of turns in a block.
    Winding,
    /// Arcs in XY and YZ. Conversational tells no sense of arcs across the working plane beyond all doubt in ZX, and its arcs
    /// carry no rotary axis.
    Plain,
}

/// Seconds that the machine rests at the ends of a run.
const REST_S: f64 = 3.0;

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
pub fn steps(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates, curves: Curves) -> Vec<Step> {
    let approach = &planned.approach;
    let indexed = match planned.test.spindle_ball.indexed_about {
        None => "",
        Some(_) => ", spindle indexed by 180 deg",
    };
    let mut steps = pivot_words(machine, planned, coordinates);
    steps.extend([
        Step::Say(park_words(machine, planned, coordinates)),
        Step::Stop(format!("at park, pivot and spindle cup mounted{indexed}, bar off")),
    ]);
    steps.extend(approach.park_order.iter().map(|&k| Step::Rapid {
        axis: machine.axes[k].name.clone(),
        to: coordinates.reading(machine, k, approach.park[k]),
    }));
    steps.extend(way::there(machine, planned, coordinates));
    steps.push(Step::Stop("mount the bar and start the recording".into()));
    let (from, to) = (planned.sweep.from_deg, planned.sweep.to_deg);
    for (test, (first, second)) in planned.both_ways().iter().zip([(from, to), (to, from)]) {
        steps.push(Step::Say(format!("{} capture {first} to {second}", test.name)));
        // the machine stands where the run-in begins, or where the last run-out ended
        let rests = marks::Rests::of(machine, planned, coordinates, from == first);
        steps.extend(rests.before);
        steps.extend(run(machine, planned, test, coordinates, curves));
        steps.extend(rests.after);
    }
    steps.push(Step::Stop("stop the recording and take the bar off".into()));
    steps.extend(way::back(machine, planned, coordinates));
    steps
}

/// One direction of a test from the start of its run-in to the end of its run-out.
fn run(machine: &Machine, planned: &PlannedTest, test: &Test, coordinates: &Coordinates, curves: Curves) -> Vec<Step> {
    match &test.path {
        Some(Path::Sweep { axis, from, to, follow: Follow::None, .. }) => {
            vec![sweep(machine, planned, *axis, coordinates.offset(*axis), to + (to - from).signum() * run_in(test))]
        }
        Some(Path::Sweep { .. }) => coupled::follow(machine, planned, test, coordinates, curves),
        Some(Path::Circle { .. }) => coupled::circle(machine, test, coordinates, curves),
        None => Vec::new(),
    }
}

fn run_in(test: &Test) -> f64 {
    test.overshoot.unwrap_or(crate::plan::RUN_IN)
}

/// One direction of a sweep of one axis: run-in, arc and run-out in one block, so that no corner slows it down.
fn sweep(machine: &Machine, planned: &PlannedTest, axis: usize, offset: f64, end_deg: f64) -> Step {
    let feed = planned.test.feed_mm_per_min.unwrap_or(coupled::FEED_MM_PER_MIN);
    let range = machine.axes[axis].range.map(|(low, high)| (low.to_degrees(), high.to_degrees()));
    Step::Feed {
        axis: machine.axes[axis].name.clone(),
        to: range.map_or(end_deg, |(low, high)| end_deg.clamp(low, high)) + offset,
        per_minute: (feed / planned.rho_mm).to_degrees(),
    }
}

/// Where the pivot goes and how well that must be met.
fn pivot_words(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> Vec<Step> {
    let p = planned.test.pivot.at;
    vec![
        Step::Say(format!("pivot on {} ball {:.3} mm above it", planned.mount, planned.height_mm)),
        Step::Say(format!("pivot ball at x {:.3} y {:.3} z {:.3} with all axes at zero", p.x, p.y, p.z)),
        Step::Say(placing_words(machine, planned, coordinates)),
    ]
}

/// `jog to X -100 Y 0 Z -15, lock the magnet, within 0.06 mm`, and why not farther.
pub fn placing_words(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> String {
    let placing = &planned.placing;
    // rounded down: what is said holds
    let within = (placing.pivot_mm * 100.0 + 1e-6).floor() / 100.0;
    let Some(jog) = &placing.jog else {
        return format!(
            "the slides do not reach the pivot's place: measure it in, within {within} mm, {}",
            placing.reason
        );
    };
    let shown = |k: &usize| {
        let value = coordinates.reading(machine, *k, jog[*k]);
        format!("{} {}", machine.axes[*k].name, dialect::rounded(value, 3))
    };
    let is_linear = |k: &usize| machine.axes[*k].kind == crate::machine::AxisKind::Linear;
    let (linear, rotary): (Vec<usize>, Vec<usize>) = (0..jog.len()).partition(is_linear);
    let list = |axes: &[usize]| axes.iter().map(shown).collect::<Vec<_>>().join(" ");
    format!(
        "place the pivot: at {} jog to {}, setting ball of the spindle in the pivot cup, lock the magnet; within {within} mm, {}",
        list(&rotary),
        list(&sorted_by_name(machine, linear)),
        placing.reason
    )
}

/// X before Y before Z, as operators read them.
fn sorted_by_name(machine: &Machine, mut axes: Vec<usize>) -> Vec<usize> {
    axes.sort_by(|&a, &b| machine.axes[a].name.cmp(&machine.axes[b].name));
    axes
}

/// Where the axes are brought by hand.
fn park_words(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> String {
    let approach = &planned.approach;
    let stands =
        |&k: &usize| format!("{} {:.3}", machine.axes[k].name, coordinates.reading(machine, k, approach.park[k]));
    let parked: Vec<String> = approach.park_order.iter().map(stands).collect();
    format!("bring the axes to park by hand: {}; the program then goes there itself", parked.join(" "))
}

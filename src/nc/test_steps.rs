//! Steps of one planned test: park, way to the setup, runs both ways, way back.

use super::coordinates::Coordinates;
use super::marks::{Direction, Rests};
use super::run::run;
use super::setup_words::{park_words, pivot_words};
use super::step::{Curves, Step};
use super::way;
use crate::machine::Machine;
use crate::plan::PlannedTest;

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
    if !approach.aside_and_back.is_empty() {
        steps.push(Step::Say(
            "aside and back, so that the flank is known on which axes stand that do not move in the run".into(),
        ));
    }
    steps.extend(approach.aside_and_back.iter().map(|leg| Step::Rapid {
        axis: machine.axes[leg.axis].name.clone(),
        to: coordinates.reading(machine, leg.axis, leg.to),
    }));
    steps.extend(way::there(machine, planned, coordinates));
    steps.push(Step::Stop("mount the bar and start the recording".into()));
    let (from, to) = (planned.sweep.from_deg, planned.sweep.to_deg);
    let directions = [(Direction::First, from, to), (Direction::Second, to, from)];
    for (test, (direction, first, second)) in planned.both_ways().iter().zip(directions) {
        steps.push(Step::Say(format!("{} capture {first} to {second}", test.name)));
        // the machine stands where the run-in begins, or where the last run-out ended
        let rests = Rests::of(machine, planned, coordinates, direction);
        steps.extend(rests.before);
        steps.extend(run(machine, planned, test, coordinates, curves));
        steps.extend(rests.after);
    }
    steps.push(Step::Stop("stop the recording and take the bar off".into()));
    steps.extend(way::back(machine, planned, coordinates));
    steps
}

//! The dry run of a plan: the sense of every axis, then all runs at reduced feed, the bar left off. Programs of tests are `test_steps`'s.

use super::coordinates::Coordinates;
use super::run::run;
use super::setup_words::{park_words, pivot_words};
use super::step::{Curves, Step};
use super::way;
use crate::chain::{Chain, sense_in_words};
use crate::machine::Machine;
use crate::plan::{LittleMove, Plan, PlannedTest};

/// Part of its feed at which a run is gone through without the bar.
const REDUCED: f64 = 0.5;

/// Steps of a whole plan without the bar; `tool` is the direction in which the tool looks at zero, where it is known.
///
/// The motions are those of the tests, certified with them; the little moves were certified where they were chosen.
pub fn dry_run_steps(machine: &Machine, plan: &Plan, coordinates: &Coordinates, curves: Curves) -> Vec<Step> {
    let Some(first) = plan.tests.first() else { return Vec::new() };
    let mut steps = vec![
        Step::Say("dry run: the bar stays off all the way".into()),
        Step::Say(park_words(machine, first, coordinates)),
        Step::Stop("at park, nothing mounted yet; override of rapid and feed low, hand on the feed hold".into()),
    ];
    steps.extend(to_park(machine, first, coordinates));
    for (index, little) in plan.little_moves.iter().enumerate() {
        steps.extend(sense(machine, first, little, coordinates, index));
    }
    let mut parked = &first.approach.park;
    for planned in &plan.tests {
        steps.push(Step::Say(format!("{}: way and run without the bar", planned.test.name)));
        steps.extend(pivot_words(machine, planned, coordinates));
        steps.push(Step::Stop(format!("mount pivot and spindle cup of {}, bar off", planned.test.name)));
        if parked != &planned.approach.park {
            steps.extend(to_park(machine, planned, coordinates));
            parked = &planned.approach.park;
        }
        steps.extend(way::there(machine, planned, coordinates));
        steps.push(Step::Stop("next the run without the bar, both ways".into()));
        for test in &planned.both_ways() {
            steps.extend(run(machine, planned, test, coordinates, curves).into_iter().map(reduced));
        }
        steps.push(Step::Stop("next the way back".into()));
        steps.extend(way::back(machine, planned, coordinates));
    }
    steps
}

/// Every axis to park, at feed: no sense has been seen yet, and between tests the cups are mounted.
fn to_park(machine: &Machine, planned: &PlannedTest, coordinates: &Coordinates) -> Vec<Step> {
    let chain = Chain::of(machine);
    let park = &planned.approach.park;
    let step = |&k: &usize| Step::Feed {
        axis: machine.axes[k].name.clone(),
        to: coordinates.reading(machine, k, park[k]),
        per_minute: way::feed_of(machine, &chain, planned, k, park, park),
    };
    planned.approach.park_order.iter().map(step).collect()
}

/// What an operator must see, and what it means when it is not seen.
pub fn little_words(machine: &Machine, planned: &PlannedTest, little: &LittleMove) -> String {
    let sense = sense_in_words(machine, little.axis, &planned.approach.park);
    format!("{sense}; if not, stop: the machine file states another sense")
}

/// A little move up and back, with a stop before and after it.
fn sense(
    machine: &Machine,
    planned: &PlannedTest,
    little: &LittleMove,
    coordinates: &Coordinates,
    index: usize,
) -> Vec<Step> {
    let park = &planned.approach.park;
    let name = &machine.axes[little.axis].name;
    let chain = Chain::of(machine);
    let to = |q: f64| Step::Feed {
        axis: name.clone(),
        to: coordinates.reading(machine, little.axis, q),
        per_minute: way::feed_of(machine, &chain, planned, little.axis, park, park),
    };
    let mut steps = Vec::new();
    if little.from != park[little.axis] {
        steps.push(Step::Say(format!("{name} first a little the other way: it stands at its upper end")));
        steps.push(to(little.from));
    }
    steps.push(Step::Stop(format!("{} {}", index + 1, little_words(machine, planned, little))));
    steps.push(to(little.to));
    if little.to != park[little.axis] {
        steps.push(Step::Stop(format!("{name} seen and ticked on the sheet, next back to park")));
        steps.push(to(park[little.axis]));
    } else {
        steps.push(Step::Stop(format!("{name} seen and ticked on the sheet")));
    }
    steps
}

/// The same step at reduced feed.
fn reduced(step: Step) -> Step {
    match step {
        Step::Feed { axis, to, per_minute } => Step::Feed { axis, to, per_minute: per_minute * REDUCED },
        Step::Move { to, minutes } => Step::Move { to, minutes: minutes / REDUCED },
        Step::Arc { axes, centre, end, counter_clockwise, turns, turn, feed_mm_per_min } => {
            let feed_mm_per_min = feed_mm_per_min * REDUCED;
            Step::Arc { axes, centre, end, counter_clockwise, turns, turn, feed_mm_per_min }
        }
        other => other,
    }
}

//! Effects that depend on the position of their axis alone, as component errors of that axis, and constant ones as location errors.
//! No effect's own formula.

use super::disturbance::{Disturbance, Disturbances};
use crate::chain::Chain;
use crate::effects::{Context, Driver, kind};
use crate::machine::{AxisKind, Component, ComponentError, ComponentForm, Effect, Machine, Outlet, Place, Size};
use crate::readings::Reading;
use crate::session::{Ball, Clock, LengthColumn, Recording, Session, Spread, Test, Zero};
use crate::statistics::median;
use nalgebra::Vector3;

/// Steps over the travel of an axis at which an effect is read at first and at most.
const STEPS: (usize, usize) = (1440, 16 * 1440);
/// Share of an effect's largest value that a straight line over two steps may leave; over one it leaves a quarter of it.
const MOST_BEND: f64 = 0.01;
/// Travel of axes without a range, mm or rad on either side.
const OPEN_TRAVEL: (f64, f64) = (1000.0, std::f64::consts::TAU);

/// Shortest half of a table, mm or rad.
const LEAST_SPAN: f64 = 1e-3;

/// Takes effects that are functions of their axis's position into its component errors, by a table over the travel; those
/// that move the lines of axes go into the location errors. Effects that are neither stay, and their names are returned.
pub fn into_component_errors(machine: &mut Machine) -> Vec<String> {
    into_component_errors_within(machine, &[]).left
}

/// What became of effects.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Taken {
    /// Names of those that stay.
    pub left: Vec<String>,
    /// Those whose tables end within the travel: beyond it their last value holds.
    pub ends: Vec<TableEnd>,
}

/// Where a table ends.
#[derive(Debug, Clone, PartialEq)]
pub struct TableEnd {
    /// Name of the effect.
    pub effect: String,
    /// Axis index.
    pub axis: usize,
    /// mm or rad.
    pub from: f64,
    pub to: f64,
}

/// The same with tables over the positions alone at which an effect was seen: by axis index, mm or rad; none for all the travel.
pub fn into_component_errors_within(machine: &mut Machine, seen: &[(f64, f64)]) -> Taken {
    let effects = std::mem::take(&mut machine.effects);
    let mut taken = Taken::default();
    for effect in effects {
        if let Some(moved) = as_location_errors(machine, &effect) {
            for (axis, moved) in machine.axes.iter_mut().zip(moved) {
                axis.location_errors.iter_mut().zip(moved).for_each(|(error, moved)| *error += moved);
            }
            continue;
        }
        let Some((axis, span)) = effect.place.axis().map(|axis| (axis, span(machine, axis, seen))) else {
            taken.left.push(effect.kind.clone());
            machine.effects.push(effect);
            continue;
        };
        match as_component_errors(machine, &effect, span) {
            // forms of one component add up
            Some(errors) => {
                let (from, to) = span;
                let ends = machine.axes[axis].range.is_none_or(|(low, high)| from > low || to < high);
                if !seen.is_empty() && ends && !errors.is_empty() {
                    taken.ends.push(TableEnd { effect: effect.kind.clone(), axis, from, to });
                }
                errors.into_iter().for_each(|(axis, error)| machine.axes[axis].component_errors.push(error))
            }
            None => {
                taken.left.push(effect.kind.clone());
                machine.effects.push(effect);
            }
        }
    }
    taken
}

/// Positions at which each axis was recorded, mm or rad; none where the session cannot be followed.
pub fn positions_seen(session: &Session) -> Vec<(f64, f64)> {
    let chain = Chain::of(&session.machine);
    let context = Context::of(session, &chain);
    context.map_or_else(
        |_| Vec::new(),
        |context| (0..session.machine.axes.len()).map(|axis| context.visited(axis)).collect(),
    )
}

/// Median way of each axis from reading to reading where it moved, mm or rad; 0 where it never did.
pub fn steps_seen(session: &Session) -> Vec<f64> {
    let chain = Chain::of(&session.machine);
    let Ok(context) = Context::of(session, &chain) else { return Vec::new() };
    let of_axis = |axis: usize| {
        let ways = |test: usize| {
            let positions: Vec<f64> = context.motion(test).axis(axis).collect();
            positions.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|way| *way > 0.0).collect::<Vec<f64>>()
        };
        median((0..context.tests()).flat_map(ways)).unwrap_or(0.0)
    };
    (0..session.machine.axes.len()).map(of_axis).collect()
}

/// Positions over which an axis has a table, mm or rad.
fn span(machine: &Machine, axis: usize, seen: &[(f64, f64)]) -> (f64, f64) {
    let own = &machine.axes[axis];
    let open = if own.kind == AxisKind::Linear { OPEN_TRAVEL.0 } else { OPEN_TRAVEL.1 };
    let (from, to) = own.range.unwrap_or((-open, open));
    match seen.get(axis) {
        // an axis that never moved has one place, and a table two
        Some(&(low, high)) if low <= high => {
            let (low, high) = (low.max(from), high.min(to));
            if high - low > LEAST_SPAN { (low, high) } else { (low - LEAST_SPAN, low + LEAST_SPAN) }
        }
        _ => (from, to),
    }
}

/// Location errors that do the same, by axis; `None` where it does more than that, or not in every test.
fn as_location_errors(machine: &Machine, effect: &Effect) -> Option<Vec<[f64; 6]>> {
    let is_location = |size: &Size| matches!(size.outlet, Outlet::Location { .. });
    if effect.tests.is_some() || effect.sizes.is_empty() || !effect.sizes.iter().all(is_location) {
        return None;
    }
    probed(machine, effect, 0, &[0.0]).map(|disturbances| disturbances.location)
}

/// Component errors that do the same; `None` where it depends on more than its axis's position.
fn as_component_errors(
    machine: &Machine,
    effect: &Effect,
    (from, to): (f64, f64),
) -> Option<Vec<(usize, ComponentError)>> {
    let Place::Axis(axis) = effect.place else { return None };
    let is_steady = kind(&effect.kind)?.driver == Driver::Position && effect.tests.is_none();
    let stays_there = |size: &Size| match size.outlet {
        Outlet::Motion { axis: of, .. } | Outlet::Along { axis: of } => of == axis,
        _ => false,
    };
    if !is_steady || !effect.sizes.iter().all(stays_there) {
        return None;
    }
    let mut steps = STEPS.0;
    let mut errors = read_at(machine, effect, axis, &evenly(from, to, steps))?;
    // a worm of many starts waves faster than the first steps can follow
    while errors.iter().any(is_coarse) && steps < STEPS.1 {
        steps *= 2;
        errors = read_at(machine, effect, axis, &evenly(from, to, steps))?;
    }
    Some(errors.into_iter().map(|error| (axis, error)).collect())
}

fn evenly(from: f64, to: f64, steps: usize) -> Vec<f64> {
    (0..=steps).map(|k| from + (to - from) * k as f64 / steps as f64).collect()
}

/// Whether a table's straight lines leave too much of its curve.
fn is_coarse(error: &ComponentError) -> bool {
    let ComponentForm::Table { value, .. } = &error.form else { return false };
    let largest = value.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
    value.windows(3).any(|near| (near[1] - 0.5 * (near[0] + near[2])).abs() > MOST_BEND * largest)
}

/// Tables of an effect of an axis at positions of it; components that it does not move have none. `None` where the way back does
/// otherwise than the way there, or where nothing acts while the axis moves alone.
fn read_at(machine: &Machine, effect: &Effect, axis: usize, position: &[f64]) -> Option<Vec<ComponentError>> {
    let there_and_back: Vec<f64> = position.iter().chain(position.iter().rev()).copied().collect();
    let disturbances = probed(machine, effect, axis, &there_and_back)?;
    let (there, back) = disturbances.by_test.first()?.split_at_checked(position.len())?;
    let mut errors = Vec::new();
    for component in Component::ALL {
        let read = |row: &Disturbance| row.motion[axis][component.index()];
        let value: Vec<f64> = there.iter().map(read).collect();
        if !is_alike(&value, &back.iter().rev().map(read).collect::<Vec<f64>>()) {
            return None;
        }
        if value.iter().any(|value| *value != 0.0) {
            let form = ComponentForm::Table { position: position.to_vec(), value };
            errors.push(ComponentError { component, form });
        }
    }
    let acts = effect.sizes.iter().any(|size| size.value != 0.0);
    (!acts || !errors.is_empty()).then_some(errors)
}

/// Share of the largest value by which two ways differ through rounding alone.
const ROUNDING: f64 = 1e-9;

/// Whether the values of two ways are the same; at the one position where a stretch begins or ends either of its values is right.
fn is_alike(there: &[f64], back: &[f64]) -> bool {
    let largest = there.iter().chain(back).fold(0.0f64, |largest, value| largest.max(value.abs()));
    let differs: Vec<bool> =
        there.iter().zip(back).map(|(there, back)| (there - back).abs() > ROUNDING * largest).collect();
    !differs.windows(2).any(|pair| pair[0] && pair[1])
}

/// What an effect does while one axis goes through positions, the others at zero; `None` where that cannot be computed.
fn probed(machine: &Machine, effect: &Effect, axis: usize, position: &[f64]) -> Option<Disturbances> {
    let session = session(machine, axis, position);
    let chain = Chain::of(machine);
    let context = Context::of(&session, &chain).ok()?;
    Disturbances::of(&context, std::slice::from_ref(effect)).ok()
}

/// Time from one position to the next, s: short, so that what settles with time is seen to.
const STEP_S: f64 = 1e-3;

/// One axis going through positions, the others at zero.
fn session(machine: &Machine, axis: usize, position: &[f64]) -> Session {
    let time_s: Vec<f64> = (0..position.len()).map(|k| k as f64 * STEP_S).collect();
    let ball = |link: &str, z: f64| Ball {
        link: link.into(),
        at: Vector3::new(0.0, 0.0, z),
        setup: None,
        spread_mm: None,
        indexed_about: None,
    };
    let mut positions = vec![Some(0.0); machine.axes.len()];
    positions[axis] = None;
    let recording = Recording {
        clock: Clock::TimeS(time_s),
        axes: vec![axis],
        positions: vec![position.to_vec()],
        length_mm: vec![0.0; position.len()],
        channels: Vec::new(),
        leading_texts: std::sync::Arc::default(),
        leading_header: String::new(),
        column: LengthColumn::default(),
        scatter: None,
    };
    let test = Test {
        name: "positions".into(),
        recording_file: None,
        recording: Some(recording),
        path: None,
        started_at_s: 0.0,
        bar_length_mm: None,
        bar_setup: None,
        zero: Zero::default(),
        bar_error_mm: 0.0,
        pivot: ball("w", 0.0),
        spindle_ball: ball("t", 100.0),
        positions,
        feed_mm_per_min: None,
        overshoot: None,
        marks: None,
        approached: Vec::new(),
        reading: Reading::Length,
    };
    Session {
        name: "positions".into(),
        machine_file: String::new(),
        machine: Machine { effects: Vec::new(), ..machine.clone() },
        spread: Spread::default(),
        tests: vec![test],
    }
}

//! Effects that depend on the position of their axis alone, as component errors of that axis. No effect's own formula.

use super::disturbance::Disturbances;
use crate::chain::Chain;
use crate::effects::{Context, Driver, kind};
use crate::machine::{AxisKind, Component, ComponentError, ComponentForm, Effect, Machine, Outlet, Place};
use crate::readings::Reading;
use crate::session::{Ball, Clock, LengthColumn, Recording, Session, Spread, Test, Zero};
use nalgebra::Vector3;

/// Steps over the travel of an axis at which an effect is read at first and at most.
const STEPS: (usize, usize) = (1440, 16 * 1440);
/// Share of an effect's largest value that a straight line over two steps may leave; over one it leaves a quarter of it.
const BENT: f64 = 0.01;
/// Travel of axes without a range, mm or rad on either side.
const OPEN_TRAVEL: (f64, f64) = (1000.0, std::f64::consts::TAU);

/// Takes effects that are functions of their axis's position into its component errors, by a table over the travel; those
/// that are constant go into the location errors. Names of the effects that are neither stay and are returned.
pub fn into_component_errors(machine: &mut Machine) -> Vec<String> {
    let effects = std::mem::take(&mut machine.effects);
    let mut left = Vec::new();
    for effect in effects {
        match as_component_errors(machine, &effect) {
            // forms of one component add up
            Some(errors) => {
                errors.into_iter().for_each(|(axis, error)| machine.axes[axis].component_errors.push(error))
            }
            None => {
                left.push(effect.kind.clone());
                machine.effects.push(effect);
            }
        }
    }
    left
}

/// Component errors that do the same; `None` where it depends on more than its axis's position.
fn as_component_errors(machine: &Machine, effect: &Effect) -> Option<Vec<(usize, ComponentError)>> {
    let Place::Axis(axis) = effect.place else { return None };
    let is_steady = kind(&effect.kind)?.driver == Driver::Position && effect.tests.is_none();
    let stays_there = |size: &crate::machine::Size| match size.outlet {
        Outlet::Motion { axis: of, .. } | Outlet::Along { axis: of } => of == axis,
        _ => false,
    };
    if !is_steady || !effect.sizes.iter().all(stays_there) {
        return None;
    }
    let own = &machine.axes[axis];
    let open = if own.kind == AxisKind::Linear { OPEN_TRAVEL.0 } else { OPEN_TRAVEL.1 };
    let (from, to) = own.range.unwrap_or((-open, open));
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
    value.windows(3).any(|near| (near[1] - 0.5 * (near[0] + near[2])).abs() > BENT * largest)
}

/// Tables of an effect of an axis at positions of it; components that it does not move have none.
fn read_at(machine: &Machine, effect: &Effect, axis: usize, position: &[f64]) -> Option<Vec<ComponentError>> {
    let session = session(machine, axis, position);
    let chain = Chain::of(machine);
    let context = Context::of(&session, &chain).ok()?;
    let disturbances = Disturbances::of(&context, std::slice::from_ref(effect)).ok()?;
    let rows = disturbances.by_test.first()?;
    let of_component = |component: Component| {
        let value: Vec<f64> = rows.iter().map(|row| row.motion[axis][component.index()]).collect();
        let is_there = value.iter().any(|value| *value != 0.0);
        let form = ComponentForm::Table { position: position.to_vec(), value };
        is_there.then_some(ComponentError { component, form })
    };
    Some(Component::ALL.into_iter().filter_map(of_component).collect())
}

/// Static poses of one axis, the others at zero.
fn session(machine: &Machine, axis: usize, position: &[f64]) -> Session {
    let poses: Vec<f64> = (0..position.len()).map(|k| k as f64).collect();
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
        clock: Clock::Pose(poses),
        axes: vec![axis],
        positions: vec![position.to_vec()],
        length_mm: vec![0.0; position.len()],
        channels: Vec::new(),
        leading_texts: Vec::new(),
        leading_header: String::new(),
        column: LengthColumn::default(),
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

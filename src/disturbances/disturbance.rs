//! Contributions of effects to rows: exact ones for `simulate`, linear columns for fits. No effect's own formula.

use crate::chain::Sensitivity;
use crate::effects::{Context, EffectError, Profile, kind, kind_names};
use crate::machine::{AxisKind, Effect, Outlet};
use nalgebra::Vector3;

/// What all effects together do at one row.
#[derive(Debug, Clone, PartialEq)]
pub struct Disturbance {
    /// Component errors to add, by axis: EX EY EZ mm, EA EB EC rad.
    pub motion: Vec<[f64; 6]>,
    /// Actual minus commanded position by axis, mm or rad.
    pub position: Vec<f64>,
    /// Displacement of the pivot ball on its link, mm.
    pub pivot_mm: Vector3<f64>,
    /// Displacement of the spindle ball on its link, mm.
    pub spindle_mm: Vector3<f64>,
    /// Reading minus distance, mm.
    pub reading_mm: f64,
}

/// Disturbances of a whole session.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Disturbances {
    /// Location errors to add to the machine's, by axis; empty when there is no effect.
    pub location: Vec<[f64; 6]>,
    /// By test in the order of the file, then by row; a test's list is empty when there is no effect.
    pub by_test: Vec<Vec<Disturbance>>,
}

impl Disturbances {
    /// What `effects` do to every row of a session.
    pub fn of(context: &Context, effects: &[Effect]) -> Result<Disturbances, EffectError> {
        let axes = context.machine().axes.len();
        if effects.is_empty() {
            return Ok(Disturbances { location: vec![[0.0; 6]; axes], by_test: vec![Vec::new(); context.tests()] });
        }
        let still = Disturbance {
            motion: vec![[0.0; 6]; axes],
            position: vec![0.0; axes],
            pivot_mm: Vector3::zeros(),
            spindle_mm: Vector3::zeros(),
            reading_mm: 0.0,
        };
        let mut sum = Disturbances {
            location: vec![[0.0; 6]; axes],
            by_test: (0..context.tests()).map(|test| vec![still.clone(); context.motion(test).rows()]).collect(),
        };
        for effect in effects {
            let kind = kind(&effect.kind).ok_or_else(|| EffectError::UnknownKind {
                found: effect.kind.clone(),
                known: kind_names().join(", "),
            })?;
            let profiles = kind.shape(context, effect)?;
            let functions = (kind.functions)(effect);
            for size in &effect.sizes {
                let Some(index) = functions.iter().position(|name| *name == size.function) else { continue };
                sum.add(context, &size.outlet, size.value, &profiles[index]);
            }
        }
        Ok(sum)
    }

    fn add(&mut self, context: &Context, outlet: &Outlet, size: f64, profile: &Profile) {
        if let Outlet::Location { axis, component } = *outlet {
            // a location error is the same in every row
            let value = profile.iter().flatten().next().copied().unwrap_or(0.0);
            self.location[axis][component.index()] += size * value;
            return;
        }
        for (test, rows) in self.by_test.iter_mut().enumerate() {
            for (row, (disturbance, value)) in rows.iter_mut().zip(&profile[test]).enumerate() {
                disturbance.add(context, (test, row), outlet, size * value);
            }
        }
    }
}

impl Disturbance {
    fn add(&mut self, context: &Context, (test, row): (usize, usize), outlet: &Outlet, amount: f64) {
        match *outlet {
            Outlet::Motion { axis, component } => self.motion[axis][component.index()] += amount,
            Outlet::Along { axis } => {
                let joint = context.chain().joint(axis);
                for k in 0..3 {
                    self.motion[axis][own_offset(joint.kind) + k] += amount * joint.direction[k];
                }
            }
            Outlet::Lag { axis } => self.position[axis] -= amount * context.speed(test, row, axis),
            Outlet::Acceleration { axis } => self.position[axis] += amount * context.acceleration(test, row, axis),
            Outlet::SlidesAcceleration { .. } => {
                for axis in context.machine().axes_of(AxisKind::Linear) {
                    self.position[axis] += amount * context.acceleration(test, row, axis);
                }
            }
            Outlet::Delay => {
                for (axis, position) in self.position.iter_mut().enumerate() {
                    *position += amount * context.speed(test, row, axis);
                }
            }
            Outlet::Pivot(k) => self.pivot_mm[k] += amount,
            Outlet::SpindleBall(k) => self.spindle_mm[k] += amount,
            Outlet::Reading => self.reading_mm += amount,
            // constant over the session: added to the geometry instead
            Outlet::Location { .. } => {}
        }
    }
}

/// Where the own motion of an axis starts in EX EY EZ EA EB EC.
pub(super) fn own_offset(kind: AxisKind) -> usize {
    match kind {
        AxisKind::Linear => 0,
        AxisKind::Rotary => 3,
    }
}

/// Change of the reading per unit of an outlet at one row, mm per mm, rad, s or s².
pub fn gain(context: &Context, (test, row): (usize, usize), outlet: &Outlet, at: &Sensitivity) -> f64 {
    match *outlet {
        Outlet::Motion { axis, component } => at.motion[axis][component.index()],
        Outlet::Along { axis } => {
            let joint = context.chain().joint(axis);
            (0..3).map(|k| joint.direction[k] * at.motion[axis][own_offset(joint.kind) + k]).sum()
        }
        Outlet::Location { axis, component } => at.location[axis][component.index()],
        Outlet::Lag { axis } => -at.position[axis] * context.speed(test, row, axis),
        Outlet::Acceleration { axis } => at.position[axis] * context.acceleration(test, row, axis),
        Outlet::SlidesAcceleration { .. } => context
            .machine()
            .axes_of(AxisKind::Linear)
            .map(|axis| at.position[axis] * context.acceleration(test, row, axis))
            .sum(),
        Outlet::Delay => at.position.iter().enumerate().map(|(axis, gain)| gain * context.speed(test, row, axis)).sum(),
        Outlet::Pivot(k) => at.pivot[k],
        Outlet::SpindleBall(k) => at.spindle[k],
        Outlet::Reading => 1.0,
    }
}

/// First-order change of the readings of one test per unit size: `∂L/∂outlet · function`, row by row.
pub fn column(
    context: &Context,
    test: usize,
    sensitivities: &[Sensitivity],
    outlet: &Outlet,
    profile: &Profile,
) -> Vec<f64> {
    sensitivities
        .iter()
        .zip(&profile[test])
        .enumerate()
        .map(|(row, (at, value))| gain(context, (test, row), outlet, at) * value)
        .collect()
}

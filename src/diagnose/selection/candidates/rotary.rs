//! Candidates of a rotary axis. It judges nothing.

use super::curves::{postures, unknown};
use super::family::{CandidateFamily, Refined, list_of, number, refined};
use super::growth::growth;
use super::lifts::stretches;
use super::motions::{directions, finest_step, motion, travelled, turns_against_gravity};
use super::play::{servo_lag, windup_refined, windups};
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::{
    CLAMP_LIFT, CYCLIC_ERROR, GRAVITY_SAG, LATERAL_PLAY, REVERSAL_SPIKE, ROTARY_BACKLASH, ROTARY_ERROR_MOTION,
};
use crate::machine::{Effect, Outlet, Place};
use std::f64::consts::PI;

/// Orders of a bearing's error motion that take part: the lowest ones, more, all.
const ERROR_MOTION_ORDERS: [usize; 3] = [2, 4, 8];

pub(super) fn rotary(model: &LinearModel, axis: usize, list: &mut Vec<CandidateFamily>) {
    let machine = model.context.machine();
    let place = Place::Axis(axis);
    let own = Outlet::own(machine, axis);
    let d = directions(machine, axis);
    let ends = travelled(model, axis);
    if let Some((from, to)) = ends {
        list.push(
            CandidateFamily::new(ROTARY_BACKLASH.name, place, vec![own], 60.0)
                .over(windups(model, ROTARY_BACKLASH.name, axis, 3f64.to_radians()))
                .refine(windup_refined(20f64.to_radians())),
        );
        for outlets in [motion(axis, &d.across), motion(axis, &[d.along]), motion(axis, &d.tilts)] {
            list.push(
                CandidateFamily::new(LATERAL_PLAY.name, place, outlets, 30.0)
                    .over(windups(model, LATERAL_PLAY.name, axis, 3f64.to_radians()))
                    .refine(windup_refined(20f64.to_radians())),
            );
        }
        list.push(
            CandidateFamily::new(REVERSAL_SPIKE.name, place, vec![own], 60.0)
                .over([0.3f64, 1.0, 3.0].map(|d| number(REVERSAL_SPIKE.name, place, "travel", d.to_radians())).to_vec())
                .refine(vec![refined("travel", 0.01f64.to_radians(), 20f64.to_radians(), 0.5)])
                .fast(),
        );
        let arc = to - from;
        let lowest = if arc > 1.8 * PI { 1.0 } else { (2.0 * PI / arc).max(1.0) };
        let orders: Vec<f64> = if arc > 1.8 * PI {
            (1..=8).map(f64::from).collect()
        } else {
            // half waves of the arc: a bearing's orders cannot be told apart over part of a turn
            (1..=8).map(|k| f64::from(k) * PI / arc).filter(|order| *order > 1.5).collect()
        };
        // the low orders alone stand out of the noise where the error is small
        let up_to = |count: usize| {
            let orders = orders[..count.min(orders.len())].to_vec();
            Effect::new(ROTARY_ERROR_MOTION.name, place).with("orders", list_of(orders))
        };
        let error_motion = ERROR_MOTION_ORDERS.map(up_to).to_vec();
        for outlets in [motion(axis, &d.across), motion(axis, &[d.along]), motion(axis, &d.tilts)] {
            list.push(CandidateFamily::new(ROTARY_ERROR_MOTION.name, place, outlets, 10.0).over(error_motion.clone()));
        }
        let highest = 0.4 * 2.0 * PI / finest_step(model, axis);
        let step = (PI / arc).max(0.5);
        let cyclic = |n: f64| Effect::new(CYCLIC_ERROR.name, place).with("orders", list_of(vec![n]));
        let mut grid = Vec::new();
        let mut n = lowest;
        while n < highest.min(400.0) {
            grid.push(cyclic(n));
            n += step;
        }
        list.push(
            CandidateFamily::new(CYCLIC_ERROR.name, place, vec![own], 30.0)
                .over(grid)
                .refine(vec![Refined { name: "orders", least: 0.5, most: 500.0, step: 0.5 * step, element: Some(0) }])
                .fast(),
        );
        list.extend(servo_lag(model, axis));
        let (stretches, shape) = stretches(place, (from, to), 6f64.to_radians());
        let lifted = [d.along, d.tilts[0], d.tilts[1]];
        let tipped = [&d.across[..], &d.tilts].concat();
        for components in [&lifted[..], &tipped, &[d.along]] {
            let family = CandidateFamily::new(CLAMP_LIFT.name, place, motion(axis, components), 30.0);
            list.push(family.over(stretches.clone()).refine(shape.clone()));
        }
        let postures = postures(model, axis);
        for outlets in [motion(axis, &d.across), motion(axis, &[d.along]), motion(axis, &d.tilts), vec![own]] {
            for driver in ["position", "direction"] {
                list.push(unknown(place, axis, machine, outlets.clone(), (from, to), driver));
            }
            for tests in &postures {
                let mut family = unknown(place, axis, machine, outlets.clone(), (from, to), "position");
                family.grid.iter_mut().for_each(|effect| effect.tests = Some(tests.clone()));
                list.push(family);
            }
        }
    }
    if turns_against_gravity(model, axis) {
        let components = [d.across[0], d.across[1], d.tilts[0], d.tilts[1]];
        let mut outlets = motion(axis, &components);
        outlets.push(own);
        let whole = CandidateFamily::new(GRAVITY_SAG.name, place, outlets, 30.0);
        list.push(CandidateFamily { functions: &["x", "y", "z"], ..whole.clone() });
        // a body that bends in its own frame adds products of gravity's components
        list.push(whole);
    }
    let growing = [d.along, d.tilts[0], d.tilts[1]];
    // a table that grows also shifts and tilts
    let whole = [&growing[..], &d.across].concat();
    for components in [&d.across[..], &[d.along], &d.tilts, &growing, &whole] {
        list.push(growth(model, place, motion(axis, components)));
    }
}

//! Candidates of a linear axis. It judges nothing.

use super::curves::unknown;
use super::family::{CandidateFamily, Refined, list_of, refined};
use super::growth::growth;
use super::motions::last_before_spindle;
use super::motions::{directions, finest_step, motion, travelled, visited};
use super::play::{servo_lag, spikes, windup_refined, windups};
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::{
    CYCLIC_ERROR, LATERAL_PLAY, LINEAR_BACKLASH, LINEAR_SCALE, RADIUS_LOSS, REVERSAL_SPIKE, SQUARENESS, STRAIGHTNESS,
};
use crate::machine::{Component, Effect, Machine, Outlet, ParameterValue, Place};

/// Customary leads of ball screws, mm (ISO 3408-2).
const SCREW_LEADS_MM: [f64; 9] = [4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0];

/// Places at which a slide must have stood before a period can be told.
const LEAST_PLACES: usize = 5;

pub(super) fn linear(model: &LinearModel, axis: usize, list: &mut Vec<CandidateFamily>) {
    let machine = model.context.machine();
    let place = Place::Axis(axis);
    let own = Outlet::own(machine, axis);
    let d = directions(machine, axis);
    let all_across = [d.across[0], d.across[1], d.tilts[0], d.tilts[1], Component::ALL[d.along.index() + 3]];
    let (least, most) = visited(model, axis);
    if most - least > 1.0 {
        list.push(CandidateFamily::new(LINEAR_SCALE.name, place, vec![own], 300.0));
        // also for a slide that only moves from test to test: it stands on one or the other flank
        list.push(
            CandidateFamily::new(LINEAR_BACKLASH.name, place, vec![own], 30.0)
                .over(windups(model, LINEAR_BACKLASH.name, axis, 2.0))
                .refine(windup_refined(40.0)),
        );
    }
    if let Some((from, to)) = travelled(model, axis) {
        for component in all_across {
            list.push(
                CandidateFamily::new(LATERAL_PLAY.name, place, motion(axis, &[component]), 20.0)
                    .over(windups(model, LATERAL_PLAY.name, axis, 2.0))
                    .refine(windup_refined(40.0)),
            );
        }
        list.push(
            CandidateFamily::new(REVERSAL_SPIKE.name, place, vec![own], 30.0)
                .over(spikes(place))
                .refine(vec![
                    refined("travel", 0.02, 20.0, 0.7),
                    refined("servo_hz", 0.2, 60.0, 0.4),
                    Refined { name: "damping", least: 0.05, most: 3.0, step: 0.15, element: None },
                ])
                .fast(),
        );
        list.extend(servo_lag(model, axis));
        list.push(CandidateFamily::new(RADIUS_LOSS.name, place, vec![Outlet::Acceleration { axis }], 1e4).fast());
        let lowest_period = 3.0 * finest_step(model, axis);
        let mut grid = Vec::new();
        let mut frequency = 2.0 / (to - from);
        while 1.0 / frequency > lowest_period && grid.len() < 400 {
            grid.push(Effect::new(CYCLIC_ERROR.name, place).with("periods", list_of(vec![1.0 / frequency])));
            frequency += 0.5 / (to - from);
        }
        if !grid.is_empty() {
            list.push(
                CandidateFamily::new(CYCLIC_ERROR.name, place, vec![own], 20.0)
                    .over(grid)
                    .refine(vec![Refined {
                        name: "periods",
                        least: lowest_period,
                        most: to - from,
                        step: 0.02,
                        element: Some(0),
                    }])
                    .fast(),
            );
        }
        for outlets in all_across.iter().map(|c| motion(axis, &[*c])).chain([vec![own]]) {
            for driver in ["position", "direction"] {
                list.push(unknown(place, axis, machine, outlets.clone(), (from, to), driver));
            }
        }
    }
    if travelled(model, axis).is_none() && standing_places(model, axis) >= LEAST_PLACES {
        // a screw's error shows between the places where a slide stands, but not its period: the customary leads are tried
        let lead = |mm: f64| Effect::new(CYCLIC_ERROR.name, place).with("periods", list_of(vec![mm]));
        list.push(
            CandidateFamily::new(CYCLIC_ERROR.name, place, vec![own], 20.0).over(SCREW_LEADS_MM.map(lead).to_vec()),
        );
    }
    let (from, to) = visited(model, axis);
    if to - from > 1.0 {
        for component in all_across {
            let mut grid = Vec::new();
            for share in [1.0, 0.5, 0.25, 0.12] {
                let width = share * (to - from);
                let mut centre = from;
                while centre <= to + 1e-9 {
                    let bump = Effect::new(STRAIGHTNESS.name, place).with("centre", ParameterValue::Number(centre));
                    grid.push(bump.with("width", ParameterValue::Number(width)));
                    centre += width / 4.0;
                }
            }
            let span = to - from;
            let with_slope: Vec<Effect> =
                grid.iter().map(|bump| bump.clone().with("slope", ParameterValue::Word("yes".into()))).collect();
            let shape = vec![
                Refined {
                    name: "centre",
                    least: from - 0.3 * span,
                    most: to + 0.3 * span,
                    step: 0.03 * span,
                    element: None,
                },
                Refined { name: "width", least: 0.05 * span, most: 2.0 * span, step: 0.05 * span, element: None },
                Refined { name: "skew", least: -0.8, most: 0.8, step: 0.2, element: None },
            ];
            if let Some(tilt) = tilt_of(axis, component, machine) {
                // a carriage that climbs a bump turns with its incline
                let outlets = motion(axis, &[component, tilt]);
                let pairs = outlets.iter().copied().zip(["bump", "slope"]).collect();
                let family = CandidateFamily::new(STRAIGHTNESS.name, place, outlets, 60.0)
                    .over(with_slope)
                    .refine(shape.clone());
                list.push(CandidateFamily { pairs, ..family });
            }
            list.push(
                CandidateFamily::new(STRAIGHTNESS.name, place, motion(axis, &[component]), 60.0)
                    .over(grid)
                    .refine(shape),
            );
            let bow = Effect::new(STRAIGHTNESS.name, place)
                .with("degrees", list_of(vec![2.0, 3.0]))
                .with("half_travel", ParameterValue::Number((to - from) / 2.0));
            list.push(CandidateFamily::new(STRAIGHTNESS.name, place, motion(axis, &[component]), 60.0).over(vec![bow]));
        }
        for tilt in d.tilts {
            list.push(CandidateFamily::new(
                SQUARENESS.name,
                place,
                vec![Outlet::Location { axis, component: tilt }],
                120.0,
            ));
        }
    }
    let mut tilting = vec![own];
    tilting.extend(motion(axis, &d.tilts));
    for outlets in [vec![own], motion(axis, &d.across), motion(axis, &d.tilts), tilting] {
        list.push(growth(model, place, outlets));
    }
    if last_before_spindle(model, axis) {
        // a spindle that grows also bends: along the slide with its tilts and shifts
        let mut outlets = vec![own];
        outlets.extend(motion(axis, &d.across));
        outlets.extend(motion(axis, &d.tilts));
        list.push(growth(model, place, outlets));
    }
}

/// Number of different places at which an axis stands.
fn standing_places(model: &LinearModel, axis: usize) -> usize {
    let first = |test: usize| model.context.motion(test).axis(axis).next();
    let mut places: Vec<f64> = (0..model.tests()).filter_map(first).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|one, other| (*one - *other).abs() < 0.1);
    places.len()
}

/// The tilt of a carriage that follows a straightness error: about what is square to its way and to the error.
fn tilt_of(axis: usize, component: Component, machine: &Machine) -> Option<Component> {
    let along = machine.axes[axis].own_component().index();
    let across = component.index();
    (across < 3).then(|| Component::ALL[3 + (3 - along - across)])
}

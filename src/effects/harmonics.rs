//! Errors that repeat with the position of an axis: error motion of rotary bearings and cyclic errors of drives and encoders.
//!
//! `E(q) = Σ_n a_n (cos n q − 1) + b_n sin n q`, n the order per turn (any number, bearings have odd ones) or
//! `n q = 2π q / period` on a slide: zero at position 0. Sidebands of an order are orders of their own.

use super::backlash::across;
use super::candidates::{CandidateFamily, Observations, PLAUSIBLE_OF_ARMS, Refined, directions, motion, with_list};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, list, plain_measure,
};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Machine, Outlet, Place};
use std::f64::consts::TAU;

const PARAMETERS: &[Parameter] = &[
    Parameter::list(
        "orders",
        ParameterUnit::Plain,
        DefaultValue::Absent,
        (1e-3, 1e6),
        "periods per turn of a rotary axis",
    ),
    Parameter::list("periods", ParameterUnit::Plain, DefaultValue::Absent, (1e-3, 1e5), "periods of a linear axis, mm"),
];

/// Error motion of a rotary axis across its own motion.
pub static ROTARY_ERROR_MOTION: Kind = Kind {
    name: "rotary-error-motion",
    driver: Driver::Position,
    formula: "E = sum a_n (cos n q - 1) + b_n sin n q",
    size_meaning: "amplitude of an order",
    cause: "out-of-round bearing races, worn or dirty table bearing, coupling pushing at its order",
    remedy: "inspect bearing and preload; orders at ball-pass numbers name the race",
    titles: &[("", "Error motion of the axis of {place} ({moving})")],
    measures: Some("at its largest"),
    notable: Notable { length: 1.0, angle: 2.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::WholeRange),
        rotary: Some(ShowingTest::Radial),
        other: ShowingTest::BothWays,
    },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Rotary],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::ErrorMotion,
    candidates: |seen| low_orders(seen).into_iter().chain(high_orders(seen)).collect(),
    candidates_of_poses: lines_of_arms,
    documented: Documented {
        place: "rotary axis",
        components: "all but own",
        functions: "`cosN = cos Nq − 1`, `sinN = sin Nq`",
        parameters: "`orders` per turn, any numbers (`periods` are for slides)",
        unit: "um, arcsec",
    },
    parameters: PARAMETERS,
    check: periods_of_its_axis,
    outlets: |machine, place| match place {
        Place::Axis(axis) if machine.axes[axis].kind == AxisKind::Rotary => across(machine, place),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions,
    profiles,
};

/// Error of an axis's own motion at any period.
pub static CYCLIC_ERROR: Kind = Kind {
    name: "cyclic-error",
    driver: Driver::Position,
    formula: "own = sum a_n (cos n q - 1) + b_n sin n q",
    size_meaning: "amplitude at its period",
    cause: "worm or gear tooth (orders at the tooth number), eccentric encoder disc (1 per turn), screw pitch",
    remedy: "centre the encoder, renew worm or screw bearing, or use the control's pitch compensation at that period",
    titles: &[("", "Cyclic error of {place}")],
    measures: Some("amplitude"),
    notable: Notable { length: 1.0, angle: 2.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::WholeRange),
        rotary: Some(ShowingTest::Tangential),
        other: ShowingTest::Circles,
    },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Rotary, AxisKind::Linear],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Period,
    candidates: periods,
    candidates_of_poses: angles_of_arms,
    documented: Documented {
        place: "any axis",
        components: "own",
        functions: "`cosN = cos Nq − 1`, `sinN = sin Nq`; period p mm on a slide; sidebands are orders of their own",
        parameters: "`orders` or `periods`",
        unit: "arcsec, um",
    },
    parameters: PARAMETERS,
    check: periods_of_its_axis,
    outlets: |machine, place| match place {
        Place::Axis(axis) => vec![Outlet::own(machine, axis)],
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions,
    profiles,
};

/// Orders go with a rotary axis, periods with a linear one.
fn periods_of_its_axis(machine: &Machine, effect: &Effect) -> Result<(), String> {
    let kind = effect.place.axis().map(|axis| machine.axes[axis].kind);
    let (orders, periods) = (list(effect, "orders").len(), list(effect, "periods").len());
    match kind {
        Some(AxisKind::Rotary) if orders == 0 || periods > 0 => {
            Err("a rotary axis has orders, e.g. orders: [2, 3]".into())
        }
        Some(AxisKind::Linear) if periods == 0 || orders > 0 => {
            Err("a linear axis has periods in mm, e.g. periods: [10]".into())
        }
        _ => Ok(()),
    }
}

/// `cos2`, `sin2`, … in the order of the parameters.
fn functions(effect: &Effect) -> Vec<String> {
    let orders = list(effect, "orders").iter().chain(list(effect, "periods"));
    orders.flat_map(|order| [format!("cos{order}"), format!("sin{order}")]).collect()
}

/// Phase of each order or period per rad or mm of the axis.
pub fn wave_numbers(effect: &Effect) -> impl Iterator<Item = f64> + '_ {
    let of_periods = list(effect, "periods").iter().map(|period| TAU / period);
    list(effect, "orders").iter().copied().chain(of_periods)
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let Place::Axis(axis) = effect.place else { return Ok(Vec::new()) };
    Ok(wave_numbers(effect)
        .flat_map(|n| {
            let [mut cosines, sines] = context.position_waves(axis, n);
            cosines.iter_mut().flatten().for_each(|value| *value -= 1.0);
            [cosines, sines]
        })
        .collect())
}

/// Orders of a bearing's error motion that take part: the lowest ones, more, all.
const ERROR_MOTION_ORDERS: [usize; 3] = [2, 4, 8];

/// Part of a turn from which the orders of a bearing can be told apart, rad.
const NEARLY_A_TURN: f64 = 0.9 * TAU;

fn low_orders(seen: &Observations) -> Vec<CandidateFamily> {
    let of_axis = |(axis, (from, to)): (usize, (f64, f64))| {
        let (d, place) = (directions(seen.machine(), axis), Place::Axis(axis));
        let arc = to - from;
        let orders: Vec<f64> = if arc > NEARLY_A_TURN {
            (1..=8).map(f64::from).collect()
        } else {
            // half waves of the arc: a bearing's orders cannot be told apart over part of a turn
            (1..=8).map(|k| f64::from(k) * TAU / (2.0 * arc)).filter(|order| *order > 1.5).collect()
        };
        // the low orders alone stand out of the noise where the error is small
        let up_to = |count: usize| {
            with_list(ROTARY_ERROR_MOTION.name, place, "orders", orders[..count.min(orders.len())].to_vec())
        };
        let grid = ERROR_MOTION_ORDERS.map(up_to).to_vec();
        [motion(axis, &d.across), motion(axis, &[d.along]), motion(axis, &d.tilts)]
            .map(|outlets| CandidateFamily::new(ROTARY_ERROR_MOTION.name, place, outlets, 10.0).over(grid.clone()))
    };
    // a joint that hardly moves shows no wave of its bearing
    let is_seen = |(_, (from, to)): &(usize, (f64, f64))| to - from > TAU / (2.0 * HIGHEST_ORDER);
    seen.moving(AxisKind::Rotary).filter(is_seen).flat_map(of_axis).collect()
}

/// Single orders beyond them: balls that pass, teeth of a ring that the drive pulls, poles of a motor.
const HIGH_ORDERS: std::ops::RangeInclusive<u32> = 9..=24;

/// Readings that a period must hold.
const LEAST_READINGS: f64 = 4.0;

/// Log odds against one of so many.
const ONE_OF_MANY: f64 = 2.8;

/// Error motion of one high order, on whole turns that the readings follow.
fn high_orders(seen: &Observations) -> Vec<CandidateFamily> {
    let whole = seen.moving(AxisKind::Rotary).filter(|(_, (from, to))| to - from > NEARLY_A_TURN);
    let of_axis = |(axis, _)| {
        let (d, place) = (directions(seen.machine(), axis), Place::Axis(axis));
        let step = seen.context.finest_step(axis);
        let followed = HIGH_ORDERS.map(f64::from).filter(|order| LEAST_READINGS * order * step < TAU);
        let grid: Vec<Effect> =
            followed.map(|order| with_list(ROTARY_ERROR_MOTION.name, place, "orders", vec![order])).collect();
        [motion(axis, &d.across), motion(axis, &[d.along]), motion(axis, &d.tilts)].map(|outlets| {
            let family = CandidateFamily::new(ROTARY_ERROR_MOTION.name, place, outlets, 10.0);
            family.over(grid.clone()).fast().rare(ONE_OF_MANY)
        })
    };
    whole.flat_map(of_axis).collect()
}

/// Low orders of an arm's joint line: a bearing race or a flange out of true.
const LINE_ORDERS: [&[f64]; 2] = [&[1.0], &[1.0, 2.0]];

fn lines_of_arms(seen: &Observations) -> Vec<CandidateFamily> {
    let mut list = Vec::new();
    for (axis, _) in seen.moving(AxisKind::Rotary) {
        let (d, place) = (directions(seen.machine(), axis), Place::Axis(axis));
        for orders in LINE_ORDERS {
            let grid = vec![with_list(ROTARY_ERROR_MOTION.name, place, "orders", orders.to_vec())];
            for outlets in [motion(axis, &[d.across[0], d.across[1], d.along]), motion(axis, &d.tilts)] {
                let line = CandidateFamily::new(ROTARY_ERROR_MOTION.name, place, outlets, PLAUSIBLE_OF_ARMS);
                list.push(line.over(grid.clone()));
            }
        }
    }
    list
}

/// Customary leads of ball screws, mm (ISO 3408-2).
const SCREW_LEADS_MM: [f64; 9] = [4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0];

/// Places, so far apart, mm, at which a slide must have stood before a period can be told.
const LEAST_PLACES: usize = 5;
const APART_MM: f64 = 0.1;

/// Orders beyond this are no drive's or encoder's that readings could follow; periods of a slide tried at most.
const HIGHEST_ORDER: f64 = 400.0;
const MOST_PERIODS: usize = 400;

fn periods(seen: &Observations) -> Vec<CandidateFamily> {
    // in an arm the weight of its links is the likelier cause of what turns once with a joint
    let rank = usize::from(!seen.context.has_sweeps());
    let rotary = seen.moving(AxisKind::Rotary).map(|(axis, ends)| orders_of_turn(seen, axis, ends));
    let geared = seen.moving(AxisKind::Rotary).filter_map(|(axis, ends)| orders_of_gears(seen, axis, ends));
    let moving = seen.moving(AxisKind::Linear).map(|(axis, ends)| periods_of_way(seen, axis, ends));
    let standing = seen.axes(AxisKind::Linear).filter(|&axis| seen.context.travelled(axis).is_none());
    // a screw's error shows between the places where a slide stands, but not its period: the customary leads are tried
    let shown = standing.filter(|&axis| seen.context.standing_places(axis, APART_MM) >= LEAST_PLACES).map(|axis| {
        let lead = |mm: f64| with_list(CYCLIC_ERROR.name, Place::Axis(axis), "periods", vec![mm]);
        let own = vec![Outlet::own(seen.machine(), axis)];
        CandidateFamily::new(CYCLIC_ERROR.name, Place::Axis(axis), own, 20.0).over(SCREW_LEADS_MM.map(lead).to_vec())
    });
    rotary.chain(geared).chain(moving).chain(shown).map(|family| family.ranked(rank)).collect()
}

/// Orders per turn of a rotary axis, as fine as the arc tells them apart and as high as neighbouring readings follow.
fn orders_of_turn(seen: &Observations, axis: usize, (from, to): (f64, f64)) -> CandidateFamily {
    let arc = to - from;
    let lowest = if arc > NEARLY_A_TURN { 1.0 } else { (TAU / arc).max(1.0) };
    orders_between(seen, axis, (lowest, highest_followed(seen, axis)), arc)
}

/// The highest order that neighbouring readings follow.
fn highest_followed(seen: &Observations, axis: usize) -> f64 {
    (0.4 * TAU / seen.context.finest_step(axis)).min(HIGHEST_ORDER)
}

/// Orders above those in static poses: the teeth of a joint's gear turn many times between two poses, and show where poses
/// stand at no regular steps.
fn orders_of_gears(seen: &Observations, axis: usize, (from, to): (f64, f64)) -> Option<CandidateFamily> {
    let lowest = highest_followed(seen, axis);
    let is_told = !seen.context.has_sweeps() && lowest < HIGHEST_ORDER && seen.context.is_irregular(axis);
    is_told.then(|| orders_between(seen, axis, (lowest, HIGHEST_ORDER), to - from))
}

fn orders_between(seen: &Observations, axis: usize, (lowest, highest): (f64, f64), arc: f64) -> CandidateFamily {
    let place = Place::Axis(axis);
    let step = (TAU / (2.0 * arc)).max(0.5);
    let mut grid = Vec::new();
    let mut order = lowest;
    while order < highest {
        grid.push(with_list(CYCLIC_ERROR.name, place, "orders", vec![order]));
        order += step;
    }
    CandidateFamily::new(CYCLIC_ERROR.name, place, vec![Outlet::own(seen.machine(), axis)], 30.0)
        .over(grid)
        .refine(vec![Refined::element("orders", 0, (0.5, 500.0), 0.5 * step)])
        .fast()
}

/// Periods of a slide, from half its way to what three readings show.
fn periods_of_way(seen: &Observations, axis: usize, (from, to): (f64, f64)) -> CandidateFamily {
    let place = Place::Axis(axis);
    let shortest = 3.0 * seen.context.finest_step(axis);
    let mut grid = Vec::new();
    let mut frequency = 2.0 / (to - from);
    while 1.0 / frequency > shortest && grid.len() < MOST_PERIODS {
        grid.push(with_list(CYCLIC_ERROR.name, place, "periods", vec![1.0 / frequency]));
        frequency += 0.5 / (to - from);
    }
    CandidateFamily::new(CYCLIC_ERROR.name, place, vec![Outlet::own(seen.machine(), axis)], 20.0)
        .over(grid)
        .refine(vec![Refined::element("periods", 0, (shortest, to - from), 0.02)])
        .fast()
}

/// Orders per turn of an arm's joint about its own line: eccentric encoder or gear, and, below one, a scale error of the angle.
const OWN_ORDERS: [&[f64]; 5] = [&[0.25], &[0.5], &[1.0], &[2.0], &[1.0, 2.0, 3.0]];

fn angles_of_arms(seen: &Observations) -> Vec<CandidateFamily> {
    let of_axis = |(axis, _)| {
        let place = Place::Axis(axis);
        OWN_ORDERS.map(|orders| {
            let own = vec![Outlet::own(seen.machine(), axis)];
            let family = CandidateFamily::new(CYCLIC_ERROR.name, place, own, PLAUSIBLE_OF_ARMS).ranked(1);
            family.over(vec![with_list(CYCLIC_ERROR.name, place, "orders", orders.to_vec())])
        })
    };
    seen.moving(AxisKind::Rotary).flat_map(of_axis).collect()
}

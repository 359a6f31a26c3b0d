//! Deflection of a joint or a slide under the weight of the joints beyond it, whose levers follow from the chain. Loads that were measured are in `compliance`, weights with free levers in `gravity`.
//!
//! `E = Σ c (m_k hⁿ − their value at zero)`, `m = Σ_l w_l (p_l − p) × g` in the carrier's frame, N·m: p_l the origins of the rotary joints
//! beyond, of the chain and of the branches under `carried`, p the origin of the place, w_l their weights. Where no masses are
//! stated every joint weighs one kilogram: what the arm really weighs is in the sizes. A slide has h, its distance from `middle` in
//! metres: a column bends the more the higher its carriage stands. What is there with all axes at zero is part of the location errors.

use nalgebra::{Rotation3, Unit, Vector3};

use super::candidates::{CandidateFamily, Observations, PLAUSIBLE_OF_ARMS, beside_own, directions, motion, none};
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, every_component,
    list, measure_per_load, word,
};
use super::load_frame::positions;
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::chain::{Chain, Geometry, LinkId, Pose};
use crate::machine::{AxisKind, CarriedBranch, Component, Effect, Machine, Outlet, ParameterValue, Place};

/// A joint or a slide that yields to the weight beyond it.
pub static WEIGHT_COMPLIANCE: Kind = Kind {
    name: "weight-compliance",
    driver: Driver::Gravity,
    formula: "E = sum c (m_k h^n - its value at zero), m = sum of weights times levers of the joints beyond, in the carrier's frame",
    size_meaning: "deflection per Nm, every joint beyond weighing 1 kg unless masses are stated",
    cause: "the weight of what is beyond winds up the gear, tilts the bearing or bends the link or the column",
    remedy: "compensate by the moment of the weight, stiffen or balance the joint; identify with the payload of use",
    titles: &[("", "Deflection of {place} under the weight beyond it ({moving})")],
    measures: Some("of deflection per Nm, 1 kg at every joint beyond"),
    notable: Notable { length: 0.1, angle: 0.1 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::Payload },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Weight,
    candidates: none,
    candidates_of_poses: yields,
    documented: Documented {
        place: "rotary or linear axis",
        components: "all",
        functions: "`own`: moment about the joint's line, `x y z`: about the directions of R, of the joints beyond (one kilogram at the origin of each), in the carrier's frame; of a slide `x y z`, with `h` and `hh` times its distance from `middle` in m and the square of that; less their values at the zero position",
        parameters: "`under` (axis), `masses`, `middle`",
        unit: "um, arcsec per Nm",
    },
    parameters: &[
        Parameter::word(
            "under",
            &[],
            DefaultValue::Absent,
            "rotary axis whose moment drives, where a tendon or a linkage leads it here; the place itself when not stated",
        ),
        Parameter::list(
            "masses",
            ParameterUnit::Plain,
            DefaultValue::Absent,
            (0.0, 1e5),
            "kg at the origins of the rotary joints beyond, those of the chain from the place outward, then those of branches under 'carried'; 1 each when not stated",
        ),
        Parameter::number(
            "middle",
            ParameterUnit::Position,
            DefaultValue::Number(0.0),
            (-1e5, 1e5),
            "position of a slide from which h is counted",
        ),
    ],
    check,
    outlets: |machine, place| match place {
        Place::Axis(axis) if bears(machine, axis) => every_component(machine, axis),
        _ => Vec::new(),
    },
    measure: measure_per_load,
    functions: |effect| match effect.parameter("middle") {
        Some(_) => ALONG_SLIDE.iter().map(|(name, ..)| name.to_string()).collect(),
        None => ABOUT.iter().map(|name| name.to_string()).collect(),
    },
    profiles,
};

/// Directions about which the moment of a joint acts.
const ABOUT: [&str; 4] = ["own", "x", "y", "z"];

/// Functions of a slide: direction of the moment, power of the distance.
const ALONG_SLIDE: [(&str, usize, i32); 9] = [
    ("x", 0, 0),
    ("y", 1, 0),
    ("z", 2, 0),
    ("xh", 0, 1),
    ("yh", 1, 1),
    ("zh", 2, 1),
    ("xhh", 0, 2),
    ("yhh", 1, 2),
    ("zhh", 2, 2),
];

/// Highest power of the distance.
const MOST_POWER: i32 = 2;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.80665;
/// mm in a metre.
const MM_PER_M: f64 = 1e3;

/// The axis whose moment drives an effect.
fn driving(machine: &Machine, effect: &Effect) -> Result<usize, String> {
    let place = effect.place.axis().unwrap_or_default();
    let Some(name) = word(effect, "under") else { return Ok(place) };
    let is_rotary = |axis: &usize| machine.axes[*axis].kind == AxisKind::Rotary;
    machine.axis_index(name).filter(is_rotary).ok_or_else(|| {
        let known = (0..machine.axes.len()).filter(is_rotary).map(|axis| machine.axes[axis].name.as_str());
        format!("under: no rotary axis is called '{name}' (allowed: {})", known.collect::<Vec<_>>().join(", "))
    })
}

/// Branches that hang beyond an axis.
fn hanging<'m>(machine: &'m Machine, chain: &Chain, axis: usize) -> Vec<&'m CarriedBranch> {
    let beyond = |branch: &&CarriedBranch| branch.on.is_some_and(|on| chain.carries(axis, chain.carried_by(on)));
    machine.carried.iter().filter(beyond).collect()
}

/// Rotary axes of the chain beyond an axis, from it outward.
fn beyond(chain: &Chain, axis: usize) -> Vec<usize> {
    let branch = chain.branch(chain.carried_by(axis).branch);
    let outward = branch.iter().skip_while(|&&other| other != axis).skip(1);
    outward.copied().filter(|&other| chain.joint(other).kind == AxisKind::Rotary).collect()
}

/// Whether any rotary joint is beyond an axis.
fn bears(machine: &Machine, axis: usize) -> bool {
    let chain = Chain::of(machine);
    !beyond(&chain, axis).is_empty() || !hanging(machine, &chain, axis).is_empty()
}

fn check(machine: &Machine, effect: &Effect) -> Result<(), String> {
    let Some(place) = effect.place.axis() else { return Ok(()) };
    let (is_slide, axis) = (machine.axes[place].kind == AxisKind::Linear, driving(machine, effect)?);
    if is_slide && word(effect, "under").is_some() {
        return Err("under: another joint's moment may lead to a rotary axis only; leave it out at a slide".into());
    }
    if is_slide != effect.parameter("middle").is_some() {
        return Err(match is_slide {
            true => "a slide needs the key 'middle', the position from which h is counted, e.g. middle: 0".into(),
            false => "middle: only a slide has it; leave it out at a rotary axis".into(),
        });
    }
    let chain = Chain::of(machine);
    let branches = hanging(machine, &chain, axis);
    for branch in &branches {
        if let Some(joint) = branch.joints.iter().find(|joint| joint.origin.is_none()) {
            return Err(format!(
                "joint '{}' of '{}' under 'carried' hangs beyond {} and has no origin; state it, e.g. origin: [0, 0, 400]",
                joint.name, branch.name, machine.axes[axis].name
            ));
        }
    }
    let joints = beyond(&chain, axis).len() + branches.iter().map(|branch| branch.joints.len()).sum::<usize>();
    match list(effect, "masses").len() {
        0 => Ok(()),
        stated if stated == joints => Ok(()),
        stated => {
            Err(format!("masses: {stated} are stated, {joints} rotary joints are beyond {}", machine.axes[axis].name))
        }
    }
}

/// What weighs on an axis.
struct Weight<'c> {
    geometry: Geometry<'c>,
    chain: &'c Chain,
    axis: usize,
    beyond: Vec<usize>,
    branches: Vec<&'c CarriedBranch>,
    /// kg, of the joints beyond and then of the branches; one each where there are none.
    masses: &'c [f64],
    /// Unit vector in R.
    gravity: Vector3<f64>,
}

impl<'c> Weight<'c> {
    fn on(context: &'c Context, effect: &'c Effect, axis: usize) -> Weight<'c> {
        let (machine, chain) = (context.machine(), context.chain());
        Weight {
            geometry: Geometry::nominal(chain),
            chain,
            axis,
            beyond: beyond(chain, axis),
            branches: hanging(machine, chain, axis),
            masses: list(effect, "masses"),
            gravity: machine.gravity,
        }
    }

    /// Moment about the axis's origin in the carrier's frame, N·m, at positions of the axes and of the joints of its branches, degrees.
    fn moment(&self, at: &[f64], carried: impl Fn(usize) -> f64) -> Vector3<f64> {
        let (geometry, chain, own) = (&self.geometry, self.chain, self.chain.carried_by(self.axis));
        let origin = |axis: usize| geometry.pose(chain.carried_by(axis), at, None).point(&chain.joint(axis).origin);
        let mut points: Vec<Vector3<f64>> = self.beyond.iter().map(|&axis| origin(axis)).collect();
        let mut joints = 0..;
        for branch in &self.branches {
            let on = branch.on.map_or(LinkId::BED, |on| chain.carried_by(on));
            let mut pose = geometry.pose(on, at, None);
            for (joint, number) in branch.joints.iter().zip(&mut joints) {
                let origin = joint.origin.unwrap_or_default();
                points.push(pose.point(&origin));
                let angle = if joint.reversed { -carried(number) } else { carried(number) }.to_radians();
                let rotation = Rotation3::from_axis_angle(&Unit::new_normalize(joint.direction), angle).into_inner();
                pose = pose.then(&Pose { rotation, translation_mm: origin - rotation * origin });
            }
        }
        let (place, mass) = (origin(self.axis), |k: usize| self.masses.get(k).copied().unwrap_or(1.0));
        let weighed = points.iter().enumerate().map(|(k, point)| (point - place) * mass(k));
        let first_moment = weighed.sum::<Vector3<f64>>() / MM_PER_M;
        let carrier = geometry.pose(LinkId { depth: own.depth.saturating_sub(1), ..own }, at, None);
        carrier.rotation.tr_mul(&first_moment.cross(&self.gravity)) * GRAVITY
    }

    /// The same at every row.
    fn moments(&self, context: &Context, effect: &Effect) -> Result<Vec<Vec<Vector3<f64>>>, EffectError> {
        let in_test = |test: usize| {
            let motion = context.motion(test);
            let joints = self.branches.iter().flat_map(|branch| &branch.joints);
            let columns: Vec<&[f64]> =
                joints.map(|joint| positions(context, &effect.kind, test, joint)).collect::<Result<_, _>>()?;
            let at = |row: usize| self.moment(motion.row(row), |joint| columns[joint][row]);
            Ok((0..motion.rows()).map(at).collect())
        };
        (0..context.tests()).map(in_test).collect()
    }
}

fn profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let (machine, Place::Axis(place)) = (context.machine(), effect.place) else { return Ok(Vec::new()) };
    let axis = driving(machine, effect).unwrap_or(place);
    let weight = Weight::on(context, effect, axis);
    let moments = weight.moments(context, effect)?;
    let at_zero = weight.moment(&vec![0.0; machine.axes.len()], |_| 0.0);
    if let Some(middle_mm) = effect.number("middle") {
        let height_m = |q: f64| (q - middle_mm) / MM_PER_M;
        let of_slide = |&(_, k, power): &(&str, usize, i32)| {
            let less = at_zero[k] * height_m(0.0).powi(power);
            let height_m = |test, row| height_m(context.motion(test).row(row)[place]);
            context.profile(|test, row| moments[test][row][k] * height_m(test, row).powi(power) - less)
        };
        return Ok(ALONG_SLIDE.iter().map(of_slide).collect());
    }
    let about = |k: usize| if k == 0 { machine.axes[axis].direction } else { Vector3::ith(k - 1, 1.0) };
    let of_joint = |k: usize| context.profile(|test, row| about(k).dot(&(moments[test][row] - at_zero)));
    Ok((0..ABOUT.len()).map(of_joint).collect())
}

/// Change of a moment over the rows below which it drives nothing, N·m.
const LEAST_CHANGE: f64 = 0.05;

/// What of a list of functions changes over the rows.
fn changes(seen: &Observations, effect: &Effect) -> Vec<bool> {
    let changes = |profile: &Profile| {
        let rows = || profile.iter().flatten();
        rows().copied().fold(f64::MIN, f64::max) - rows().copied().fold(f64::MAX, f64::min) > LEAST_CHANGE
    };
    profiles(seen.context, effect).map(|profiles| profiles.iter().map(changes).collect()).unwrap_or_default()
}

/// Joints that are parallel to one and next to it or to one that is: a tendon may lead the moment of each to the others.
fn parallel(seen: &Observations, axis: usize) -> Vec<usize> {
    let chain = seen.context.chain();
    let branch = chain.branch(chain.carried_by(axis).branch);
    let is_parallel = |other: &usize| {
        let (one, other) = (chain.joint(axis), chain.joint(*other));
        other.kind == AxisKind::Rotary && one.direction.cross(&other.direction).norm() < PARALLEL
    };
    let Some(place) = branch.iter().position(|other| *other == axis) else { return Vec::new() };
    let outward = branch[place + 1..].iter().copied().take_while(is_parallel);
    let inward = branch[..place].iter().rev().copied().take_while(is_parallel);
    inward.chain(outward).collect()
}

/// Sine of the angle between two lines up to which they are parallel.
const PARALLEL: f64 = 0.02;

/// What joints and slides yield to the weight beyond them.
fn yields(seen: &Observations) -> Vec<CandidateFamily> {
    let axes = 0..seen.machine().axes.len();
    axes.flat_map(|axis| match seen.machine().axes[axis].kind {
        AxisKind::Rotary => joint_yields(seen, axis),
        AxisKind::Linear => slide_yields(seen, axis),
    })
    .collect()
}

/// A joint about its line, across it, and about its line under the moments of parallel neighbours.
fn joint_yields(seen: &Observations, axis: usize) -> Vec<CandidateFamily> {
    let (machine, place) = (seen.machine(), Place::Axis(axis));
    let new = |outlets, effect| {
        CandidateFamily::new(WEIGHT_COMPLIANCE.name, place, outlets, PLAUSIBLE_OF_ARMS).over(vec![effect])
    };
    let is_known = |effect: &Effect| check(machine, effect).is_ok();
    let own = Outlet::own(machine, axis);
    let mut list = Vec::new();
    let effect = Effect::new(WEIGHT_COMPLIANCE.name, place);
    if is_known(&effect) {
        let changes = changes(seen, &effect);
        let changes = |k: usize| changes.get(k).copied().unwrap_or(false);
        if changes(0) {
            list.push(CandidateFamily { functions: &["own"], ..new(vec![own], effect.clone()) });
        }
        let tilts = directions(machine, axis).tilts.into_iter().filter(|tilt| changes(1 + tilt.direction_index()));
        let pairs: Vec<_> = tilts.map(|tilt| (Outlet::Motion { axis, component: tilt }, about(tilt))).collect();
        if !pairs.is_empty() {
            let (across, outlets) = (across(own, &pairs), pairs.iter().map(|(outlet, _)| *outlet).collect::<Vec<_>>());
            let with_own = outlets.iter().copied().chain([own]).collect();
            list.push(CandidateFamily { pairs, ..new(outlets, effect.clone()) });
            list.push(CandidateFamily { pairs: across, ..new(with_own, effect) });
        }
    }
    for other in parallel(seen, axis) {
        let name = ParameterValue::Word(machine.axes[other].name.clone());
        let effect = Effect::new(WEIGHT_COMPLIANCE.name, place).with("under", name);
        if is_known(&effect) && changes(seen, &effect).first().is_some_and(|changes| *changes) {
            list.push(CandidateFamily { functions: &["own"], ..new(vec![own], effect) });
        }
    }
    list
}

/// What a joint yields in one direction to the moment in another: a link is seldom even.
fn across(own: Outlet, tilts: &[(Outlet, &'static str)]) -> Vec<(Outlet, &'static str)> {
    let all = || [(own, ABOUT[0])].into_iter().chain(tilts.iter().copied());
    all().flat_map(|(outlet, own)| all().filter(move |(_, by)| *by != own).map(move |(_, by)| (outlet, by))).collect()
}

/// The function of the moment about the direction of a component.
fn about(component: Component) -> &'static str {
    ABOUT[1 + component.direction_index()]
}

/// A slide: turns of its carriage, and shifts of it as what carries the way bends at its foot.
fn slide_yields(seen: &Observations, axis: usize) -> Vec<CandidateFamily> {
    let place = Place::Axis(axis);
    let (least, most) = seen.context.visited(axis);
    let middle_mm = (0.5 * (least + most)).round();
    let effect = Effect::new(WEIGHT_COMPLIANCE.name, place).with("middle", ParameterValue::Number(middle_mm));
    if check(seen.machine(), &effect).is_err() {
        return Vec::new();
    }
    let changes = changes(seen, &effect);
    let driven_by = |power: i32, components: &[Component], by: &dyn Fn(Component, usize) -> bool| {
        let outlets = motion(axis, components);
        let of = |component: Component| {
            let functions = ALONG_SLIDE
                .iter()
                .zip(&changes)
                .filter(move |((_, k, p), changes)| **changes && *p == power && by(component, *k));
            functions.map(move |((name, ..), _)| (Outlet::Motion { axis, component }, *name))
        };
        let pairs: Vec<_> = components.iter().flat_map(|&component| of(component)).collect();
        let family = CandidateFamily::new(WEIGHT_COMPLIANCE.name, place, outlets, PLAUSIBLE_OF_ARMS);
        (!pairs.is_empty()).then(|| CandidateFamily { pairs, ..family.over(vec![effect.clone()]) })
    };
    let [across, other, tilt, other_tilt, roll] = beside_own(seen.machine(), axis);
    let own = directions(seen.machine(), axis).along.direction_index();
    let mut all = Vec::new();
    // each power by itself: one that the readings do not ask for leads astray at other heights
    for power in 0..=MOST_POWER {
        all.extend(driven_by(power, &[tilt, other_tilt, roll], &|component, k| component.direction_index() == k));
        all.extend(driven_by(power, &[across, other], &|component, k| component.direction_index() != k && k != own));
    }
    all
}

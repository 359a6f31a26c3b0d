//! The candidates of a search: which effect at which place through which outlets, over which grid of shapes. It judges nothing.

use std::f64::consts::PI;

use super::ground::{Ground, Term};
use super::pose_library::for_poses;
use super::spectrum::lines;
use crate::chain::Geometry;
use crate::effects::{OWN, ROTARY, SLIDES, kind};
use crate::machine::{AxisKind, Component, Effect, Machine, Outlet, ParameterValue, Place};

/// A family of candidates that differ only in shape.
#[derive(Debug, Clone)]
pub struct Family {
    pub kind: &'static str,
    pub place: Place,
    pub outlets: Vec<Outlet>,
    /// Shapes on the grid.
    pub grid: Vec<Effect>,
    /// Shape parameters that are refined: name, smallest, largest, first step (library units); index into a list.
    pub refined: Vec<Refined>,
    /// Amplitudes up to this are plausible, display units: the widest amplitude prior that is tried.
    pub plausible: f64,
    /// Every test has amplitudes of its own: the phase of a free-running source is not kept from test to test.
    pub by_test: bool,
    /// Names of the effect's functions that take part; empty: all.
    pub functions: &'static [&'static str],
    /// Outlets through which a function acts, where not every one acts through all.
    pub pairs: Vec<(Outlet, &'static str)>,
    /// It changes from row to row: it is judged on all rows, the others on averaged ones.
    pub fast: bool,
    /// Log odds against it before the readings speak, beside causes that are common.
    pub rarity: f64,
}

/// A shape parameter to refine.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    pub name: &'static str,
    pub least: f64,
    pub most: f64,
    pub step: f64,
    /// Element of a list parameter; `None` for a number.
    pub element: Option<usize>,
}

impl Family {
    /// Rank among names for the same signature: lower is the customary one (gauge squareness, growth at the spindle's slide).
    pub fn customary_rank(&self, ground: &Ground) -> usize {
        let machine = ground.context.machine();
        match (self.kind, self.outlets.first()) {
            ("squareness", Some(Outlet::Location { axis, component })) => {
                let gauge = [(Component::EC, 1), (Component::EB, 2), (Component::EA, 2)];
                let along = machine.axes[*axis].coordinate_direction();
                usize::from(!gauge.iter().any(|(c, k)| c == component && along == Some(*k)))
            }
            ("thermal-growth", _) => match self.place.axis() {
                Some(axis) if last_before_spindle(ground, axis) => self.outlets.len(),
                _ => 10,
            },
            // the axis under test is a rotary one as a rule, slides follow it
            ("unknown", _) => match self.place.axis() {
                Some(axis) if machine.axes[axis].kind == AxisKind::Rotary => 0,
                _ => 1,
            },
            // without a second feed lost motion is the likelier one
            ("servo-lag", _) => 1,
            // an axis that moves is the likelier source than a ball that moves just along it, or than an axis at rest
            ("vibration", _) => match self.place.axis() {
                Some(axis) if (0..ground.tests()).any(|test| ground.context.motion(test).moving.contains(&axis)) => 0,
                Some(_) => 2,
                None => 1,
            },
            // in an arm the weight of its links is the likelier cause of what turns once with a joint
            ("cyclic-error", _) if !ground.has_sweeps() => 1,
            _ => 0,
        }
    }

    pub(super) fn new(kind: &'static str, place: Place, outlets: Vec<Outlet>, plausible: f64) -> Family {
        Family {
            kind,
            place,
            outlets,
            grid: vec![Effect::new(kind, place)],
            refined: Vec::new(),
            plausible,
            by_test: false,
            functions: &[],
            pairs: Vec::new(),
            fast: false,
            rarity: 0.0,
        }
    }

    pub(super) fn over(mut self, grid: Vec<Effect>) -> Family {
        self.grid = grid;
        self
    }

    fn fast(mut self) -> Family {
        self.fast = true;
        self
    }

    fn refine(mut self, refined: Vec<Refined>) -> Family {
        self.refined = refined;
        self
    }
}

/// Terms of an effect: every function through every outlet.
pub fn terms(machine: &Machine, effect: &Effect, outlets: &[Outlet]) -> Vec<Term> {
    let Some(kind) = kind(&effect.kind) else { return Vec::new() };
    let functions = (kind.functions)(effect);
    outlets
        .iter()
        .flat_map(|outlet| {
            functions.iter().enumerate().map(|(function, name)| Term {
                outlet: *outlet,
                function,
                measure: (kind.measure)(machine, outlet, name),
                test: None,
            })
        })
        .collect()
}

/// Terms of a family's effect in a session of so many tests.
pub fn family_terms(machine: &Machine, family: &Family, effect: &Effect, tests: usize) -> Vec<Term> {
    let mut plain = terms(machine, effect, &family.outlets);
    if let Some(kind) = kind(&effect.kind) {
        let names = (kind.functions)(effect);
        let name = |term: &Term| names[term.function].as_str();
        plain.retain(|term| family.functions.is_empty() || family.functions.contains(&name(term)));
        plain.retain(|term| family.pairs.is_empty() || family.pairs.contains(&(term.outlet, name(term))));
    }
    if !family.by_test {
        return plain;
    }
    (0..tests).flat_map(|test| plain.iter().map(move |term| Term { test: Some(test), ..*term })).collect()
}

/// All families for a session.
pub fn families(ground: &Ground) -> Vec<Family> {
    let machine = ground.context.machine();
    let mut list = Vec::new();
    for axis in 0..machine.axes.len() {
        match machine.axes[axis].kind {
            AxisKind::Rotary => rotary(ground, axis, &mut list),
            AxisKind::Linear => linear(ground, axis, &mut list),
        }
    }
    if ground.has_sweeps() {
        tipping(ground, &mut list);
    }
    setup(ground, &mut list);
    if !ground.has_sweeps() {
        for_poses(ground, &mut list);
    }
    list
}

/// Motion outlets of an axis for some components.
pub(super) fn motion(axis: usize, components: &[Component]) -> Vec<Outlet> {
    components.iter().map(|&component| Outlet::Motion { axis, component }).collect()
}

/// Components across and along the nearest coordinate direction of an axis.
pub(super) struct Directions {
    pub across: [Component; 2],
    pub along: Component,
    pub tilts: [Component; 2],
}

pub(super) fn directions(machine: &Machine, axis: usize) -> Directions {
    let k = machine.axes[axis].own_component().direction_index();
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    Directions {
        across: [Component::ALL[i], Component::ALL[j]],
        along: Component::ALL[k],
        tilts: [Component::ALL[i + 3], Component::ALL[j + 3]],
    }
}

/// Smallest and largest position that recordings reach with an axis in motion; `None` when it never moves.
pub(super) fn travelled(ground: &Ground, axis: usize) -> Option<(f64, f64)> {
    let mut ends: Option<(f64, f64)> = None;
    for test in 0..ground.tests() {
        let motion = ground.context.motion(test);
        if motion.moving.contains(&axis) {
            for q in motion.axis(axis) {
                ends = Some(ends.map_or((q, q), |(from, to)| (from.min(q), to.max(q))));
            }
        }
    }
    ends.filter(|(from, to)| to - from > 1e-6)
}

/// Smallest and largest position of an axis, standing or moving.
fn visited(ground: &Ground, axis: usize) -> (f64, f64) {
    (0..ground.tests())
        .flat_map(|test| ground.context.motion(test).axis(axis))
        .fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(q), b.max(q)))
}

pub(super) fn list_of(values: Vec<f64>) -> ParameterValue {
    ParameterValue::List(values)
}

/// Orders of a bearing's error motion that take part: the lowest ones, more, all.
const ERROR_MOTION_ORDERS: [usize; 3] = [2, 4, 8];

fn rotary(ground: &Ground, axis: usize, list: &mut Vec<Family>) {
    let machine = ground.context.machine();
    let place = Place::Axis(axis);
    let own = Outlet::own(machine, axis);
    let d = directions(machine, axis);
    let ends = travelled(ground, axis);
    if let Some((from, to)) = ends {
        list.push(
            Family::new("rotary-backlash", place, vec![own], 60.0)
                .over(windups(ground, "rotary-backlash", axis, 3f64.to_radians()))
                .refine(windup_refined(20f64.to_radians())),
        );
        for outlets in [motion(axis, &d.across), motion(axis, &[d.along]), motion(axis, &d.tilts)] {
            list.push(
                Family::new("lateral-play", place, outlets, 30.0)
                    .over(windups(ground, "lateral-play", axis, 3f64.to_radians()))
                    .refine(windup_refined(20f64.to_radians())),
            );
        }
        list.push(
            Family::new("reversal-spike", place, vec![own], 60.0)
                .over([0.3f64, 1.0, 3.0].map(|d| number("reversal-spike", place, "travel", d.to_radians())).to_vec())
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
            Effect::new("rotary-error-motion", place).with("orders", list_of(orders))
        };
        let error_motion = ERROR_MOTION_ORDERS.map(up_to).to_vec();
        for outlets in [motion(axis, &d.across), motion(axis, &[d.along]), motion(axis, &d.tilts)] {
            list.push(Family::new("rotary-error-motion", place, outlets, 10.0).over(error_motion.clone()));
        }
        let highest = 0.4 * 2.0 * PI / finest_step(ground, axis);
        let step = (PI / arc).max(0.5);
        let cyclic = |n: f64| Effect::new("cyclic-error", place).with("orders", list_of(vec![n]));
        let mut grid = Vec::new();
        let mut n = lowest;
        while n < highest.min(400.0) {
            grid.push(cyclic(n));
            n += step;
        }
        list.push(
            Family::new("cyclic-error", place, vec![own], 30.0)
                .over(grid)
                .refine(vec![Refined { name: "orders", least: 0.5, most: 500.0, step: 0.5 * step, element: Some(0) }])
                .fast(),
        );
        list.extend(servo_lag(ground, axis));
        let postures = postures(ground, axis);
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
    if turns_against_gravity(ground, axis) {
        let components = [d.across[0], d.across[1], d.tilts[0], d.tilts[1]];
        let mut outlets = motion(axis, &components);
        outlets.push(own);
        let whole = Family::new("gravity-sag", place, outlets, 30.0);
        list.push(Family { functions: &["x", "y", "z"], ..whole.clone() });
        // a body that bends in its own frame adds products of gravity's components
        list.push(whole);
    }
    let growing = [d.along, d.tilts[0], d.tilts[1]];
    // a table that grows also shifts and tilts
    let whole = [&growing[..], &d.across].concat();
    for components in [&d.across[..], &[d.along], &d.tilts, &growing, &whole] {
        list.push(growth(ground, place, motion(axis, components)));
    }
}

/// Lag of an axis beyond that of the others; where slides move, also with the radius that a lag of all takes.
fn servo_lag(ground: &Ground, axis: usize) -> Vec<Family> {
    let place = Place::Axis(axis);
    let beyond = Family::new("servo-lag", place, vec![Outlet::Lag { axis }], 50.0).fast();
    let outlets = vec![Outlet::Lag { axis }, Outlet::SlidesAcceleration { axis }];
    let with_common = Family::new("servo-lag", place, outlets, 1e4).fast();
    if slides_move(ground) { vec![beyond, with_common] } else { vec![beyond] }
}

/// Whether any slide moves in any test.
fn slides_move(ground: &Ground) -> bool {
    let axes = &ground.context.machine().axes;
    (0..ground.tests())
        .any(|test| ground.context.motion(test).moving.iter().any(|&axis| axes[axis].kind == AxisKind::Linear))
}

/// Log odds against a joint that tips as another axis reverses.
const TIPS: f64 = 6.0;

/// Joints that tip to one or the other side as another axis goes one or the other way.
fn tipping(ground: &Ground, list: &mut Vec<Family>) {
    let machine = ground.context.machine();
    let axes = 0..machine.axes.len();
    for (driving, tipped) in axes.clone().flat_map(|driving| axes.clone().map(move |tipped| (driving, tipped))) {
        if driving == tipped || travelled(ground, driving).is_none() {
            continue;
        }
        let place = Place::Axis(tipped);
        let effect = number("lateral-play", place, "gap", 0.0)
            .with("of", ParameterValue::Word(machine.axes[driving].name.clone()));
        let outlets = motion(tipped, &directions(machine, tipped).tilts);
        list.push(Family { rarity: TIPS, ..Family::new("lateral-play", place, outlets, 30.0).over(vec![effect]) });
    }
}

/// Customary leads of ball screws, mm (ISO 3408-2).
const SCREW_LEADS_MM: [f64; 9] = [4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0];
/// Places at which a slide must have stood before a period can be told.
const LEAST_PLACES: usize = 5;

/// Number of different places at which an axis stands.
fn standing_places(ground: &Ground, axis: usize) -> usize {
    let first = |test: usize| ground.context.motion(test).axis(axis).next();
    let mut places: Vec<f64> = (0..ground.tests()).filter_map(first).collect();
    places.sort_by(f64::total_cmp);
    places.dedup_by(|one, other| (*one - *other).abs() < 0.1);
    places.len()
}

fn linear(ground: &Ground, axis: usize, list: &mut Vec<Family>) {
    let machine = ground.context.machine();
    let place = Place::Axis(axis);
    let own = Outlet::own(machine, axis);
    let d = directions(machine, axis);
    let all_across = [d.across[0], d.across[1], d.tilts[0], d.tilts[1], Component::ALL[d.along.index() + 3]];
    let (least, most) = visited(ground, axis);
    if most - least > 1.0 {
        // also for a slide that only moves from test to test: it stands on one or the other flank
        list.push(
            Family::new("linear-backlash", place, vec![own], 30.0)
                .over(windups(ground, "linear-backlash", axis, 2.0))
                .refine(windup_refined(40.0)),
        );
    }
    if let Some((from, to)) = travelled(ground, axis) {
        for component in all_across {
            list.push(
                Family::new("lateral-play", place, motion(axis, &[component]), 20.0)
                    .over(windups(ground, "lateral-play", axis, 2.0))
                    .refine(windup_refined(40.0)),
            );
        }
        list.push(
            Family::new("reversal-spike", place, vec![own], 30.0)
                .over(spikes(place))
                .refine(vec![
                    refined("travel", 0.02, 20.0, 0.7),
                    refined("servo_hz", 0.2, 60.0, 0.4),
                    Refined { name: "damping", least: 0.05, most: 3.0, step: 0.15, element: None },
                ])
                .fast(),
        );
        list.push(Family::new("linear-scale", place, vec![own], 300.0));
        list.extend(servo_lag(ground, axis));
        list.push(Family::new("radius-loss", place, vec![Outlet::Acceleration { axis }], 1e4).fast());
        let lowest_period = 3.0 * finest_step(ground, axis);
        let mut grid = Vec::new();
        let mut frequency = 2.0 / (to - from);
        while 1.0 / frequency > lowest_period && grid.len() < 400 {
            grid.push(Effect::new("cyclic-error", place).with("periods", list_of(vec![1.0 / frequency])));
            frequency += 0.5 / (to - from);
        }
        if !grid.is_empty() {
            list.push(
                Family::new("cyclic-error", place, vec![own], 20.0)
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
    if travelled(ground, axis).is_none() && standing_places(ground, axis) >= LEAST_PLACES {
        // a screw's error shows between the places where a slide stands, but not its period: the customary leads are tried
        let lead = |mm: f64| Effect::new("cyclic-error", place).with("periods", list_of(vec![mm]));
        list.push(Family::new("cyclic-error", place, vec![own], 20.0).over(SCREW_LEADS_MM.map(lead).to_vec()));
    }
    let (from, to) = visited(ground, axis);
    if to - from > 1.0 {
        for component in all_across {
            let mut grid = Vec::new();
            for share in [1.0, 0.5, 0.25, 0.12] {
                let width = share * (to - from);
                let mut centre = from;
                while centre <= to + 1e-9 {
                    let bump = Effect::new("straightness", place).with("centre", ParameterValue::Number(centre));
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
                let family = Family::new("straightness", place, outlets, 60.0).over(with_slope).refine(shape.clone());
                list.push(Family { pairs, ..family });
            }
            list.push(Family::new("straightness", place, motion(axis, &[component]), 60.0).over(grid).refine(shape));
            let bow = Effect::new("straightness", place)
                .with("degrees", list_of(vec![2.0, 3.0]))
                .with("half_travel", ParameterValue::Number((to - from) / 2.0));
            list.push(Family::new("straightness", place, motion(axis, &[component]), 60.0).over(vec![bow]));
        }
        for tilt in d.tilts {
            list.push(Family::new("squareness", place, vec![Outlet::Location { axis, component: tilt }], 120.0));
        }
    }
    let mut tilting = vec![own];
    tilting.extend(motion(axis, &d.tilts));
    for outlets in [vec![own], motion(axis, &d.across), motion(axis, &d.tilts), tilting] {
        list.push(growth(ground, place, outlets));
    }
    if last_before_spindle(ground, axis) {
        // a spindle that grows also bends: along the slide with its tilts and shifts
        let mut outlets = vec![own];
        outlets.extend(motion(axis, &d.across));
        outlets.extend(motion(axis, &d.tilts));
        list.push(growth(ground, place, outlets));
    }
}

/// The tilt of a carriage that follows a straightness error: about what is square to its way and to the error.
fn tilt_of(axis: usize, component: Component, machine: &Machine) -> Option<Component> {
    let along = machine.axes[axis].own_component().index();
    let across = component.index();
    (across < 3).then(|| Component::ALL[3 + (3 - along - across)])
}

/// The slide nearest to the spindle: where growth of the spindle shows.
fn last_before_spindle(ground: &Ground, axis: usize) -> bool {
    let chain = ground.context.chain();
    let machine = ground.context.machine();
    let branch = chain.branch(crate::chain::Branch::Tool);
    branch.iter().rev().find(|&&k| machine.axes[k].kind == AxisKind::Linear) == Some(&axis)
}

fn setup(ground: &Ground, list: &mut Vec<Family>) {
    let session = ground.context.session();
    let setups = ground.problem.setups;
    list.push(Family::new("trigger-latency", Place::Recorder, vec![Outlet::Delay], 200.0).fast());
    let one_test = |test: &usize| {
        let mut effect = Effect::new("trigger-latency", Place::Recorder);
        effect.tests = Some(vec![session.tests[*test].name.clone()]);
        effect
    };
    let tests = ground.context.order();
    if tests.len() > 1 {
        // lengths and positions of one test that were paired with a shift of some tenths of a second or more
        let shifted: Vec<Effect> = tests.iter().map(one_test).collect();
        list.push(Family::new("trigger-latency", Place::Recorder, vec![Outlet::Delay], 3000.0).over(shifted).fast());
    }
    let latest = tests.iter().map(|&test| ground.context.ends_at_s(test)).fold(0.0, f64::max);
    let slip = |kind: &'static str,
                place: Place,
                setup_of: &[usize],
                setup: usize,
                outlets: Vec<Outlet>,
                list: &mut Vec<Family>| {
        let mut grid = Vec::new();
        let mut first = true;
        for &test in tests.iter().filter(|&&test| setup_of[test] == setup) {
            let (from, to) = (session.tests[test].started_at_s, ground.context.ends_at_s(test));
            let shares: &[f64] = if first { &[0.2, 0.4, 0.6, 0.8] } else { &[-1e-6, 0.2, 0.4, 0.6, 0.8] };
            first = false;
            let ball =
                if place == Place::Pivot { &session.tests[test].pivot } else { &session.tests[test].spindle_ball };
            let shares = shares.iter().map(|share| from + share * (to - from));
            for time in shares.chain(jumps(ground, test)) {
                grid.push(
                    number(kind, place, "time", time)
                        .with("link", ParameterValue::Word(ball.link.clone()))
                        .with("at", list_of(vec![ball.at.x, ball.at.y, ball.at.z])),
                );
            }
        }
        if !grid.is_empty() {
            list.push(Family::new(kind, place, outlets, 30.0).over(grid).fast().refine(vec![
                Refined { name: "time", least: 0.0, most: latest, step: 3.0, element: None },
                Refined { name: "creep_share", least: 0.0, most: 1.0, step: 0.3, element: None },
                Refined { name: "creep_time", least: 0.5, most: 2000.0, step: 10.0, element: None },
            ]));
        }
    };
    for setup in 0..setups.pivots.len() {
        slip("pivot-slip", Place::Pivot, &setups.pivot_of, setup, (0..3).map(Outlet::Pivot).collect(), list);
    }
    for setup in 0..setups.spindle_balls.len() {
        slip(
            "ball-slip",
            Place::SpindleBall,
            &setups.spindle_ball_of,
            setup,
            (0..3).map(Outlet::SpindleBall).collect(),
            list,
        );
    }
    let first_slide = session.machine.axes.iter().position(|axis| axis.kind == AxisKind::Linear);
    if let Some(axis) = first_slide.filter(|_| slides_move(ground)) {
        let outlets = vec![Outlet::SlidesAcceleration { axis }];
        list.push(Family::new("radius-loss", Place::Control, outlets, 1e4).fast());
    }
    vibrations(ground, list);
    let span = latest.max(60.0);
    let growing: &[&str] = if setups.bars.len() > 1 { &["by-length", "alike"] } else { &["alike"] };
    for way in growing {
        let bar_growth = Effect::new("bar-length", Place::Bar).with("growing", ParameterValue::Word((*way).into()));
        let over_time = |share: f64| bar_growth.clone().with("tau", list_of(vec![share * span]));
        let mut family = Family::new("bar-length", Place::Bar, vec![Outlet::Reading], 30.0)
            .over([0.1, 0.3, 1.0].map(over_time).to_vec())
            .refine(vec![Refined { name: "tau", least: 10.0, most: 10.0 * span, step: 0.1 * span, element: Some(0) }]);
        family.functions = &["growth1"];
        list.push(family);
        for channel in channels(ground) {
            let effect = bar_growth.clone().with("channel", ParameterValue::Word(channel));
            let mut family = Family::new("bar-length", Place::Bar, vec![Outlet::Reading], 30.0)
                .over(lagging(&effect, span))
                .refine(vec![lag_refined(span)]);
            family.functions = &["kelvin"];
            list.push(family);
        }
    }
    for bar in &setups.bars {
        if let Some(length) = session.tests[bar.first_test].bar_length_mm {
            let effect = number("bar-length", Place::Bar, "bar", length);
            list.push(Family::new("bar-length", Place::Bar, vec![Outlet::Reading], 30.0).over(vec![effect]));
        }
    }
}

/// Lines of the spectrum that are tried.
const PEAKS: usize = 4;

/// Frequencies at which the traces together have the most power, tried as vibration of ball and joints.
fn vibrations(ground: &Ground, list: &mut Vec<Family>) {
    let machine = ground.context.machine();
    let lines: Vec<f64> = lines(ground, &ground.residual_mm).into_iter().take(PEAKS).map(|line| line.hz).collect();
    if lines.is_empty() {
        return;
    }
    let mut places: Vec<(Place, Outlet)> = (0..3).map(|k| (Place::SpindleBall, Outlet::SpindleBall(k))).collect();
    places.extend((0..machine.axes.len()).map(|axis| (Place::Axis(axis), Outlet::own(machine, axis))));
    let mut places: Vec<(Place, Vec<Outlet>)> = places.into_iter().map(|(place, one)| (place, vec![one])).collect();
    places.push((Place::SpindleBall, (0..3).map(Outlet::SpindleBall).collect()));
    for (place, outlets) in places {
        let clocked =
            |f: &f64| number("vibration", place, "frequency", *f).with("clock", ParameterValue::Word("test".into()));
        let mut family =
            Family::new("vibration", place, outlets, 10.0).over(lines.iter().map(clocked).collect()).fast();
        family.by_test = true;
        list.push(family.refine(vec![Refined {
            name: "frequency",
            least: 0.02,
            most: 1e3,
            step: 0.004,
            element: None,
        }]));
    }
}

/// Rows compared on each side of a possible jump.
const BESIDE: usize = 6;

/// Session times of the two largest jumps of a test's residual.
fn jumps(ground: &Ground, test: usize) -> Vec<f64> {
    let residual = &ground.residual_mm[test];
    let mean = |rows: std::ops::Range<usize>| -> f64 {
        let (sum, count) = rows
            .filter(|&row| ground.kept[test][row])
            .fold((0.0, 0usize), |(sum, count), row| (sum + residual[row], count + 1));
        if count == 0 { f64::NAN } else { sum / count as f64 }
    };
    let mut steps: Vec<(usize, f64)> = (BESIDE..residual.len().saturating_sub(BESIDE))
        .map(|row| (row, (mean(row..row + BESIDE) - mean(row - BESIDE..row)).abs()))
        .filter(|(_, step)| step.is_finite())
        .collect();
    steps.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut chosen: Vec<usize> = Vec::new();
    for (row, _) in steps {
        if chosen.len() == 2 {
            break;
        }
        if chosen.iter().all(|&other| other.abs_diff(row) > 3 * BESIDE) {
            chosen.push(row);
        }
    }
    // between the last row before the jump and the first behind it
    let time =
        |row: usize| 0.5 * (ground.context.session_time_s(test, row - 1) + ground.context.session_time_s(test, row));
    chosen.into_iter().map(time).collect()
}

/// Temperature columns that every recording has.
pub fn channels(ground: &Ground) -> Vec<String> {
    let tests = &ground.context.session().tests;
    let names = |index: usize| -> Vec<String> {
        let recording = tests.get(index).and_then(|test| test.recording.as_ref());
        recording.map(|recording| recording.channels.iter().map(|(name, _)| name.clone()).collect()).unwrap_or_default()
    };
    let common = names(0);
    common
        .into_iter()
        .filter(|name| name.starts_with("temp") && (0..tests.len()).all(|test| names(test).contains(name)))
        .collect()
}

/// Growth over session time (fast and slow node) or with a temperature channel.
fn growth(ground: &Ground, place: Place, outlets: Vec<Outlet>) -> Family {
    let span = ground.context.order().iter().map(|&test| ground.context.ends_at_s(test)).fold(60.0, f64::max);
    let pair = |fast: f64, slow: f64| Effect::new("thermal-growth", place).with("tau", list_of(vec![fast, slow]));
    let single = |share: f64| Effect::new("thermal-growth", place).with("tau", list_of(vec![share * span]));
    // one node first: two of them may cancel far beyond what the readings see
    let mut grid = [0.1, 0.3, 1.0].map(single).to_vec();
    grid.extend([pair(0.05 * span, 0.3 * span), pair(0.15 * span, 1.0 * span)]);
    grid.extend(heat_sources(ground, place).into_iter().flat_map(|source| {
        [pair(0.03 * span, 0.3 * span), pair(0.08 * span, 1.0 * span)]
            .map(|nodes| nodes.with("heat", ParameterValue::Word(source.into())))
    }));
    grid.extend(channels(ground).into_iter().flat_map(|channel| {
        lagging(&Effect::new("thermal-growth", place).with("channel", ParameterValue::Word(channel)), span)
    }));
    Family::new("thermal-growth", place, outlets, 100.0).over(grid).refine(vec![
        Refined { name: "tau", least: 20.0, most: 5.0 * span, step: 0.05 * span, element: Some(0) },
        Refined { name: "tau", least: 20.0, most: 5.0 * span, step: 0.2 * span, element: Some(1) },
        lag_refined(span),
    ])
}

/// Frictions that may heat a place: its own axis where it moves, and all axes of its kind where others move as well.
fn heat_sources(ground: &Ground, place: Place) -> Vec<&'static str> {
    let axes = &ground.context.machine().axes;
    let Some(axis) = place.axis() else { return Vec::new() };
    let moves = |axis: usize| (0..ground.tests()).any(|test| ground.context.motion(test).moving.contains(&axis));
    let others = (0..axes.len()).any(|other| other != axis && axes[other].kind == axes[axis].kind && moves(other));
    let alike = match axes[axis].kind {
        AxisKind::Linear => SLIDES,
        AxisKind::Rotary => ROTARY,
    };
    [moves(axis).then_some(OWN), others.then_some(alike)].into_iter().flatten().collect()
}

/// Lags of a part behind a temperature channel, as shares of the session.
const LAGS: [f64; 5] = [0.0, 0.02, 0.06, 0.2, 0.6];

fn lagging(effect: &Effect, span: f64) -> Vec<Effect> {
    LAGS.iter().map(|share| effect.clone().with("lag", ParameterValue::Number(share * span))).collect()
}

fn lag_refined(span: f64) -> Refined {
    Refined { name: "lag", least: 0.0, most: 2.0 * span, step: 0.03 * span, element: None }
}

/// Positions of a standing rotary axis closer than this are one posture, rad.
const SAME_POSTURE_RAD: f64 = 0.02;
/// Tests that a posture needs: one alone has no repeat.
const POSTURE_TESTS: usize = 2;

/// Names of the tests of an axis in which another rotary axis stands where it stands in fewer than half of them: what a cable, a load or a
/// table of the control does to an axis may hang on where another one stands.
fn postures(ground: &Ground, axis: usize) -> Vec<Vec<String>> {
    let session = ground.context.session();
    let axes = &session.machine.axes;
    let swept: Vec<usize> =
        (0..ground.tests()).filter(|&test| ground.context.motion(test).moving.contains(&axis)).collect();
    let mut list = Vec::new();
    for other in (0..axes.len()).filter(|&other| other != axis && axes[other].kind == AxisKind::Rotary) {
        let mut groups: Vec<(f64, Vec<usize>)> = Vec::new();
        for &test in &swept {
            let motion = ground.context.motion(test);
            if motion.moving.contains(&other) || motion.rows() == 0 {
                continue;
            }
            let at = motion.row(0)[other];
            match groups.iter_mut().find(|(place, _)| (place - at).abs() < SAME_POSTURE_RAD) {
                Some((_, tests)) => tests.push(test),
                None => groups.push((at, vec![test])),
            }
        }
        let few = groups.into_iter().map(|(_, tests)| tests);
        let few = few.filter(|tests| tests.len() >= POSTURE_TESTS && 2 * tests.len() < swept.len());
        for tests in few {
            let names = tests.iter().map(|&test| session.tests[test].name.clone()).collect();
            if !list.contains(&names) {
                list.push(names);
            }
        }
    }
    list
}

/// Free curve over the positions of an axis.
fn unknown(
    place: Place,
    axis: usize,
    machine: &Machine,
    outlets: Vec<Outlet>,
    ends: (f64, f64),
    driver: &str,
) -> Family {
    let kind = machine.axes[axis].kind;
    let effect = Effect::new("unknown", place)
        .with("driver", ParameterValue::Word(driver.into()))
        .with("from", ParameterValue::Number(kind.to_file_unit(ends.0)))
        .with("to", ParameterValue::Number(kind.to_file_unit(ends.1)))
        .with("count", ParameterValue::Number(14.0));
    Family::new("unknown", place, outlets, 30.0).over(vec![effect])
}

fn number(kind: &str, place: Place, name: &str, value: f64) -> Effect {
    Effect::new(kind, place).with(name, ParameterValue::Number(value))
}

/// Lost motion: all at once, half or all by wind-up; an axis that stands at first may stand on either flank.
fn windups(ground: &Ground, kind: &str, axis: usize, take_up: f64) -> Vec<Effect> {
    let base = |share: f64, start: f64| {
        number(kind, Place::Axis(axis), "take_up", take_up)
            .with("windup_share", ParameterValue::Number(share))
            .with("gap", ParameterValue::Number(0.0))
            .with("start", ParameterValue::Number(start))
    };
    let first = ground.context.order().first();
    let stands = first.is_some_and(|&test| !ground.context.motion(test).moving.contains(&axis));
    let starts: &[f64] = if stands { &[0.0, 1.0, -1.0] } else { &[0.0] };
    starts.iter().flat_map(|&start| [0.0, 0.5, 1.0].map(|share| base(share, start))).collect()
}

fn windup_refined(longest: f64) -> Vec<Refined> {
    vec![
        Refined { name: "windup_share", least: 0.0, most: 1.0, step: 0.25, element: None },
        Refined { name: "take_up", least: 1e-3 * longest, most: longest, step: 0.1 * longest, element: None },
    ]
}

fn spikes(place: Place) -> Vec<Effect> {
    let by_travel = [0.02, 0.1, 0.5, 2.0].map(|d| number("reversal-spike", place, "travel", d));
    let ringing = [1.0, 3.0, 8.0].map(|hz| {
        let servo = number("reversal-spike", place, "servo_hz", hz).with("damping", ParameterValue::Number(0.5));
        servo.with("travel", ParameterValue::Number(0.05))
    });
    by_travel.into_iter().chain(ringing).collect()
}

fn refined(name: &'static str, least: f64, most: f64, relative_step: f64) -> Refined {
    Refined { name, least, most, step: relative_step, element: None }
}

/// Median distance of neighbouring positions of an axis in motion.
fn finest_step(ground: &Ground, axis: usize) -> f64 {
    let mut steps: Vec<f64> = (0..ground.tests())
        .filter(|&test| ground.context.motion(test).moving.contains(&axis))
        .flat_map(|test| {
            let positions: Vec<f64> = ground.context.motion(test).axis(axis).collect();
            positions.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0).collect::<Vec<_>>()
        })
        .collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(1.0)
}

/// The load on the joint changes its direction to gravity in the session.
fn turns_against_gravity(ground: &Ground, axis: usize) -> bool {
    gravity_turns_in(ground, axis, |rows| {
        [0, rows / 2, rows.saturating_sub(1)].into_iter().filter(|&r| r < rows).collect()
    })
}

/// Whether gravity changes its direction in the link that an axis carries, over the rows that `looked_at` picks by their number.
pub(super) fn gravity_turns_in(ground: &Ground, axis: usize, looked_at: impl Fn(usize) -> Vec<usize>) -> bool {
    let chain = ground.context.chain();
    let geometry = Geometry::nominal(chain);
    let link = chain.carried_by(axis);
    let gravity = ground.context.machine().gravity;
    let mut first = None;
    (0..ground.tests()).any(|test| {
        let motion = ground.context.motion(test);
        looked_at(motion.rows()).into_iter().any(|row| {
            let seen = geometry.pose(link, motion.row(row), None).rotation.transpose() * gravity;
            (seen - *first.get_or_insert(seen)).norm() > 0.02
        })
    })
}

//! Growth with time or temperature: of a spindle, slide or joint, and of the bar. Of heat sources only friction is modelled.
//!
//! Time: `E = Σ_k s_k (1 − e^(−t/τ_k))`, t session time since `start`, two nodes for a fast and a slow mass. Static poses have
//! no times: there t may be the number of the pose.
//! Motion: the same nodes heated by the friction of axes as they move, see `friction_heat`; from work before the session
//! they may be warm, all of them alike (`warmth`) or each by an amount of its own (`begins: warm`).
//! Temperature: `E = s (T − T_first)` from a channel of the recordings, which the part follows with a `lag`; one that was
//! out of balance with the channel as the session began also settles with that lag.

use super::candidates::{
    CandidateFamily, Observations, PLAUSIBLE_OF_ARMS, Refined, directions, motion, none, with_list, with_word,
};
use super::channel::warming;
use super::context::Profile;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, NAMED_BAR, Notable, Parameter, ParameterUnit, Signature, Unseen, list,
    no_check, of_any_axis, read_with_a_bar, word,
};
use super::friction_heat::{Source, friction_heat};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Effect, Machine, Outlet, ParameterValue, Place};
use crate::units::Measure;

/// Name of the function that is driven by a temperature channel.
const KELVIN: &str = "kelvin";
/// Name of the function by which a part that follows a channel comes into balance with it.
const SETTLE: &str = "settle";

const TAU: Parameter = Parameter::list(
    "tau",
    ParameterUnit::Plain,
    DefaultValue::Absent,
    (1e-3, 1e7),
    "time constants of the nodes, s; functions are growth1, growth2, …",
);
const START: Parameter = Parameter::number(
    "start",
    ParameterUnit::Plain,
    DefaultValue::Number(0.0),
    (-1e7, 1e7),
    "session time at which the source was switched on, s",
);
const CHANNEL: Parameter = Parameter::word(
    "channel",
    &[],
    DefaultValue::Absent,
    "column of the recordings with the temperature, such as temperature_degC; the function is kelvin",
);

const LAG: Parameter = Parameter::number(
    "lag",
    ParameterUnit::Plain,
    DefaultValue::Number(0.0),
    (0.0, 1e7),
    "time constant with which the part follows the channel, s",
);

/// Clock of growth in static poses.
const POSES: &str = "poses";
const CLOCK: Parameter = Parameter::word(
    "clock",
    &["session", POSES],
    DefaultValue::Absent,
    "session: t, tau and start in s (when not stated); poses: in numbers of poses, for recordings without times",
);

/// Heat of the place's own axis.
pub const OWN: &str = "own";
/// Heat of all slides.
pub const SLIDES: &str = "slides";
/// Heat of all rotary axes.
pub const ROTARY: &str = "rotary";
const HEAT: Parameter = Parameter::word(
    "heat",
    &["steady", OWN, SLIDES, ROTARY],
    DefaultValue::Absent,
    "steady from start on (when not stated), or friction while the place's own axis, all slides or all rotary axes move: sizes are then steady growth at 1000 mm/min, or at 1 rpm",
);

/// A part that begins in balance, and one that does not.
pub const COLD: &str = "cold";
pub const WARM: &str = "warm";
const BEGINS: Parameter = Parameter::word(
    "begins",
    &[COLD, WARM],
    DefaultValue::Absent,
    "state of what friction heats, or of what follows a channel, as the session begins; warm adds settle1, settle2, …, or settle, by which it leaves that state",
);
const WARMTH: Parameter = Parameter::number(
    "warmth",
    ParameterUnit::Plain,
    DefaultValue::Absent,
    (0.0, 10.0),
    "warmth of all nodes that friction heats as the session begins, 1 as after long work at the speed of 'heat'; growth then counts from there",
);

/// Growth of spindle, slide or joint.
pub static THERMAL_GROWTH: Kind = Kind {
    name: "thermal-growth",
    driver: Driver::Time,
    formula: "E = sum s_k (1 - e^(-t/tau_k)), or sum s_k W_k, tau_k dW_k/dt = speed - W_k, or s (T - T_first), T followed with a lag",
    size_meaning: "growth of a node from cold to steady, or per K",
    cause: "heat of spindle, screw, table bearing or coolant that was not at rest when the session began",
    remedy: "warm up before measuring, repeat the first test at the end, use the control's thermal compensation",
    titles: &[("", "Thermal growth at {place} ({moving})")],
    measures: Some("in this session"),
    notable: Notable { length: 4.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::RepeatAtEnd },
    unseen: Unseen::Listed,
    unmoved: &[],
    form_error: 0.05,
    needs_runs: false,
    signature: Signature::Growth,
    candidates: growths,
    candidates_of_poses: warming_up,
    documented: Documented {
        place: "any axis",
        components: "all",
        functions: "`growthK = 1 − e^(−(t−start)/τ_K)`; with `heat` instead τ_K dW/dt = Σ|v|/v₀ − W of the axes that rub, v₀ 1000 mm/min or 1 rpm, none between tests, with `warmth` w all nodes begin at W = w and growth counts from there, and with `begins: warm` each begins where it likes, `settleK = 1 − e^(−t/τ_K)`; `kelvin = T − T_first` of a channel, which the part follows with a first-order `lag`, from a state out of balance with `begins: warm` (`settle`, from the first reading on)",
        parameters: "`tau`, `start`, `heat` (steady, own, slides, rotary), `begins` (cold, warm), `warmth`, `channel`, `lag` (s), `clock` (session, poses)",
        unit: "um, arcsec, per K",
    },
    parameters: &[TAU, START, HEAT, BEGINS, WARMTH, CHANNEL, LAG, CLOCK],
    check: heat_stands_alone,
    outlets: of_any_axis,
    measure,
    functions: |effect| growth_functions(effect),
    profiles: |context, effect| growth(&THERMAL_GROWTH, context, effect),
};

/// Error of the bar's calibrated length, and its growth.
pub static BAR_LENGTH: Kind = Kind {
    name: "bar-length",
    driver: Driver::Constant,
    formula: "reading = distance + s, + sum s_k (1 - e^(-t/tau_k)), + s (T - T_first)",
    size_meaning: "reading minus distance",
    cause: "calibration of another day or temperature, a loose extension, warmth of the hand",
    remedy: "calibrate the bar in the machine's room before the session and again after it",
    titles: &[("", "The bar is not as long as stated")],
    measures: None,
    notable: Notable { length: 2.0, angle: 2.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::RepeatAtEnd },
    unseen: Unseen::Listed,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::BarLength,
    candidates: bars,
    candidates_of_poses: none,
    documented: Documented {
        place: "`bar`",
        components: "`length`, reading minus distance",
        functions: "constant, `growthK`, `kelvin` (with these the constant is called `constant`)",
        parameters: "`tau`, `start`, `channel`, `lag`, `bar`, `growing` (alike, by-length)",
        unit: "um, um/K",
    },
    parameters: &[
        TAU,
        START,
        CHANNEL,
        LAG,
        NAMED_BAR,
        Parameter::word(
            "growing",
            &["alike", "by-length"],
            DefaultValue::Absent,
            "bars of several lengths grow alike (when not stated), or in proportion to their lengths: the size is the longest one's",
        ),
    ],
    check: no_check,
    outlets: read_with_a_bar,
    measure,
    functions: |effect| {
        let growing = growth_functions(effect);
        let constant = if growing.is_empty() { "" } else { "constant" };
        std::iter::once(constant.to_string()).chain(growing).collect()
    },
    profiles: bar_profiles,
};

/// Friction has a clock of its own; only a part that it heats, or that lags behind a channel, may begin warm.
fn heat_stands_alone(_: &Machine, effect: &Effect) -> Result<(), String> {
    let heated = is_heated(effect);
    let follows = word(effect, "channel").is_some();
    let is_warm = word(effect, "begins") == Some(WARM);
    if is_warm && !heated && !(follows && lags(effect)) {
        return Err(
            "'begins: warm' goes with 'heat: own', 'slides' or 'rotary', or with a 'channel' and a 'lag' above 0"
                .into(),
        );
    }
    if is_warm && effect.number("warmth").is_some() {
        return Err("'warmth' says how warm all nodes are, 'begins: warm' leaves it to each: one of them".into());
    }
    if effect.number("warmth").is_some() && !heated {
        return Err("'warmth' goes with 'heat: own', 'slides' or 'rotary'".into());
    }
    if heated && list(effect, "tau").is_empty() {
        return Err("'heat' needs time constants in 'tau'".into());
    }
    let other_clock = ["start", "clock"].into_iter().find(|name| effect.parameter(name).is_some());
    match other_clock {
        Some(name) if heated => Err(format!("'{name}' does not go with 'heat': axes heat when they move")),
        _ => Ok(()),
    }
}

fn is_heated(effect: &Effect) -> bool {
    !matches!(word(effect, "heat"), None | Some("steady"))
}

fn lags(effect: &Effect) -> bool {
    effect.number("lag").is_some_and(|lag| lag > 0.0)
}

fn measure(machine: &Machine, outlet: &Outlet, function: &str) -> Measure {
    match (outlet.measure(machine), function) {
        (Measure::Angle, KELVIN) => Measure::AnglePerKelvin,
        (_, KELVIN) => Measure::LengthPerKelvin,
        (plain, _) => plain,
    }
}

fn growth_functions(effect: &Effect) -> Vec<String> {
    let nodes = 1..=list(effect, "tau").len();
    let mut names: Vec<String> = nodes.clone().map(|k| format!("growth{k}")).collect();
    let warm = word(effect, "begins") == Some(WARM);
    if warm && is_heated(effect) {
        names.extend(nodes.map(|k| format!("settle{k}")));
    }
    if word(effect, "channel").is_some() {
        names.push(KELVIN.into());
        names.extend((warm && lags(effect)).then(|| SETTLE.into()));
    }
    names
}

fn growth(kind: &Kind, context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let start = kind.number(context, effect, "start");
    let by_pose = word(effect, "clock") == Some(POSES);
    let clock = |test: usize, row: usize| match by_pose {
        true => context.pose_number(test, row),
        false => context.session_time_s(test, row),
    };
    let steady = |tau: f64| {
        context.profile(|test, row| {
            let since = (clock(test, row) - start).max(0.0);
            -(-since / tau).exp_m1()
        })
    };
    let source = match (word(effect, "heat"), effect.place) {
        (Some(OWN), Place::Axis(axis)) => Some(Source::Axis(axis)),
        (Some(SLIDES), _) => Some(Source::All(AxisKind::Linear)),
        (Some(ROTARY), _) => Some(Source::All(AxisKind::Rotary)),
        _ => None,
    };
    let warmth = effect.number("warmth").unwrap_or(0.0);
    let node = |&tau: &f64| source.map_or_else(|| steady(tau), |source| friction_heat(context, source, tau, warmth));
    let nodes = list(effect, "tau");
    let mut profiles: Vec<Profile> = nodes.iter().map(node).collect();
    let warm = word(effect, "begins") == Some(WARM);
    if warm && is_heated(effect) {
        profiles.extend(nodes.iter().map(|tau| steady(*tau)));
    }
    if let Some(channel) = word(effect, "channel") {
        let felt = warming(context, kind.name, channel, kind.number(context, effect, "lag"))?;
        profiles.push(felt.kelvin);
        profiles.extend((warm && lags(effect)).then_some(felt.settled));
    }
    Ok(profiles)
}

fn bar_profiles(context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let mut profiles = growth(&BAR_LENGTH, context, effect)?;
    if word(effect, "growing") == Some("by-length") {
        let length = |test: usize| context.session().tests[test].bar_length_mm.unwrap_or(0.0);
        let longest = (0..context.tests()).map(length).fold(f64::MIN_POSITIVE, f64::max);
        for profile in &mut profiles {
            for (test, rows) in profile.iter_mut().enumerate() {
                rows.iter_mut().for_each(|value| *value *= length(test) / longest);
            }
        }
    }
    profiles.insert(0, context.profile(|_, _| 1.0));
    for profile in &mut profiles {
        let others = profile.iter_mut().enumerate().filter(|(test, _)| !context.has_named_bar(*test, effect));
        others.for_each(|(_, rows)| rows.fill(0.0));
    }
    Ok(profiles)
}

/// Shortest session that growth is laid out for, s.
const SHORTEST_S: f64 = 60.0;

/// Temperature columns that every recording has.
fn temperatures(seen: &Observations) -> Vec<String> {
    seen.context.common_channels(|name| name.starts_with("temp"))
}

/// Motions that grow together: of joints across, along and as tilts, alone and together; of slides along and with tilts, of the
/// one nearest to the spindle all at once, for a spindle that grows also bends.
fn growths(seen: &Observations) -> Vec<CandidateFamily> {
    let machine = seen.machine();
    let mut list = Vec::new();
    for axis in seen.axes(AxisKind::Rotary) {
        let d = directions(machine, axis);
        let growing = [d.along, d.tilts[0], d.tilts[1]];
        // a table that grows also shifts and tilts
        let whole = [&growing[..], &d.across].concat();
        for components in [&d.across[..], &[d.along], &d.tilts, &growing, &whole] {
            list.push(over_time(seen, axis, motion(axis, components)));
        }
    }
    for axis in seen.axes(AxisKind::Linear) {
        let d = directions(machine, axis);
        let own = vec![Outlet::own(machine, axis)];
        let (across, tilts) = (motion(axis, &d.across), motion(axis, &d.tilts));
        let tilting = [&own[..], &tilts].concat();
        let whole = [&own[..], &across, &tilts].concat();
        list.extend([own, across, tilts, tilting].map(|outlets| over_time(seen, axis, outlets)));
        if seen.context.is_last_before_spindle(axis) {
            list.push(over_time(seen, axis, whole));
        }
    }
    list
}

/// Rank of growth elsewhere than at the spindle's slide, of which the fewest motions are the customary name.
const ELSEWHERE: usize = 10;

/// Growth of a node up to this is plausible in a machine tool, µm or arcsec: spindles grow by some tens in their first hour
/// (ISO 230-3 tests find 10 to 80 µm). Two nodes that cancel are hundreds, and follow whatever changes from test to test.
const PLAUSIBLE: f64 = 30.0;

/// Growth over session time (fast and slow node), by friction, or with a temperature channel.
fn over_time(seen: &Observations, axis: usize, outlets: Vec<Outlet>) -> CandidateFamily {
    let (place, span) = (Place::Axis(axis), seen.latest_s().max(SHORTEST_S));
    let nodes = |taus: Vec<f64>| with_list(THERMAL_GROWTH.name, place, "tau", taus);
    let pair = |fast: f64, slow: f64| nodes(vec![fast * span, slow * span]);
    // one node first: two of them may cancel far beyond what the readings see
    let mut grid = [0.1, 0.3, 1.0].map(|share| nodes(vec![share * span])).to_vec();
    grid.extend([pair(0.05, 0.3), pair(0.15, 1.0)]);
    grid.extend(heat_sources(seen, axis).into_iter().flat_map(|source| {
        [pair(0.03, 0.3), pair(0.08, 1.0)].map(|nodes| nodes.with("heat", ParameterValue::Word(source.into())))
    }));
    grid.extend(
        temperatures(seen)
            .into_iter()
            .flat_map(|channel| lagging(&with_word(THERMAL_GROWTH.name, place, "channel", &channel), span)),
    );
    let rank = if seen.context.is_last_before_spindle(axis) { outlets.len() } else { ELSEWHERE };
    let shape = vec![
        Refined::element("tau", 0, (20.0, 5.0 * span), 0.05 * span),
        Refined::element("tau", 1, (20.0, 5.0 * span), 0.2 * span),
        lag_refined(span),
    ];
    CandidateFamily::new(THERMAL_GROWTH.name, place, outlets, PLAUSIBLE).over(grid).refine(shape).ranked(rank)
}

/// Frictions that may heat a place: its own axis where it moves, and all axes of its kind where others move as well.
fn heat_sources(seen: &Observations, axis: usize) -> Vec<&'static str> {
    let axes = &seen.machine().axes;
    let moves = |axis: usize| seen.context.moves(axis);
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
    Refined::number("lag", (0.0, 2.0 * span), 0.03 * span)
}

/// Time constants of an arm's warming up that are tried, in poses.
const WARMING_POSES: [f64; 4] = [15.0, 40.0, 100.0, 250.0];

/// Joints that drift while an arm warms up, by the number of the pose.
fn warming_up(seen: &Observations) -> Vec<CandidateFamily> {
    let of_axis = |axis: usize| {
        let place = Place::Axis(axis);
        let clock = with_word(THERMAL_GROWTH.name, place, "clock", POSES);
        let grid = WARMING_POSES.map(|tau| clock.clone().with("tau", ParameterValue::List(vec![tau])));
        let own = vec![Outlet::own(seen.machine(), axis)];
        let rank = if seen.context.is_last_before_spindle(axis) { own.len() } else { ELSEWHERE };
        CandidateFamily::new(THERMAL_GROWTH.name, place, own, PLAUSIBLE_OF_ARMS).over(grid.to_vec()).ranked(rank)
    };
    let axes = 0..seen.machine().axes.len();
    axes.filter(|&axis| seen.context.travelled(axis).is_some()).map(of_axis).collect()
}

/// Growth of bars over time or with a temperature, and the length of each that was calibrated.
fn bars(seen: &Observations) -> Vec<CandidateFamily> {
    let reading = || CandidateFamily::new(BAR_LENGTH.name, Place::Bar, vec![Outlet::Reading], 30.0);
    let span = seen.latest_s().max(SHORTEST_S);
    let growing: &[&str] = if seen.setups.bars.len() > 1 { &["by-length", "alike"] } else { &["alike"] };
    let mut list = Vec::new();
    for way in growing {
        let growth = with_word(BAR_LENGTH.name, Place::Bar, "growing", way);
        let over_time = |share: f64| growth.clone().with("tau", ParameterValue::List(vec![share * span]));
        let tau = Refined::element("tau", 0, (10.0, 10.0 * span), 0.1 * span);
        let family = reading().over([0.1, 0.3, 1.0].map(over_time).to_vec()).refine(vec![tau]);
        list.push(CandidateFamily { functions: &["growth1"], ..family });
        for channel in temperatures(seen) {
            let effect = growth.clone().with("channel", ParameterValue::Word(channel));
            let family = reading().over(lagging(&effect, span)).refine(vec![lag_refined(span)]);
            list.push(CandidateFamily { functions: &[KELVIN], ..family });
        }
    }
    let tests = &seen.context.session().tests;
    let calibrated = seen.setups.bars.iter().filter_map(|bar| tests[bar.first_test].bar_length_mm);
    list.extend(calibrated.map(|length| {
        reading().over(vec![Effect::new(BAR_LENGTH.name, Place::Bar).with("bar", ParameterValue::Number(length))])
    }));
    list
}

//! Lost motion on reversal: backlash of an axis along its own motion, and play across it. Friction spikes are in `reversal_spike`.
//!
//! `δ = −h·[(1 − w)·p + w·ε]`: p the play operator (Prandtl–Ishlinskii stop) of normalised gap, which turns from −1 to +1
//! over the free gap; ε the elastic wind-up, which relaxes towards the direction of motion as `e^(−travel/take_up)`.
//! Both depend on travel alone, not on speed, and keep their state from test to test.

use super::candidates::{CandidateFamily, Observations, Refined, beside_own, directions, motion, none, with_number};
use super::context::{Profile, Travel};
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, names_axis, no_check,
    plain_measure, single_function, word,
};
use super::memory::{MemoryLaw, Past};
use super::showing_test::{ShowingTest, ShownBy};
use super::{Context, EffectError};
use crate::machine::{AxisKind, Component, Effect, Machine, Outlet, ParameterValue, Place};

const PARAMETERS: &[Parameter] = &[
    Parameter::number(
        "take_up",
        ParameterUnit::Position,
        DefaultValue::Number(0.0),
        (0.0, 1e4),
        "travel over which wind-up turns round (1/e), mm or deg",
    ),
    Parameter::number(
        "windup_share",
        ParameterUnit::Plain,
        DefaultValue::Number(0.0),
        (0.0, 1.0),
        "share of the size that is elastic wind-up, the rest being free gap",
    ),
    Parameter::number(
        "gap",
        ParameterUnit::Position,
        DefaultValue::Absent,
        (0.0, 1e4),
        "travel over which the free gap turns round, mm or deg; when not stated twice the free share of the size, 0 for lateral play",
    ),
    Parameter::number(
        "start",
        ParameterUnit::Plain,
        DefaultValue::Number(0.0),
        (-1.0, 1.0),
        "flank before the first move of the session: 1 as after a move in the positive sense, 0 midway",
    ),
];

/// Play across may also follow another axis.
const ACROSS_PARAMETERS: &[Parameter] = &[
    PARAMETERS[0],
    PARAMETERS[1],
    PARAMETERS[2],
    PARAMETERS[3],
    Parameter::word(
        "of",
        &[],
        DefaultValue::Absent,
        "axis whose motion drives, travels being in its unit; the place when not stated",
    ),
];

/// Backlash of a rotary axis about its own line.
pub static ROTARY_BACKLASH: Kind = Kind {
    name: "rotary-backlash",
    driver: Driver::Direction,
    formula: "own = -h [(1-w) play(q, gap) + w windup(q, take_up)]",
    size_meaning: "half width",
    cause: "worm or gear clearance, wind-up of the drive, loose clamping of the encoder",
    remedy: "adjust the worm or preload, check the drive's stiffness, then set the control's backlash compensation",
    titles: &[("", "Backlash of {place}")],
    measures: Some("to each side of every reversal"),
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::EitherSide),
        rotary: Some(ShowingTest::Tangential),
        other: ShowingTest::BothWays,
    },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Rotary],
    form_error: 0.008,
    needs_runs: false,
    signature: Signature::Reversal,
    candidates: about_its_line,
    candidates_of_poses: none,
    documented: Documented {
        place: "rotary axis",
        components: "own (ECC)",
        functions: "`−[(1−w)·play + w·windup]`; play turns from −1 to 1 over `gap`, wind-up relaxes as e^(−travel/take_up)",
        parameters: "`take_up`, `windup_share`, `gap` (twice the free share when not stated), `start`: flank before the first move",
        unit: "arcsec, half width",
    },
    parameters: PARAMETERS,
    check: no_check,
    outlets: |machine, place| own(machine, place, AxisKind::Rotary),
    measure: plain_measure,
    functions: single_function,
    profiles: |context, effect| lost_motion(&ROTARY_BACKLASH, context, effect),
};

/// Backlash of a slide along its own direction.
pub static LINEAR_BACKLASH: Kind = Kind {
    name: "linear-backlash",
    driver: Driver::Direction,
    formula: "own = -h [(1-w) play(q, gap) + w windup(q, take_up)]",
    size_meaning: "half width",
    cause: "clearance of screw, nut or its bearings; wind-up of the drive between encoder and slide",
    remedy: "renew or preload nut and bearings, then set the control's backlash compensation",
    titles: &[("", "Lost motion of {place}")],
    measures: Some("to each side of every reversal"),
    notable: Notable { length: 1.5, angle: 1.5 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::Circles },
    unseen: Unseen::Listed,
    unmoved: &[AxisKind::Linear],
    form_error: 0.015,
    needs_runs: false,
    signature: Signature::Reversal,
    candidates: along_its_way,
    candidates_of_poses: none,
    documented: Documented {
        place: "slide",
        components: "own (EXX)",
        functions: "`−[(1−w)·play + w·windup]`; play turns from −1 to 1 over `gap`, wind-up relaxes as e^(−travel/take_up)",
        parameters: "`take_up`, `windup_share`, `gap` (twice the free share when not stated), `start`: flank before the first move",
        unit: "um, half width",
    },
    parameters: PARAMETERS,
    check: no_check,
    outlets: |machine, place| own(machine, place, AxisKind::Linear),
    measure: plain_measure,
    functions: single_function,
    profiles: |context, effect| lost_motion(&LINEAR_BACKLASH, context, effect),
};

/// Sideways shift or tilt of a joint that follows the direction of motion.
pub static LATERAL_PLAY: Kind = Kind {
    name: "lateral-play",
    driver: Driver::Direction,
    formula: "E = -h [(1-w) play(q, gap) + w windup(q, take_up)] across the own motion, q of the axis that drives",
    size_meaning: "half width",
    cause: "play of bearing or guideway, a drive that pushes off centre, a part that tips when another axis reverses",
    remedy: "preload the bearing or gibs, check the drive's alignment",
    titles: &[("", "Play of {place} across its motion ({moving})")],
    measures: Some("to each side of every reversal"),
    notable: Notable { length: 1.5, angle: 2.0 },
    shown_by: ShownBy {
        arm: Some(ShowingTest::EitherSide),
        rotary: Some(ShowingTest::Radial),
        other: ShowingTest::Circles,
    },
    unseen: Unseen::Listed,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Play,
    candidates: plays,
    candidates_of_poses: none,
    documented: Documented {
        place: "any axis",
        components: "all but own",
        functions: "`−[(1−w)·play + w·windup]`; play turns from −1 to 1 over `gap`, wind-up relaxes as e^(−travel/take_up)",
        parameters: "`take_up`, `windup_share`, `gap` (0 when not stated), `start`: flank before the first move; `of`: axis that drives, travels in its unit",
        unit: "um, arcsec, half width",
    },
    parameters: ACROSS_PARAMETERS,
    check: |machine, effect| names_axis(machine, effect, "of"),
    outlets: |machine, place| across(machine, place),
    measure: plain_measure,
    functions: single_function,
    profiles: |context, effect| lost_motion(&LATERAL_PLAY, context, effect),
};

fn own(machine: &Machine, place: Place, kind: AxisKind) -> Vec<Outlet> {
    match place {
        Place::Axis(axis) if machine.axes[axis].kind == kind => vec![Outlet::own(machine, axis)],
        _ => Vec::new(),
    }
}

/// All components of an axis but its own.
pub(super) fn across(machine: &Machine, place: Place) -> Vec<Outlet> {
    let Place::Axis(axis) = place else { return Vec::new() };
    let own = Outlet::own(machine, axis);
    let all = Component::ALL.into_iter().map(|component| Outlet::Motion { axis, component });
    all.filter(|outlet| *outlet != own).collect()
}

/// The law of a lost motion or play and the axis that drives it; `None` for other kinds.
pub(super) fn law(machine: &Machine, effect: &Effect, axis: usize) -> Option<(MemoryLaw, usize)> {
    let kind = [&ROTARY_BACKLASH, &LINEAR_BACKLASH, &LATERAL_PLAY].into_iter().find(|kind| kind.name == effect.kind)?;
    let driving = word(effect, "of").and_then(|name| machine.axis_index(name)).unwrap_or(axis);
    // travels were read in the unit of the place
    let travel = |value: f64| machine.axes[driving].kind.from_file_unit(machine.axes[axis].kind.to_file_unit(value));
    let windup_share = kind.number_of(machine, effect, "windup_share");
    let take_up = travel(kind.number_of(machine, effect, "take_up"));
    let own = Outlet::own(machine, axis);
    let size = effect.sizes.iter().find(|size| size.outlet == own).map_or(0.0, |size| size.value.abs());
    let gap = effect.number("gap").map(travel).unwrap_or(2.0 * size * (1.0 - windup_share));
    Some((MemoryLaw::LostMotion { windup_share, take_up, gap }, driving))
}

fn lost_motion(kind: &Kind, context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
    let found = effect.place.axis().and_then(|axis| law(context.machine(), effect, axis));
    let Some((law, driving)) = found else { return Ok(vec![context.profile(|_, _| 0.0)]) };
    let start = Past::on_flank(kind.number(context, effect, "start"));
    let advance = |past: &mut Past, travel: Travel| law.advance(past, travel.distance);
    Ok(vec![context.along(driving, start, advance, |past| law.value(past))])
}

/// Lost motion: all at once, half or all by wind-up; an axis that stands at first may stand on either flank.
fn windups(seen: &Observations, kind: &str, axis: usize, take_up: f64) -> Vec<Effect> {
    let base = |share: f64, start: f64| {
        with_number(kind, Place::Axis(axis), "take_up", take_up)
            .with("windup_share", ParameterValue::Number(share))
            .with("gap", ParameterValue::Number(0.0))
            .with("start", ParameterValue::Number(start))
    };
    let first = seen.context.order().first();
    let stands = first.is_some_and(|&test| !seen.context.motion(test).moving.contains(&axis));
    let starts: &[f64] = if stands { &[0.0, 1.0, -1.0] } else { &[0.0] };
    let free = |start: f64| base(0.0, start).with("gap", ParameterValue::Number(FIRST_GAP * take_up));
    let of_start = |&start: &f64| [0.0, 0.5, 1.0].map(|share| base(share, start)).into_iter().chain([free(start)]);
    starts.iter().flat_map(of_start).collect()
}

/// A free gap that is tried first, as a share of the travel of wind-up: a dead zone of 0.2 mm or 0.3° that turns round evenly.
const FIRST_GAP: f64 = 0.1;

/// Wind-up and gap, refined up to a longest travel, mm or rad.
fn windup_refined(longest: f64) -> Vec<Refined> {
    vec![
        Refined::number("windup_share", (0.0, 1.0), 0.25),
        Refined::number("take_up", (1e-3 * longest, longest), 0.1 * longest),
        Refined::number("gap", (0.0, longest), 0.02 * longest),
    ]
}

/// Travels over which wind-up turns round that are tried first, and longest ones, rad and mm.
const TAKE_UP_RAD: (f64, f64) = (3f64.to_radians(), 20f64.to_radians());
const TAKE_UP_MM: (f64, f64) = (2.0, 40.0);

fn about_its_line(seen: &Observations) -> Vec<CandidateFamily> {
    let (first, longest) = TAKE_UP_RAD;
    let about = |(axis, _)| {
        let own = vec![Outlet::own(seen.machine(), axis)];
        CandidateFamily::new(ROTARY_BACKLASH.name, Place::Axis(axis), own, 60.0)
            .over(windups(seen, ROTARY_BACKLASH.name, axis, first))
            .refine(windup_refined(longest))
            .turning_within_rows()
    };
    seen.moving(AxisKind::Rotary).map(about).collect()
}

/// Also of slides that only move from test to test: they stand on one or the other flank.
fn along_its_way(seen: &Observations) -> Vec<CandidateFamily> {
    let (first, longest) = TAKE_UP_MM;
    let along = |(axis, _)| {
        let own = vec![Outlet::own(seen.machine(), axis)];
        CandidateFamily::new(LINEAR_BACKLASH.name, Place::Axis(axis), own, 30.0)
            .over(windups(seen, LINEAR_BACKLASH.name, axis, first))
            .refine(windup_refined(longest))
            .turning_within_rows()
    };
    seen.displaced_slides().map(along).collect()
}

fn plays(seen: &Observations) -> Vec<CandidateFamily> {
    let machine = seen.machine();
    let play = |axis: usize, outlets: Vec<Outlet>, plausible: f64, (first, longest): (f64, f64)| {
        CandidateFamily::new(LATERAL_PLAY.name, Place::Axis(axis), outlets, plausible)
            .over(windups(seen, LATERAL_PLAY.name, axis, first))
            .refine(windup_refined(longest))
            .turning_within_rows()
    };
    let mut list = Vec::new();
    for (axis, _) in seen.moving(AxisKind::Rotary) {
        let d = directions(machine, axis);
        let outlets = [motion(axis, &d.across), motion(axis, &[d.along]), motion(axis, &d.tilts)];
        list.extend(outlets.map(|outlets| play(axis, outlets, 30.0, TAKE_UP_RAD)));
    }
    for (axis, _) in seen.moving(AxisKind::Linear) {
        list.extend(beside_own(machine, axis).map(|one| play(axis, motion(axis, &[one]), 20.0, TAKE_UP_MM)));
    }
    if seen.context.has_sweeps() {
        list.extend(tipping(seen));
    }
    list
}

/// Log odds against a joint that tips as another axis reverses, and against one that tips as an axis is only positioned:
/// it shows from test to test alone, as much else does.
const LOG_ODDS_AGAINST_TIPPING: f64 = 6.0;
const TIPS_BETWEEN: f64 = 8.0;

/// Travels of another axis over which a joint tips from side to side, mm or deg.
const TIPPING: [f64; 3] = [0.0, 0.6, 2.5];
/// Longest such travel, and the first step in which it is refined.
const LONGEST_TIPPING: f64 = 10.0;
const TIPPING_STEP: f64 = 0.6;

/// Way between tests below which an axis stands, mm or deg.
const LEAST_WAY: f64 = 0.1;

/// Joints that tip to one or the other side as another axis goes one or the other way, within tests or between them.
fn tipping(seen: &Observations) -> Vec<CandidateFamily> {
    let machine = seen.machine();
    let axes = 0..machine.axes.len();
    let mut list = Vec::new();
    for (driving, tipped) in axes.clone().flat_map(|driving| axes.clone().map(move |tipped| (driving, tipped))) {
        let (from, to) = seen.context.visited(driving);
        if driving == tipped || to - from < machine.axes[driving].kind.from_file_unit(LEAST_WAY) {
            continue;
        }
        let rarity = if seen.context.travelled(driving).is_some() { LOG_ODDS_AGAINST_TIPPING } else { TIPS_BETWEEN };
        let place = Place::Axis(tipped);
        // travels of the driving axis are written in the unit of the place
        let travel = |of: f64| machine.axes[tipped].kind.from_file_unit(of);
        let over = |gap: f64| {
            with_number(LATERAL_PLAY.name, place, "gap", travel(gap))
                .with("of", ParameterValue::Word(machine.axes[driving].name.clone()))
        };
        let gap = Refined::number("gap", (0.0, travel(LONGEST_TIPPING)), travel(TIPPING_STEP));
        let outlets = motion(tipped, &directions(machine, tipped).tilts);
        let family = CandidateFamily::new(LATERAL_PLAY.name, place, outlets, 30.0);
        list.push(family.over(TIPPING.map(over).to_vec()).refine(vec![gap]).rare(rarity));
    }
    list
}

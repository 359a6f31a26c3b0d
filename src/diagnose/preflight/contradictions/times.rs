//! Clocks: tests of one session follow each other, and a ball moves at the feed that its test states.

use super::arcs::unit_instead;
use crate::chain::{Chain, Geometry};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::preflight::data_fault::{DataFault, RECORDER, Rival, SESSION, listed};
use crate::machine::AxisKind;
use crate::session::{Motion, Recording, Session, Test, way_mm};
use crate::statistics::median;
use crate::units::OtherUnit;

/// How far two tests may overlap, s: beginnings are written down by hand.
const OVERLAP_S: f64 = 1.0;

/// Tests that were recorded while others were, or before the session began.
pub(super) fn overlapping(session: &Session) -> Option<DataFault> {
    let mut spans: Vec<(&Test, (f64, f64))> =
        session.tests.iter().filter_map(|test| Some((test, test.span_s()?))).collect();
    // several tests that begin at 0 do not state when they began
    let unstated = spans.iter().filter(|(test, _)| test.started_at_s == 0.0).count() > 1;
    spans.retain(|(test, _)| !unstated || test.started_at_s != 0.0);
    if let Some((test, _)) = spans.iter().find(|(test, _)| test.started_at_s < 0.0) {
        let says = format!(
            "{} has started_at {} s, before its session began: count all from one beginning",
            test.name, test.started_at_s
        );
        return Some(DataFault::seen(FaultKind::SessionTime, SESSION, vec![test.name.clone()], says));
    }
    spans.sort_by(|a, b| a.1.0.total_cmp(&b.1.0));
    spans.windows(2).find(|pair| pair[1].1.0 < pair[0].1.1 - OVERLAP_S).map(|pair| {
        let ((one, first), (other, next)) = (pair[0], pair[1]);
        let says = format!(
            "{} began at {:.1} s of the session, while {} was recorded until {:.1} s: one of them has a wrong started_at, or the times of rows are not seconds",
            other.name, next.0, one.name, first.1
        );
        DataFault::seen(FaultKind::SessionTime, SESSION, vec![one.name.clone(), other.name.clone()], says)
    })
}

/// How near a speed must be to a feed to have been run at it, as a share: overrides and limits of axes take more off.
const AT_FEED: f64 = 0.05;

/// A recording with the speed of its ball and the stated feed, mm/min.
struct Run<'s> {
    test: &'s Test,
    recording: &'s Recording,
    speed: f64,
    feed: f64,
}

impl Run<'_> {
    /// Whether each of two runs has the other's stated feed, which is not its own.
    fn has_feed_of(&self, other: &Run<'_>) -> bool {
        let is_at = |speed: f64, feed: f64| (speed / feed - 1.0).abs() < AT_FEED;
        let is_off = |run: &Run| !is_at(run.speed, run.feed);
        is_off(self) && is_off(other) && is_at(self.speed, other.feed) && is_at(other.speed, self.feed)
    }

    /// How far the positions of two runs lie apart, at the ends and between them.
    fn way_to(&self, other: &Run<'_>) -> f64 {
        let at = |run: &Run, quarter: usize| -> Vec<f64> {
            let row = quarter * (run.recording.len() - 1) / 4;
            run.recording.positions.iter().map(|column| column[row]).collect()
        };
        let apart = |quarter| at(self, quarter).into_iter().zip(at(other, quarter)).map(|(a, b)| (a - b).abs());
        (0..=4).flat_map(apart).sum()
    }
}

/// Recordings that ran at each other's stated feeds: their files are exchanged.
pub(super) fn at_other_feeds(session: &Session) -> Option<DataFault> {
    let chain = Chain::of(&session.machine);
    let geometry = Geometry::nominal(&chain);
    let run = |test| -> Option<Run> {
        let (test, recording): (&Test, &Recording) = (test, test.recording.as_ref()?);
        let (speed, feed) = (speed_mm_per_min(session, &geometry, test)?, test.feed_mm_per_min?);
        Some(Run { test, recording, speed, feed })
    };
    let mut runs: Vec<Run> = session.tests.iter().filter_map(run).collect();
    let mut pairs: Vec<[String; 2]> = Vec::new();
    while !runs.is_empty() {
        let one = runs.remove(0);
        let is_other = |other: &Run| one.recording.axes == other.recording.axes && one.has_feed_of(other);
        let others = (0..runs.len()).filter(|&other| is_other(&runs[other]));
        if let Some(other) = others.min_by(|&a, &b| one.way_to(&runs[a]).total_cmp(&one.way_to(&runs[b]))) {
            pairs.push([one.test.name.clone(), runs.remove(other).test.name.clone()]);
        }
    }
    let [one, other] = pairs.first()?;
    let further = match pairs.len() {
        1 => String::new(),
        count => format!(", as in {} further pairs", count - 1),
    };
    let says = format!(
        "by their rows {one} and {other} ran at each other's stated feed{further}: their recordings are exchanged; swap the files of these \
         tests, or correct their feeds"
    );
    Some(DataFault::seen(FaultKind::FilesExchanged, SESSION, pairs.concat(), says))
}

/// Speed of a ball over the stated feed, and its inverse, above which one of the two is wrong.
const OTHER_SPEED: f64 = 2.0;

/// Speeds of a ball without a stated feed, mm/min: a ball bar follows no faster and nobody waits so long.
const SPEEDS: std::ops::Range<f64> = 2.0..60_000.0;

/// Units in which times may have been written, with the speed that they seem to give over the true one.
const TIME_UNITS: [(&str, f64); 3] = [("milliseconds", 1e-3), ("minutes", 60.0), ("microseconds", 1e-6)];

/// How near the speed comes to what a wrong unit gives, as a share.
const AS_BY_UNIT: f64 = 0.25;

/// Recordings whose balls move at another speed than stated.
pub(super) fn other_speed(session: &Session) -> Option<DataFault> {
    let chain = Chain::of(&session.machine);
    let geometry = Geometry::nominal(&chain);
    let ratio = |test: &Test| -> Option<(f64, f64)> {
        let speed = speed_mm_per_min(session, &geometry, test)?;
        match test.feed_mm_per_min {
            Some(feed) => Some((speed, speed / feed)),
            None => Some((speed, if SPEEDS.contains(&speed) { 1.0 } else { speed / SPEEDS.start })),
        }
    };
    let off = |ratio: f64| !(1.0 / OTHER_SPEED..OTHER_SPEED).contains(&ratio);
    let struck: Vec<(&Test, (f64, f64))> = session
        .tests
        .iter()
        .filter_map(|test| ratio(test).map(|ratio| (test, ratio)))
        .filter(|(_, (_, ratio))| off(*ratio))
        .collect();
    let (first, (speed, ratio)) = *struck.first()?;
    let tests: Vec<String> = struck.iter().map(|(test, _)| test.name.clone()).collect();
    // only tests off by as much have the same unit
    let is_alike = |(_, (_, other)): &&(&Test, (f64, f64))| (other / ratio - 1.0).abs() < AS_BY_UNIT;
    let alike = || struck.iter().filter(is_alike).map(|(test, _)| *test);
    let by_unit = TIME_UNITS.into_iter().find(|(_, factor)| (ratio / factor - 1.0).abs() < AS_BY_UNIT);
    if let Some((unit, _)) = by_unit.filter(|_| first.feed_mm_per_min.is_some()) {
        let tests: Vec<String> = alike().map(|test| test.name.clone()).collect();
        let says = format!("times of {} are in {unit}: convert the column time_s to seconds", listed(&tests));
        let mut fault = DataFault::seen(FaultKind::Unit, RECORDER, tests, says);
        fault.components = vec!["time".into()];
        return Some(fault);
    }
    let moving = |test: &Test| test.recording.as_ref().and_then(|recording| recording.axes.first().copied());
    let axis = moving(first).map(|axis| &session.machine.axes[axis]);
    // the speed that positions in another unit seem to give over the true one is the inverse of its size
    let in_turns = |kind: AxisKind| (kind == AxisKind::Rotary).then_some(OtherUnit::TURNS);
    let units = |kind: AxisKind| [Some(unit_instead(kind).0), in_turns(kind)].into_iter().flatten();
    let is_as_in = |unit: &OtherUnit| (ratio * unit.size - 1.0).abs() < AS_BY_UNIT;
    if let Some((axis, unit)) = axis.and_then(|axis| Some((axis, units(axis.kind).find(is_as_in)?))) {
        let (name, unit, due) = (&axis.name, unit.name, axis.kind.position_unit());
        let of_axis = alike().filter(|test| moving(test) == moving(first));
        let tests: Vec<String> = of_axis.map(|test| test.name.clone()).collect();
        let says = format!("{name} is in {unit} in {}: convert the column to {due}", listed(&tests));
        let mut fault = DataFault::seen(FaultKind::Unit, RECORDER, tests, says);
        fault.components = vec![name.clone()];
        return Some(fault);
    }
    let stated = match first.feed_mm_per_min {
        Some(feed) => format!("its feed is stated as {feed} mm/min"),
        None => "no machine measures at that".to_string(),
    };
    let says = format!(
        "by its rows the ball of {} moves at {speed:.3} mm/min and {stated} (so in {}): correct the feed, or the unit of time_s",
        first.name,
        listed(&tests)
    );
    Some(DataFault::seen(FaultKind::Feed, SESSION, tests, says))
}

/// How near the speeds of an axis over its stated feeds must be to each other, and to one, as a share: controls keep a feed better.
const SAME_SPEED: f64 = 0.005;

/// Speeds over the stated feed beyond which an override, or a limit of the axis, says it.
const SCALES: std::ops::Range<f64> = 0.8..1.25;

/// A speed that differs by less from the stated feed, as a share, says nothing of a scale.
const LEAST_SCALE: f64 = 0.01;

/// Gon in a degree.
const GON: f64 = 10.0 / 9.0;

/// Positions of a rotary axis by whose rows it moves faster or slower than stated, by one factor in all of its tests: they are in gon, or, where
/// other axes keep their feed, too large or too small unless that feed was run.
pub(super) fn other_scale(session: &Session) -> Option<DataFault> {
    let chain = Chain::of(&session.machine);
    let geometry = Geometry::nominal(&chain);
    let ratio = |test: &Test| -> Option<(usize, f64)> {
        let axis = *test.recording.as_ref()?.axes.first()?;
        Some((axis, speed_mm_per_min(session, &geometry, test)? / test.feed_mm_per_min?))
    };
    let ratios: Vec<(usize, f64)> = session.tests.iter().filter_map(ratio).collect();
    let is_same = |ratio: f64, other: f64| (ratio / other - 1.0).abs() < SAME_SPEED;
    let of_axis = |axis: usize| {
        let own: Vec<f64> = ratios.iter().filter(|(of, _)| *of == axis).map(|(_, ratio)| *ratio).collect();
        let scale = median(own.iter().copied()).filter(|_| own.len() > 1)?;
        own.iter().all(|ratio| is_same(*ratio, scale)).then_some(scale)
    };
    let keeps_feed = |axis: usize| of_axis(axis).is_some_and(|scale| is_same(scale, 1.0));
    let axes = 0..session.machine.axes.len();
    let others_keep = |axis: usize| axes.clone().any(|other| other != axis && keeps_feed(other));
    let struck = axes.clone().filter(|&axis| session.machine.axes[axis].kind == AxisKind::Rotary);
    let (axis, scale) = struck.filter_map(|axis| Some((axis, of_axis(axis)?))).find(|&(axis, scale)| {
        let is_off = SCALES.contains(&scale) && (scale - 1.0).abs() > LEAST_SCALE;
        is_same(scale, GON) || is_off && others_keep(axis)
    })?;
    let name = &session.machine.axes[axis].name;
    let is_of_axis = |test: &&Test| test.recording.as_ref().is_some_and(|recording| recording.axes == [axis]);
    let tests: Vec<String> = session.tests.iter().filter(is_of_axis).map(|test| test.name.clone()).collect();
    let seen = format!("by its rows {name} moves at {scale:.3} times the stated feed in all of its tests");
    let fault = if is_same(scale, GON) {
        let says = format!("{seen}, as it does in gon (400 to a turn): multiply the column {name} by 0.9");
        DataFault::seen(FaultKind::Unit, RECORDER, tests, says)
    } else {
        let says = format!("{seen}, and other axes at theirs: state the feed that was run");
        let column = format!("the column {name} is {scale:.3} times as large as it should be: export it again");
        let rival = Rival {
            kind: FaultKind::Unit,
            place: RECORDER.into(),
            components: vec![name.clone()],
            says: column,
            probability: 0.0,
        };
        DataFault { rivals: vec![rival], ..DataFault::seen(FaultKind::Feed, SESSION, tests, says) }.shared_evenly()
    };
    Some(DataFault { components: vec![name.clone()], ..fault })
}

/// Median speed between rows, of one axis or of linear axes alone; `None` for poses and recordings without times of their own.
fn speed_mm_per_min(session: &Session, geometry: &Geometry, test: &Test) -> Option<f64> {
    let recording = test.recording.as_ref()?;
    // a control divides its feed among slides and rotary axes that move together in ways of its own
    let is_linear = |axis: &usize| session.machine.axes[*axis].kind == AxisKind::Linear;
    let time = recording.time_s().filter(|_| recording.axes.len() == 1 || recording.axes.iter().all(is_linear))?;
    let motion = Motion::of(session, geometry.chain(), test).ok()?;
    let links = test.links(geometry.chain()).ok()?;
    // some rows tell the speed of all
    let every = (motion.rows() / ROWS_FOR_SPEED).max(1);
    let rows = (1..motion.rows().min(time.len())).step_by(every);
    let speed = |row: usize| {
        60.0 * way_mm(geometry, test, links, motion.row(row - 1), motion.row(row)) / (time[row] - time[row - 1])
    };
    median(rows.map(speed)).filter(|speed| *speed > 0.0)
}

/// Rows from which the speed of a test is learnt.
const ROWS_FOR_SPEED: usize = 50;

//! Tests that could follow a session, with the balls and bars that it has mounted, laid out before they are run.

use std::ops::Range;
use std::sync::Arc;

use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::Context;
use crate::identify::Problem;
use crate::machine::AxisKind;
use crate::session::{CirclePlane, Clock, Follow, LengthColumn, Motion, Path, Recording, Session, Setups, Test};
use crate::statistics::NoiseModel;

/// A candidate test: one or two recordings that follow the session.
pub struct Proposal {
    pub says: String,
    pub tests: Vec<Test>,
    /// When the session ends, s.
    after_s: f64,
}

impl Proposal {
    /// Time until its last test ends, with its pauses, minutes.
    pub fn minutes(&self) -> f64 {
        (self.tests.iter().map(ends_at_s).fold(self.after_s, f64::max) - self.after_s) / 60.0
    }
}

/// Angle between samples of a proposed path, degrees.
const STEP_DEG: f64 = 5.0;
/// Pause before a test is repeated at the session's end, s.
const PAUSE_S: f64 = 1800.0;
/// Time between the recordings of a proposal, s.
const BETWEEN_S: f64 = 10.0;
/// Tests of the session that are tried again in another way.
const REPEATED: usize = 2;

/// The session around its fit, as the search has it.
pub struct Layout<'l> {
    /// Session with few rows.
    pub session: &'l Session,
    pub problem: &'l Problem<'l>,
    pub values: &'l [f64],
    pub kept: &'l [Vec<bool>],
    pub noise: &'l [NoiseModel],
}

impl Layout<'_> {
    /// Lays the session out once more with the tests of all proposals behind its own, each run or not; `None` where a test
    /// cannot be computed.
    pub fn with<R>(&self, proposals: &[Proposal], judge: impl FnOnce(&mut Longer) -> Option<R>) -> Option<R> {
        let mut session = self.session.clone();
        let mut kept = self.kept.to_vec();
        let mut of_proposal = Vec::new();
        for proposal in proposals {
            let first = session.tests.len();
            session.tests.extend(proposal.tests.iter().cloned());
            kept.extend(
                proposal.tests.iter().map(|test| vec![true; test.recording.as_ref().map_or(0, Recording::len)]),
            );
            of_proposal.push(first..session.tests.len());
        }
        let chain = self.problem.chain;
        let setups = Setups::of(&session);
        let problem = Problem::new(&session, chain, &setups, self.problem.unknowns.clone()).ok()?;
        let context = Context::of(&session, chain).ok()?;
        let model = LinearModel::new(&context, &problem, self.values, kept);
        let mut noise = self.noise.to_vec();
        let sweep = *noise.iter().find(|noise| noise.ar_mm > 0.0).or(noise.first())?;
        noise.resize(model.tests(), sweep);
        judge(&mut Longer { model, noise, of_proposal, run: self.session.tests.len() })
    }
}

/// A session with proposed tests behind its own.
pub struct Longer<'l> {
    pub model: LinearModel<'l>,
    pub noise: Vec<NoiseModel>,
    /// By proposal: its tests.
    of_proposal: Vec<Range<usize>>,
    /// Tests that were run.
    run: usize,
}

impl Longer<'_> {
    /// Tests that were run, and those of each proposal.
    pub fn groups(&self) -> Vec<Range<usize>> {
        std::iter::once(0..self.run).chain(self.of_proposal.iter().cloned()).collect()
    }

    /// Rows that take part if these proposals are run.
    pub fn rows_with(&self, proposals: &[usize]) -> Vec<Vec<bool>> {
        let takes_part =
            |test: usize| test < self.run || proposals.iter().any(|&index| self.of_proposal[index].contains(&test));
        let kept = self.model.kept.iter().enumerate();
        kept.map(|(test, kept)| if takes_part(test) { kept.clone() } else { vec![false; kept.len()] }).collect()
    }
}

/// Candidate tests with the balls and bars that the session has mounted, and these tests again at other feeds.
pub fn proposals(session: &Session, again_named: &[String]) -> Vec<Proposal> {
    let mut latest_first: Vec<&Test> = session.tests.iter().collect();
    latest_first.sort_by(|one, other| ends_at_s(one).total_cmp(&ends_at_s(other)));
    latest_first.reverse();
    let after_s = latest_first.first().map_or(0.0, |latest| ends_at_s(latest));
    let mut list = Vec::new();
    for test in again_named.iter().filter_map(|name| session.tests.iter().find(|t| t.name == *name)).take(REPEATED) {
        for (factor, words) in [(0.25, "a quarter of the feed"), (4.0, "four times the feed")] {
            list.push(Proposal {
                says: format!("{} again at {words}", test.name),
                tests: vec![again(test, factor, after_s + BETWEEN_S)],
                after_s,
            });
        }
    }
    // what has drifted or slipped shows where nothing was remounted
    if let Some(latest) = latest_first.first() {
        list.push(Proposal {
            says: format!("{} again after half an hour's rest, nothing remounted", latest.name),
            tests: vec![again(latest, 1.0, after_s + PAUSE_S)],
            after_s,
        });
    }
    let mut mounts: Vec<&Test> = Vec::new();
    for test in latest_first {
        let same = |other: &&Test| {
            other.pivot == test.pivot
                && other.spindle_ball == test.spindle_ball
                && other.bar_length_mm == test.bar_length_mm
        };
        if test.bar_length_mm.is_some() && !mounts.iter().any(same) {
            mounts.push(test);
        }
    }
    for mount in mounts.into_iter().take(MOUNTS) {
        following(session, mount, after_s, &mut list);
        circles(session, mount, after_s, &mut list);
    }
    list
}

/// Mounts of balls and bars that are tried, the latest first: it may still stand.
const MOUNTS: usize = 1;

fn ends_at_s(test: &Test) -> f64 {
    test.span_s().map_or(test.started_at_s, |(_, ends_s)| ends_s)
}

/// A recording made again, `factor` times as fast, at another time.
fn again(test: &Test, factor: f64, at_s: f64) -> Test {
    let mut test = test.clone();
    test.name = format!("next {} {factor}", test.name);
    test.started_at_s = at_s;
    test.feed_mm_per_min = test.feed_mm_per_min.map(|feed| feed * factor);
    if let Some(recording) = &mut test.recording
        && let Clock::TimeS(time) = &mut recording.clock
    {
        time.iter_mut().for_each(|t| *t /= factor);
    }
    test
}

/// Sweeps of every rotary axis with the linear axes following.
fn following(session: &Session, mount: &Test, after_s: f64, list: &mut Vec<Proposal>) {
    let machine = &session.machine;
    for (axis, entry) in machine.axes.iter().enumerate().filter(|(_, axis)| axis.kind == AxisKind::Rotary) {
        let (from, to) = entry.range.map_or((-180.0, 180.0), |(from, to)| {
            (entry.kind.to_file_unit(from).max(-180.0), entry.kind.to_file_unit(to).min(180.0))
        });
        for (follow, words) in
            [(Follow::Tangential, "tangentially"), (Follow::Radial, "radially"), (Follow::Axial, "axially")]
        {
            let sweep = |from, to| Path::Sweep { axis, from, to, step: STEP_DEG, follow, length_mm: None };
            let says = format!(
                "{} swept both ways with the linear axes following {words}, {}",
                entry.name,
                mount_words(mount)
            );
            list.extend(both_ways(session, mount, after_s, sweep(from, to), sweep(to, from), &[], says));
        }
    }
}

/// Planar circles of every pair of linear axes, at two feeds.
fn circles(session: &Session, mount: &Test, after_s: f64, list: &mut Vec<Proposal>) {
    let machine = &session.machine;
    let linear: Vec<usize> = machine.axes_of(AxisKind::Linear).collect();
    let radius_mm = mount.nominal_bar_mm();
    for (index, &first) in linear.iter().enumerate() {
        for &second in &linear[index + 1..] {
            let circle = |from, to| {
                let plane = CirclePlane { first, second };
                Path::Circle { plane, radius_mm, from, to, step: STEP_DEG }
            };
            let says = format!(
                "circles of {} and {} in both directions at two feeds, {}",
                machine.axes[first].name,
                machine.axes[second].name,
                mount_words(mount)
            );
            list.extend(both_ways(session, mount, after_s, circle(0.0, 360.0), circle(360.0, 0.0), &[0.25], says));
        }
    }
}

fn mount_words(mount: &Test) -> String {
    let ball = |ball: &crate::session::Ball| {
        format!("{} at ({:.0}, {:.0}, {:.0})", ball.link, ball.at.x, ball.at.y, ball.at.z)
    };
    format!("pivot on {}, bar {:.0} mm", ball(&mount.pivot), mount.bar_length_mm.unwrap_or(0.0))
}

/// A path there and back, also at other feeds; `None` when the machine cannot run it.
fn both_ways(
    session: &Session,
    mount: &Test,
    after_s: f64,
    there: Path,
    back: Path,
    feeds: &[f64],
    says: String,
) -> Option<Proposal> {
    let mut tests = Vec::new();
    let mut at_s = after_s + BETWEEN_S;
    for (way, path) in [("there", there), ("back", back)] {
        let mut test = Test {
            name: format!("next {says} {way}"),
            recording_file: None,
            recording: None,
            path: Some(path),
            started_at_s: at_s,
            positions: vec![Some(0.0); session.machine.axes.len()],
            overshoot: None,
            ..mount.clone()
        };
        test.recording = Some(as_if_recorded(session, &test)?);
        for feed in [1.0].iter().chain(feeds) {
            let mut one = again(&test, *feed, at_s);
            one.name = format!("{} {way}", one.name);
            at_s = ends_at_s(&one) + BETWEEN_S;
            tests.push(one);
        }
    }
    Some(Proposal { says, tests, after_s })
}

/// Positions of a path as a recording would hold them, lengths at the bar's; `None` outside the axes' ranges.
fn as_if_recorded(session: &Session, test: &Test) -> Option<Recording> {
    let chain = crate::chain::Chain::of(&session.machine);
    let motion = Motion::of(session, &chain, test).ok()?;
    let in_range = |axis: usize| {
        let range = session.machine.axes[axis].range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        motion.axis(axis).all(|q| (range.0..=range.1).contains(&q))
    };
    if !(0..session.machine.axes.len()).all(in_range) {
        return None;
    }
    // a thermometer would say what it said at the start
    let channels =
        session.tests.first().and_then(|first| first.recording.as_ref()).map(|recording| &recording.channels);
    let channels = channels.into_iter().flatten().map(|(name, values)| {
        let first = values.iter().copied().find(|value| value.is_finite()).unwrap_or(f64::NAN);
        (name.clone(), vec![first; motion.rows()])
    });
    Some(Recording {
        clock: Clock::TimeS(motion.time_s.clone()?),
        axes: motion.moving.clone(),
        positions: motion.moving.iter().map(|&axis| motion.axis(axis).collect()).collect(),
        length_mm: vec![test.bar_length_mm?; motion.rows()],
        channels: channels.collect(),
        leading_texts: Arc::default(),
        leading_header: String::new(),
        column: LengthColumn::default(),
        scatter: None,
    })
}

//! Captures as a gauge writes them, made by a motion of its own: rest, ramp, run, ramp, rest and back, errors drawn.

use std::f64::consts::PI;

use fiveaxis::chain::{Chain, Composition};
use fiveaxis::import::{Capture, Pair, Placement};
use fiveaxis::load::load_session;
use fiveaxis::plan::beyond_path;
use fiveaxis::session::{Clock, Motion, Path, Recording, Session};
use fiveaxis::simulate::{Instrument, SetupErrors, simulate_with};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    Sound,
    CutAtStart,
    CutAtEnd,
    BarOff,
    Standing,
}

pub struct Drawn {
    pub pair: usize,
    pub capture: Capture,
    /// True path by reading, deg.
    pub path: Vec<f64>,
    pub pace: f64,
    pub says: String,
}

const MACHINE: &str = "machines/hermle-c600u.yaml";

/// A planned session of sweeps with and without following, and a circle.
pub fn planned() -> Session {
    let folder = tempfile::tempdir().unwrap();
    let machine = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(MACHINE);
    let mut text = format!("machine: {}\ntests:\n", machine.display());
    let rest = "bar_length: 100";
    for (name, pivot, spindle, positions, path, feed) in [
        (
            "a",
            "[0, 100, 0]",
            "[0, 0, 0]",
            "{X: 0, Y: 0, Z: 0, C: 0}",
            "sweep: {axis: A, from: FROM, to: TO, step: 0.5}",
            500,
        ),
        (
            "c",
            "[0, 100, 0]",
            "[0, 0, 0]",
            "{X: 0, Y: 0, Z: 0, A: 0}",
            "sweep: {axis: C, from: FROM, to: TO, step: 0.5}",
            1000,
        ),
        (
            "c-high",
            "[0, 60, 0]",
            "[0, 0, 80]",
            "{X: 0, Y: 0, Z: 0, A: 0}",
            "sweep: {axis: C, from: FROM, to: TO, step: 0.5}",
            800,
        ),
        (
            "c-axial",
            "[0, 100, 0]",
            "[0, 0, 100]",
            "{A: 0}",
            "sweep: {axis: C, from: FROM, to: TO, step: 0.5, follow: axial}",
            2000,
        ),
        (
            "c-tangential",
            "[0, 80, 0]",
            "[0, 0, 0]",
            "{A: 0}",
            "sweep: {axis: C, from: FROM, to: TO, step: 0.5, follow: tangential}",
            1500,
        ),
        (
            "xy",
            "[0, 0, 0]",
            "[0, 0, 0]",
            "{Z: 0, A: 0, C: 0}",
            "circle: {plane: XY, radius: 100, from: FROM, to: TO, step: 0.5}",
            1000,
        ),
    ] {
        let ends = if name == "a" {
            [-80.0, 20.0]
        } else if name == "xy" {
            [0.0, 360.0]
        } else {
            [-150.0, 150.0]
        };
        for (way, [from, to]) in [("ccw", ends), ("cw", [ends[1], ends[0]])] {
            let path = path.replace("FROM", &from.to_string()).replace("TO", &to.to_string());
            text += &format!(
                "  - {{name: {name}-{way}, {rest}, pivot: {{link: C, at: {pivot}}}, spindle_ball: {{link: Z, at: {spindle}}}, positions: {positions}, feed: {feed}, overshoot: 4, {path}}}\n"
            );
        }
    }
    let file = folder.path().join("session.yaml");
    std::fs::write(&file, text).unwrap();
    load_session(&file).unwrap_or_else(|why| panic!("{why}"))
}

pub fn drawn(session: &Session, all: &[Pair], seed: u64, kind: Kind) -> Drawn {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = |from: f64, to: f64| random.random_range(from..to);
    let pair = seed as usize % all.len();
    let rate = 10f64.powf(uniform(1.0, 3.0));
    let pace = 1.0 + uniform(-0.02, 0.02);
    let (lead, gap, tail) = (uniform(0.5, 10.0), uniform(1.0, 20.0), uniform(0.5, 10.0));
    let (delay, ramp) = (uniform(0.0, 0.5), uniform(0.08, 0.29));
    let test = &session.tests[all[pair].tests[0]];
    let (Path::Sweep { from, to, .. } | Path::Circle { from, to, .. }) = test.path.as_ref().unwrap();
    let chain = Chain::of(&session.machine);
    let arc = Motion::of(session, &chain, test).unwrap();
    let [before, after] = beyond_path(&session.machine, test, &arc).unwrap();
    let (from, to) = (from - before, to + after);
    // a fine path, even in time
    let mut fine = test.clone();
    let mut path = test.path.as_ref().unwrap().between(from, to);
    let (Path::Sweep { step, .. } | Path::Circle { step, .. }) = &mut path;
    *step = 0.02;
    fine.path = Some(path);
    fine.recording = None;
    let motion = Motion::of(session, &chain, &fine).unwrap();
    let whole = motion.time_s.as_ref().unwrap().last().unwrap() / pace;
    // speed rises as a sine squared: no even acceleration
    let gone = |since: f64| -> f64 {
        let end = whole + ramp;
        let wave = ramp / (2.0 * PI);
        let rise = |t: f64| if t < ramp { t / 2.0 - wave * (PI * t / ramp).sin() } else { t - ramp / 2.0 };
        if since <= 0.0 {
            0.0
        } else if since >= end {
            1.0
        } else if since < end - ramp {
            rise(since) / whole
        } else {
            1.0 - rise(end - since) / whole
        }
    };
    let (start, back) = (lead, lead + whole + ramp + gap);
    let end = back + whole + ramp + tail;
    let window = match kind {
        Kind::CutAtStart => (start + uniform(0.1, 0.6) * whole, end),
        Kind::CutAtEnd => (0.0, back + uniform(0.3, 0.9) * whole),
        _ => (0.0, end),
    };
    let rows: Vec<f64> = (0..((window.1 - window.0) * rate) as usize).map(|k| window.0 + k as f64 / rate).collect();
    let share: Vec<f64> = rows
        .iter()
        .map(|&time| if kind == Kind::Standing { 0.0 } else { gone(time - start) - gone(time - back) })
        .collect();
    let mut moved = session.clone();
    moved.tests = vec![test.clone()];
    let last = motion.rows() as f64 - 1.0;
    let axes = motion.moving.clone();
    moved.tests[0].recording = Some(Recording {
        clock: Clock::TimeS(rows.clone()),
        positions: axes
            .iter()
            .map(|&axis| {
                share
                    .iter()
                    .map(|share| {
                        let node = (share * last).min(last - 1e-9);
                        let (k, part) = (node.floor() as usize, node.fract());
                        motion.row(k)[axis] + part * (motion.row(k + 1)[axis] - motion.row(k)[axis])
                    })
                    .collect()
            })
            .collect(),
        axes,
        length_mm: vec![100.0; rows.len()],
        channels: Vec::new(),
        leading_texts: Vec::new(),
        leading_header: String::new(),
        column: Default::default(),
    });
    // a machine with errors of its own
    for axis in &mut moved.machine.axes {
        for (k, error) in axis.location_errors.iter_mut().enumerate() {
            *error += if k < 3 { uniform(-0.02, 0.02) } else { uniform(-5e-5, 5e-5) };
        }
    }
    let traces = simulate_with(&moved, Composition::Exact, &SetupErrors::drawn(&moved, seed)).unwrap();
    let instrument = Instrument { stroke_mm: (f64::NEG_INFINITY, f64::INFINITY), ..Instrument::default() };
    let mut readings = instrument.read(&moved, traces, seed).unwrap().remove(0).length_mm;
    // drop-outs, and a gauge that was off
    for _ in 0..3 {
        let at = uniform(0.0, readings.len() as f64) as usize;
        let most = (0.3 * rate).ceil() as usize;
        readings.iter_mut().skip(at).take(most).for_each(|reading| *reading = f64::NAN);
    }
    if kind == Kind::BarOff {
        let at = (uniform(0.1, 0.6) * readings.len() as f64) as usize;
        readings.iter_mut().skip(at).for_each(|reading| *reading = 101.2 + uniform(-0.01, 0.01));
    }
    let capture = Capture {
        time_s: rows.iter().map(|time| time - window.0 + delay).collect(),
        reading_mm: readings.iter().map(|reading| reading - 100.0).collect(),
    };
    Drawn {
        pair,
        capture,
        path: share.iter().map(|share| from + (to - from) * share).collect(),
        pace,
        says: format!("{} {rate:.0} Hz lead {lead:.1} gap {gap:.1} whole {whole:.1} ramp {ramp:.2}", test.name),
    }
}

/// Root mean square distance of the imported positions from the true ones, deg (or mm).
pub fn off(drawn: &Drawn, placement: &Placement) -> f64 {
    let timing = &placement.timing;
    let course = &placement.course;
    let (mut sum, mut rows) = (0.0, 0.0);
    for (k, &time) in drawn.capture.time_s.iter().enumerate() {
        let (along, _) = timing.place_s(time, course.run_s);
        let found = course.path_at(along);
        let is_in = along > course.arc_s[0] && along < course.arc_s[1];
        if is_in && time > timing.start_s[0] {
            sum += (found - drawn.path[k]).powi(2);
            rows += 1.0;
        }
    }
    f64::sqrt(sum / f64::max(rows, 1.0))
}

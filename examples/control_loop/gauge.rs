//! A gauge on the hidden machine: balls mounted near their places, one capture per program from when the bar is mounted until it
//! is taken off.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use fiveaxis::session::{Ball, Session, Test};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use crate::physics::{Hidden, State};
use crate::plain_machine::{Plain, distance};

/// Readings a second.
pub const RATE: usize = 50;
/// Noise of a reading, mm.
pub const NOISE_MM: f64 = 0.2e-3;
/// Standard deviation with which pivots and the spindle ball are mounted, mm.
const MOUNTED_MM: [f64; 2] = [20e-3, 3e-3];
/// The gauge's stroke to either side, mm.
const STROKE_MM: f64 = 0.9;
/// Day and hour at which sessions begin.
pub const DAY: &str = "2026-03-02";
pub const BEGAN_H: u64 = 8;
/// Pause between two programs, min.
const PAUSE_MIN: f64 = 2.0;

/// Balls stay mounted; time goes on.
pub struct Gauge<'s> {
    pub session: &'s Session,
    hidden: Hidden,
    /// How far from their places balls were mounted, by name.
    balls: BTreeMap<String, [f64; 3]>,
    random: ChaCha8Rng,
    minutes: f64,
    /// What the axes owe to the way they have come, from program to program.
    state: State,
}

/// One reading.
#[derive(Clone)]
pub struct Reading {
    /// Since the bar was mounted, s.
    pub seconds: f64,
    /// From the bar's length, mm.
    pub off_mm: f64,
    /// Positions by axis, mm and rad.
    pub q: Vec<f64>,
    pub moves: bool,
    /// Line of the program.
    pub line: usize,
}

/// A capture.
pub struct Look {
    pub program: String,
    /// When the bar was mounted, s since the session began.
    began_s: f64,
    pub readings: Vec<Reading>,
}

impl<'s> Gauge<'s> {
    pub fn new(session: &'s Session, hidden: Hidden, random: ChaCha8Rng) -> Gauge<'s> {
        Gauge { session, hidden, balls: BTreeMap::new(), random, minutes: 0.0, state: State::new() }
    }

    /// The first test of a program.
    pub fn test(&self, program: &str) -> &'s Test {
        let name = format!("{program}-ccw");
        self.session.tests.iter().find(|test| test.name == name).expect("the program's test")
    }

    /// Where a ball is really mounted, in R with all axes at zero.
    pub fn mounted(&self, ball: &Ball) -> [f64; 3] {
        let off = self.balls.get(&name_of(ball)).copied().unwrap_or_default();
        std::array::from_fn(|k| ball.at[k] + off[k])
    }

    fn mount(&mut self, ball: &Ball, spread_mm: f64) {
        let normal = Normal::new(0.0, spread_mm).expect("normal");
        let random = &mut self.random;
        self.balls.entry(name_of(ball)).or_insert_with(|| std::array::from_fn(|_| normal.sample(random)));
    }

    /// What the gauge records while a program runs.
    pub fn look(&mut self, program: &str, trace: &Path) -> Look {
        let test = self.test(program);
        self.mount(&test.pivot, MOUNTED_MM[0]);
        self.mount(&test.spindle_ball, MOUNTED_MM[1]);
        let rows = trace_rows(self.session, trace);
        let (pivot, spindle) = (self.mounted(&test.pivot), self.mounted(&test.spindle_ball));
        let bar = test.bar_length_mm.expect("bar");
        let begin = self.minutes;
        let mut all: Vec<Reading> = Vec::new();
        for (k, TraceRow { seconds, q, line }) in rows.iter().enumerate() {
            let machine = self.hidden.at(&mut self.state, q, begin + seconds / 60.0);
            if k % (1000 / RATE) != 0 {
                continue;
            }
            let plain = Plain { machine: &machine, errs: true, tip: [0.0; 3], axis: [0.0, 0.0, 1.0] };
            let [one, other] = [(&test.pivot.link, pivot), (&test.spindle_ball.link, spindle)]
                .map(|(link, at)| plain.ball(link, at, q));
            let moves = rows.get(k + 1).is_some_and(|next| next.q != *q);
            all.push(Reading {
                seconds: *seconds,
                off_mm: distance(one, other) - bar,
                q: q.clone(),
                moves,
                line: *line,
            });
        }
        self.minutes += rows.last().map_or(0.0, |row| row.seconds / 60.0) + PAUSE_MIN;
        let noise = Normal::new(0.0, NOISE_MM).expect("normal");
        let mut readings = while_mounted(&all).to_vec();
        let mounted_s = readings.first().map_or(0.0, |reading| reading.seconds);
        for reading in &mut readings {
            reading.seconds -= mounted_s;
            reading.off_mm += noise.sample(&mut self.random);
        }
        Look { program: program.into(), began_s: 60.0 * begin + mounted_s, readings }
    }
}

/// Balls of one place are one ball.
pub fn name_of(ball: &Ball) -> String {
    format!("{} {:?}", ball.link, ball.at)
}

/// From a standstill to a standstill of the longest stretch in which the bar fits.
fn while_mounted(all: &[Reading]) -> &[Reading] {
    let stretches = all.split(|reading| reading.off_mm.abs() > STROKE_MM);
    let fits = stretches.max_by_key(|stretch| stretch.len()).expect("a stretch");
    let stands = |k: &usize| fits[*k].q == fits[k + RATE].q;
    let first = (0..fits.len() - RATE).find(stands).expect("a standstill");
    let last = (0..fits.len() - RATE).rev().find(stands).expect("a standstill") + RATE;
    &fits[first..=last]
}

/// One servo period of a trace.
pub struct TraceRow {
    pub seconds: f64,
    /// Positions by axis index, mm and rad.
    pub q: Vec<f64>,
    pub line: usize,
}

fn trace_rows(session: &Session, trace: &Path) -> Vec<TraceRow> {
    let machine = &session.machine;
    let text = std::fs::read_to_string(trace).expect("trace");
    let mut lines = text.lines();
    let names: Vec<usize> = lines
        .next()
        .expect("head")
        .split(',')
        .filter_map(|name| machine.axis_index(name.split('_').next().expect("axis")))
        .collect();
    let mut told = 0;
    let row = |line: &str| {
        let values: Vec<f64> = line.split(',').map(|value| value.parse().expect("number")).collect();
        let mut q = vec![0.0; machine.axes.len()];
        names.iter().zip(&values[1..]).for_each(|(&k, value)| q[k] = machine.axes[k].kind.from_file_unit(*value));
        // the control tells none in the last cycles before a stop
        told = if values[values.len() - 1] > 0.0 { values[values.len() - 1] as usize } else { told };
        TraceRow { seconds: values[0], q, line: told }
    };
    lines.map(row).collect()
}

impl Look {
    /// As a gauge writes it.
    pub fn capture(&self, folder: &Path, name: &str) -> PathBuf {
        let seconds = self.began_s.round() as u64;
        let (hours, minutes, seconds) = (BEGAN_H + seconds / 3600, seconds / 60 % 60, seconds % 60);
        let mut text = format!(
            "Ball bar recorder\nRecorded: {DAY} {hours:02}:{minutes:02}:{seconds:02}\nSample rate: {RATE} Hz\ntime_s;deviation_um\n"
        );
        for reading in &self.readings {
            let _ = writeln!(text, "{:.3};{:.2}", reading.seconds, 1e3 * reading.off_mm);
        }
        std::fs::create_dir_all(folder).expect("folder");
        let file = folder.join(format!("{name}.csv"));
        std::fs::write(&file, text).expect("written");
        file
    }
}

//! Captures in one piece, made without the library: a plan's own programs are read back and run by a control and a machine of
//! the tests' own, and a gauge of their own reads the bar.

#![allow(dead_code, reason = "shared by tests of which not all need it")]

mod control;
mod gauge;
mod trace;

use std::path::Path;

use fiveaxis::import::{Capture, Pair, Placement, pairs};
use fiveaxis::load::{load_machine_and_bodies, standard_kit};
use fiveaxis::machine::AxisKind;
use fiveaxis::nc::{Dialect, program};
use fiveaxis::plan::{Settings, bare_session, plan};
use fiveaxis::session::{LengthColumn, Path as TestPath, Recording, Session};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::plain_machine::{Plain, distance};
pub use control::{HABITS, Habit};
use control::{Manner, timeline};
pub use gauge::Erring;
pub use trace::Trace;

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    Sound,
    CutAtStart,
    CutAtEnd,
    BarOff,
    Standing,
    /// Held for [`HELD_S`] in the middle of either run.
    Held,
}

/// How long a run is held, s.
const HELD_S: f64 = 0.4;

/// A plan with circles and the generic programs of its tests.
pub struct Planned {
    pub session: Session,
    pub pairs: Vec<Pair>,
    programs: Vec<String>,
    /// The same for LinuxCNC, with their names.
    pub linuxcnc: Vec<(String, String)>,
}

/// The plan of a shipped machine at a feed, mm/min, its programs with marks or without.
pub fn planned(machine: &str, feed: f64, marks: bool) -> Planned {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("machines").join(machine);
    let (machine, bodies) = load_machine_and_bodies(&file).expect("shipped machine");
    let mut settings = Settings { feed_mm_per_min: feed, marks, ..Settings::default() };
    settings.coupled.circles = true;
    let plan = plan(&machine, &bodies, &standard_kit().expect("kit"), &settings).expect("plan");
    let tests = plan.tests.iter().flat_map(|test| test.both_ways()).collect();
    let programs = plan.tests.iter().map(|test| program(&machine, test, &[], Dialect::Generic)).collect();
    let linuxcnc = plan
        .tests
        .iter()
        .map(|test| (test.test.name.clone(), program(&machine, test, &[], Dialect::LinuxCnc)))
        .collect();
    let mut session = Session { tests, ..bare_session(&machine) };
    for (k, test) in session.tests.iter_mut().enumerate() {
        test.started_at_s = 200.0 * k as f64;
    }
    let pairs = pairs(&session);
    Planned { session, pairs, programs, linuxcnc }
}

/// A capture, and what the machine did meanwhile.
pub struct Drawn {
    pub capture: Capture,
    /// Positions of all axes at each reading, mm and rad.
    pub positions: Vec<Vec<f64>>,
    pub pace: f64,
    pub says: String,
}

impl Planned {
    /// A capture of a pair's program on an erring machine.
    pub fn drawn(&self, erring: &mut Erring, pair: usize, seed: u64, kind: Kind) -> Drawn {
        self.drawn_by(erring, pair, seed, kind, Habit::Plain)
    }

    /// The same by a control or an operator with a habit.
    pub fn drawn_by(&self, erring: &mut Erring, pair: usize, seed: u64, kind: Kind, habit: Habit) -> Drawn {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let rate = 10f64.powf(random.random_range(1.0..3.0));
        let test = &self.session.tests[self.pairs[pair].tests[0]];
        let manner = Manner::drawn(&mut random, test.marks.is_some(), habit);
        let delay = random.random_range(0.0..0.5);
        let motion = timeline(&self.session.machine, &self.programs[pair], &manner, &mut random);
        let run = motion.runs_s;
        let window = match kind {
            Kind::CutAtStart => (run[0][0] + random.random_range(0.1..0.6) * (run[0][1] - run[0][0]), motion.lasts_s()),
            Kind::CutAtEnd => (0.0, run[1][0] + random.random_range(0.3..0.9) * (run[1][1] - run[1][0])),
            Kind::Held => (0.0, motion.lasts_s() + 2.0 * HELD_S),
            _ => (0.0, motion.lasts_s()),
        };
        let middles = run.map(|[from, to]| 0.5 * (from + to));
        let at = |time: f64| match kind {
            Kind::Standing => motion.at(0.0),
            // it stands in the middle of either run, and goes on
            Kind::Held => motion.at(middles.iter().fold(time, |time, middle| time.min(middle.max(time - HELD_S)))),
            _ => motion.at(time),
        };
        let (mut capture, positions) = self.read(erring, pair, (window, rate, delay), &at, &mut random);
        if kind == Kind::BarOff {
            let readings = &mut capture.reading_mm;
            let at = (random.random_range(0.1..0.6) * readings.len() as f64) as usize;
            readings.iter_mut().skip(at).for_each(|reading| *reading = 1.2 + random.random_range(-0.01..0.01));
        }
        let says = format!(
            "{} {habit:?} {rate:.0} Hz ramp {:.2} run {:.1} s",
            test.name,
            manner.ramp_s,
            run[0][1] - run[0][0]
        );
        Drawn { capture, positions, pace: 0.5 * (manner.paces[0] + manner.paces[1]), says }
    }

    /// A capture of a pair's program as a real control ran it.
    pub fn drawn_of(&self, trace: &Trace, erring: &mut Erring, pair: usize, seed: u64) -> Drawn {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let rate = 10f64.powf(random.random_range(1.0..3.0));
        let delay = random.random_range(0.0..0.5);
        let test = &self.session.tests[self.pairs[pair].tests[0]];
        let nominal = Plain { machine: &self.session.machine, errs: false, tip: [0.0; 3], axis: [0.0, 0.0, 1.0] };
        let bar_mm = test.bar_length_mm.expect("planned");
        let off_mm = |q: &[f64]| {
            let [one, other] =
                [&test.pivot, &test.spindle_ball].map(|ball| nominal.ball(&ball.link, ball.at.into(), q));
            distance(one, other) - bar_mm
        };
        let window = trace.with_bar(0.9, off_mm);
        let (capture, positions) = self.read(erring, pair, (window, rate, delay), &|time| trace.at(time), &mut random);
        Drawn { capture, positions, pace: 1.0, says: format!("{} {rate:.0} Hz by LinuxCNC", test.name) }
    }

    /// Readings over a window at a rate, and the positions at each; three short stretches are lost.
    fn read(
        &self,
        erring: &mut Erring,
        pair: usize,
        (window, rate, delay): ((f64, f64), f64, f64),
        at: &dyn Fn(f64) -> Vec<f64>,
        random: &mut ChaCha8Rng,
    ) -> (Capture, Vec<Vec<f64>>) {
        let test = &self.session.tests[self.pairs[pair].tests[0]];
        let rows: Vec<f64> = (0..((window.1 - window.0) * rate) as usize).map(|k| window.0 + k as f64 / rate).collect();
        let positions: Vec<Vec<f64>> = rows.iter().map(|time| at(*time)).collect();
        let mut reading_mm = erring.read(&self.session.machine, test, &rows, &positions, random);
        for _ in 0..3 {
            let at = random.random_range(0.0..reading_mm.len() as f64) as usize;
            let most = (random.random_range(0.0..0.3) * rate).ceil() as usize;
            reading_mm.iter_mut().skip(at).take(most).for_each(|reading| *reading = f64::NAN);
        }
        (Capture { time_s: rows.iter().map(|time| time - window.0 + delay).collect(), reading_mm }, positions)
    }

    /// The recordings of a placed capture with the true positions in place of those found, and their root mean square
    /// distance, deg of the axis that turns or of the circle.
    pub fn compared(&self, drawn: &Drawn, placement: &Placement) -> (f64, [(Recording, f64); 2]) {
        let mut ideal = fiveaxis::import::recordings(placement, &drawn.capture, 0.0, LengthColumn::DeviationMm);
        let test = &self.session.tests[placement.pair.tests[0]];
        let bar_mm = test.bar_length_mm.expect("planned");
        let (mut squares, mut rows) = (0.0, 0.0);
        for (recording, begins_s) in &mut ideal {
            let times = recording.time_s().expect("times").to_vec();
            recording.length_mm.iter_mut().for_each(|length| *length += bar_mm);
            for (row, time) in times.iter().enumerate() {
                let at = time + *begins_s;
                // readings and rows are the same: the nearest one is it
                let k = drawn.capture.time_s.partition_point(|other| *other < at - 1e-6).min(drawn.positions.len() - 1);
                let truth: Vec<f64> = recording.axes.iter().map(|&axis| drawn.positions[k][axis]).collect();
                let found: Vec<f64> = recording.positions.iter().map(|column| column[row]).collect();
                squares += self.apart_deg(placement, &recording.axes, &truth, &found).powi(2);
                rows += 1.0;
                recording.positions.iter_mut().zip(&truth).for_each(|(column, truth)| column[row] = *truth);
            }
        }
        (f64::sqrt(squares / f64::max(rows, 1.0)), ideal)
    }

    fn apart_deg(&self, placement: &Placement, axes: &[usize], truth: &[f64], found: &[f64]) -> f64 {
        let machine = &self.session.machine;
        let off = axes.iter().zip(truth.iter().zip(found));
        match &self.session.tests[placement.pair.tests[0]].path {
            Some(TestPath::Circle { radius_mm, .. }) => {
                off.map(|(_, (a, b))| (a - b).powi(2)).sum::<f64>().sqrt().atan2(*radius_mm).to_degrees()
            }
            _ => off
                .filter(|(axis, _)| machine.axes[**axis].kind == AxisKind::Rotary)
                .map(|(_, (a, b))| (a - b).abs().to_degrees())
                .fold(0.0, f64::max),
        }
    }
}

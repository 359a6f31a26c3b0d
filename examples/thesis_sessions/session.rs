//! Plays a design through in time: mounts the pivot, sets it at the start position, sweeps, reads; nothing is fitted here.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::besides::Besides;
use super::design::{
    A_SWEEP_DEG, Axis, Bar, C_SWEEP_DEG, Carrier, Design, Direction, FEED_MM_MIN, Mounting, RADIUS_MM, RUNS, Test,
};
use super::kinematics::{AxisLocation, Trunnion, distance_mm};
use super::noise::{Instrument, normal};

/// Pivot placement across the bar after setting with the spindle's own cup, 1 sigma a coordinate.
pub const PIVOT_UM: f64 = 20.0;
/// What is left along the bar after moving the pivot until the bar reads its nominal at the start position, 1 sigma.
pub const START_UM: f64 = 2.0;
/// Spindle ball off the spindle's reference point, 1 sigma a coordinate: the thesis holds its run-out within 1 µm.
pub const SPINDLE_BALL_UM: f64 = 1.0;
/// Error of the bar's calibrated length, 1 sigma.
pub const BAR_UM: f64 = 0.5;
/// Calibrated lengths of the short and the extended bar, mm.
pub const BAR_LENGTH_MM: [f64; 2] = [99.9881, 149.9946];

const MOUNT_PIVOT_S: f64 = 600.0;
const CHANGE_BAR_S: f64 = 240.0;
const TURN_ROUND_S: f64 = 8.0;
const DRIVE_BACK_S: f64 = 25.0;
const SAMPLE_S: [f64; 2] = [0.1, 0.25];

/// One recording: rows of time, axis position and length.
pub struct Run {
    pub test: Test,
    pub mounting: usize,
    pub name: String,
    pub started_at_s: f64,
    pub rows: Vec<[f64; 3]>,
}

/// Everything that happened, and the truth behind it.
pub struct Session {
    pub design: Design,
    pub pivot_errors_um: Vec<[f64; 3]>,
    pub spindle_ball_error_um: [f64; 3],
    pub bar_errors_um: [f64; 2],
    /// Root mean square of reading minus true length minus bar error.
    pub noise_rms_um: f64,
    pub runs: Vec<Run>,
}

/// The machine that a list of errors in µm and arcsec describes.
pub fn trunnion(errors: &[f64; 8]) -> Trunnion {
    let um = |k: usize| errors[k] * 1e-3;
    let arcsec = |k: usize| (errors[k] / 3600.0).to_radians();
    Trunnion {
        a: AxisLocation { shift_mm: [0.0, um(0), um(1)], tilt_rad: [0.0, arcsec(2), arcsec(3)] },
        c: AxisLocation { shift_mm: [um(4), um(5), 0.0], tilt_rad: [arcsec(6), arcsec(7), 0.0] },
    }
}

fn sum(a: [f64; 3], b_um: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] + b_um[k] * 1e-3)
}

/// The balls of a test: what the pivot stands on, its place and the spindle ball's.
#[derive(Clone, Copy)]
struct Balls {
    carrier: Carrier,
    pivot_mm: [f64; 3],
    spindle_mm: [f64; 3],
}

/// Distance of the balls with one rotary axis at an angle and the other at 0.
fn length_mm(machine: &Trunnion, axis: Axis, at_deg: f64, balls: Balls, besides: &Besides) -> f64 {
    let (a_deg, c_deg) = match axis {
        Axis::A => (at_deg, 0.0),
        Axis::C => (0.0, at_deg),
    };
    let mut table_mm = match balls.carrier {
        Carrier::TiltingTable => machine.tilting_ball_mm(a_deg, balls.pivot_mm),
        Carrier::Table => machine.table_ball_mm(a_deg, c_deg, balls.pivot_mm),
    };
    table_mm[0] += besides.along_mm(Axis::A, a_deg);
    if balls.carrier == Carrier::Table {
        let (along_mm, (sin, cos)) = (besides.along_mm(Axis::C, c_deg), a_deg.to_radians().sin_cos());
        table_mm[1] -= along_mm * sin;
        table_mm[2] += along_mm * cos;
    }
    distance_mm(table_mm, balls.spindle_mm)
}

fn sweep_deg(axis: Axis) -> (f64, f64) {
    match axis {
        Axis::A => A_SWEEP_DEG,
        Axis::C => C_SWEEP_DEG,
    }
}

/// Places the pivot: across the bar as well as the setting cup allows, along the bar until it reads its nominal length.
fn place_pivot(
    machine: &Trunnion,
    mounting: &Mounting,
    spindle_error_um: [f64; 3],
    scatter: f64,
    random: &mut ChaCha8Rng,
) -> [f64; 3] {
    let test = &mounting.tests[0];
    let mut error_um: [f64; 3] = std::array::from_fn(|_| scatter * PIVOT_UM * normal(random));
    let radial = if mounting.pivot_mm[1] == 0.0 { 0 } else { 1 };
    let outward = mounting.pivot_mm[radial].signum();
    let left_um = scatter * START_UM * normal(random);
    let spindle_mm = sum(test.spindle_mm, spindle_error_um);
    // the bar lies along the radius at the start, so the reading answers the move one to one
    for _ in 0..3 {
        let pivot_mm = sum(mounting.pivot_mm, error_um);
        let balls = Balls { carrier: mounting.carrier, pivot_mm, spindle_mm };
        let reads_mm = length_mm(machine, test.axis, sweep_deg(test.axis).0, balls, &Besides::default());
        error_um[radial] += outward * (left_um - (reads_mm - RADIUS_MM) * 1e3);
    }
    error_um
}

/// One circle of a design as it stands: its test, balls and what the bar reads too much.
struct Circle<'a> {
    machine: &'a Trunnion,
    besides: &'a Besides,
    /// In the order of the design.
    index: usize,
    test: &'a Test,
    balls: Balls,
    bar_um: f64,
}

impl Circle<'_> {
    /// Length that the bar would read without noise at an angle and a session time, mm.
    fn expected_mm(&self, at_deg: f64, time_s: f64) -> f64 {
        let off_um = self.besides.spindle_um(self.index, self.test.spindle_mm, time_s);
        let balls = Balls { spindle_mm: sum(self.balls.spindle_mm, off_um), ..self.balls };
        let wrong_um = self.bar_um + self.besides.reading_um(self.index, at_deg);
        length_mm(self.machine, self.test.axis, at_deg, balls, self.besides) + wrong_um * 1e-3
    }

    /// Readings of one run that begins at a session time, and how long it lasts, s; the noise goes to a list, µm.
    fn run(
        &self,
        direction: Direction,
        begins_s: f64,
        instrument: &mut Option<&mut Instrument>,
        noise_um: &mut Vec<f64>,
    ) -> (Vec<[f64; 3]>, f64) {
        let (low, high) = sweep_deg(self.test.axis);
        let (from, to) = match direction {
            Direction::Ccw => (low, high),
            Direction::Cw => (high, low),
        };
        let speed_deg_s = (FEED_MM_MIN / 60.0 / RADIUS_MM).to_degrees();
        let lasts_s = (to - from).abs() / speed_deg_s;
        let sample_s = SAMPLE_S[self.test.axis as usize];
        let rows = (0..=(lasts_s / sample_s) as usize).map(|k| {
            let time_s = k as f64 * sample_s;
            let at_deg = from + (to - from).signum() * speed_deg_s * time_s;
            let expected_mm = self.expected_mm(at_deg, begins_s + time_s);
            let read_mm = match instrument {
                Some(instrument) => instrument.read_mm(begins_s + time_s, expected_mm),
                None => expected_mm,
            };
            noise_um.push((read_mm - expected_mm) * 1e3);
            [time_s, at_deg, read_mm]
        });
        (rows.collect(), lasts_s)
    }
}

/// Plays one design; the seed and the chapter alone decide every draw. `scatter` multiplies all errors of setting up and
/// reading: 1 for a session, 0 for what the design returns by itself (then unrounded).
pub fn play(design: Design, seed: u64, scatter: f64) -> Session {
    play_with(design, seed, scatter, &Besides::default())
}

/// The same with what acts beside the location errors.
pub fn play_with(design: Design, seed: u64, scatter: f64, besides: &Besides) -> Session {
    let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(1000).wrapping_add(design.chapter));
    let machine = trunnion(&design.errors);
    let drawn_um = std::array::from_fn(|_| scatter * SPINDLE_BALL_UM * normal(&mut random));
    let spindle_ball_error_um = besides.ball_um.unwrap_or(drawn_um);
    let bar_errors_um = std::array::from_fn(|_| scatter * BAR_UM * normal(&mut random));
    let pivot_errors_um: Vec<[f64; 3]> = design
        .mountings
        .iter()
        .map(|mounting| place_pivot(&machine, mounting, spindle_ball_error_um, scatter, &mut random))
        .collect();
    let mut instrument = Instrument::new(random);
    let mut instrument = (scatter > 0.0).then_some(&mut instrument);
    let mut now_s = 0.0;
    let mut runs = Vec::new();
    let mut noise_um = Vec::new();
    let mut circles = 0;
    for (mounted, mounting) in design.mountings.iter().enumerate() {
        now_s += MOUNT_PIVOT_S;
        let pivot_mm = sum(mounting.pivot_mm, pivot_errors_um[mounted]);
        for test in &mounting.tests {
            now_s += CHANGE_BAR_S;
            let spindle_mm = sum(test.spindle_mm, spindle_ball_error_um);
            let balls = Balls { carrier: mounting.carrier, pivot_mm, spindle_mm };
            let bar_um = bar_errors_um[test.bar as usize];
            let circle = Circle { machine: &machine, besides, index: circles, test, balls, bar_um };
            circles += 1;
            let mut last = None;
            let mut count = [0, 0];
            for direction in RUNS {
                now_s += if last == Some(direction) { DRIVE_BACK_S } else { TURN_ROUND_S };
                now_s = (now_s * 10.0).ceil() / 10.0;
                last = Some(direction);
                count[direction as usize] += 1;
                let (rows, lasts_s) = circle.run(direction, now_s, &mut instrument, &mut noise_um);
                let way = match direction {
                    Direction::Ccw => "ccw",
                    Direction::Cw => "cw",
                };
                let name = format!("{}-{way}-{}", test.name, count[direction as usize]);
                runs.push(Run { test: test.clone(), mounting: mounted, name, started_at_s: now_s, rows });
                now_s += lasts_s;
            }
        }
    }
    let square: f64 = noise_um.iter().map(|e| e * e).sum();
    let noise_rms_um = (square / noise_um.len() as f64).sqrt();
    Session { design, pivot_errors_um, spindle_ball_error_um, bar_errors_um, noise_rms_um, runs }
}

/// Calibrated length of the bar that a test uses, mm.
pub fn bar_length_mm(bar: Bar) -> f64 {
    BAR_LENGTH_MM[bar as usize]
}

//! Sessions of one-axis sweeps with simulated readings, for the white-noise fits and their benchmark.

use std::path::Path;

use fiveaxis::chain::{Chain, Composition, Geometry};
use fiveaxis::identify::{Evidence, Problem, Quantity, Unknown};
use fiveaxis::load::machine_from_yaml;
use fiveaxis::machine::Component;
use fiveaxis::session::{Ball, Clock, Motion, Recording, Session, Setups, Spread, Test};
use fiveaxis::units::Measure;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// Noise of a reading: the resolution and repeatability of a ball bar.
pub const NOISE_MM: f64 = 0.5e-3;

/// The eight location errors of the thesis's machine: axis, component, true value (mm, rad).
pub const LOCATION_ERRORS: [(&str, Component, f64); 8] = [
    ("A", Component::EB, 1.745e-4),
    ("A", Component::EC, -1.222e-4),
    ("A", Component::EY, 0.010),
    ("A", Component::EZ, -0.008),
    ("C", Component::EA, 1.047e-4),
    ("C", Component::EB, -1.571e-4),
    ("C", Component::EX, 0.005),
    ("C", Component::EY, -0.004),
];

/// A sweep of one axis between two balls.
pub struct Sweep {
    pub axis: &'static str,
    pub from: f64,
    pub to: f64,
    pub pivot: [f64; 3],
    pub spindle: [f64; 3],
}

/// The thesis's four tests: A and C, each with the short and the long bar.
pub fn thesis_sweeps() -> Vec<Sweep> {
    let far = (150.0f64 * 150.0 - 100.0 * 100.0).sqrt();
    let (a_from, a_to, c_to) = (-20f64.to_radians(), 70f64.to_radians(), std::f64::consts::TAU);
    vec![
        Sweep { axis: "A", from: a_from, to: a_to, pivot: [0.0, 100.0, 0.0], spindle: [0.0, 0.0, 0.0] },
        Sweep { axis: "A", from: a_from, to: a_to, pivot: [0.0, 100.0, 0.0], spindle: [-far, 0.0, 0.0] },
        Sweep { axis: "C", from: 0.0, to: c_to, pivot: [100.0, 0.0, 0.0], spindle: [0.0, 0.0, 0.0] },
        Sweep { axis: "C", from: 0.0, to: c_to, pivot: [100.0, 0.0, 0.0], spindle: [0.0, 0.0, far] },
    ]
}

/// A session with `samples` noise-free readings per sweep of a machine with the errors above; every sweep has balls
/// and a bar of its own.
pub fn session(sweeps: &[Sweep], samples: usize) -> Session {
    let yaml = "name: four tests\ncode: '[wCAYbXZt]'\naxes: {}\n";
    let machine = machine_from_yaml(Path::new("four-tests.yaml"), yaml.into()).unwrap();
    let tests = sweeps.iter().enumerate().map(|(index, sweep)| {
        let tag = Some(format!("{index}"));
        let ball = |link: &str, at: [f64; 3]| Ball {
            link: link.into(),
            at: Vector3::from(at),
            setup: tag.clone(),
            spread_mm: None,
            indexed_about: None,
        };
        let axis = machine.axis_index(sweep.axis).unwrap();
        let step = (sweep.to - sweep.from) / (samples - 1) as f64;
        Test {
            name: format!("{}{index}", sweep.axis),
            recording_file: None,
            recording: Some(Recording {
                clock: Clock::TimeS((0..samples).map(|k| k as f64 * 0.01).collect()),
                axes: vec![axis],
                positions: vec![(0..samples).map(|k| sweep.from + step * k as f64).collect()],
                length_mm: vec![0.0; samples],
                channels: Vec::new(),
                leading_texts: std::sync::Arc::default(),
                leading_header: String::new(),
                column: Default::default(),
            }),
            path: None,
            started_at_s: 0.0,
            bar_length_mm: Some(100.0),
            bar_setup: tag.clone(),
            zero: Default::default(),
            bar_error_mm: 0.0,
            pivot: ball("w", sweep.pivot),
            spindle_ball: ball("t", sweep.spindle),
            positions: (0..5).map(|k| (k != axis).then_some(0.0)).collect(),
            feed_mm_per_min: None,
            overshoot: None,
            marks: None,
            approached: Vec::new(),
            reading: fiveaxis::readings::Reading::Length,
        }
    });
    let mut session = Session {
        name: "four tests".into(),
        machine_file: "four-tests.yaml".into(),
        tests: tests.collect(),
        machine,
        spread: Spread::default(),
    };
    fill_readings(&mut session);
    session
}

/// Readings of the machine with its true errors and bars, balls where they are stated.
fn fill_readings(session: &mut Session) {
    let chain = Chain::of(&session.machine);
    let mut errors = vec![[0.0; 6]; chain.axis_count()];
    for (axis, component, value) in LOCATION_ERRORS {
        errors[session.machine.axis_index(axis).unwrap()][component.index()] = value;
    }
    let geometry = Geometry::new(&chain, &errors, Composition::Exact);
    for index in 0..session.tests.len() {
        let test = &session.tests[index];
        let motion = Motion::of(session, &chain, test).unwrap();
        let links = test.links(&chain).unwrap();
        let (pivot, spindle) = (test.pivot.at, test.spindle_ball.at);
        let lengths = (0..motion.rows())
            .map(|row| geometry.length((links.0, &pivot), (links.1, &spindle), motion.row(row), None))
            .map(|length| length + true_bar(session, index))
            .collect();
        if let Some(recording) = &mut session.tests[index].recording {
            recording.length_mm = lengths;
        }
    }
}

/// Reading error of a test's bar, mm.
pub fn true_bar(_: &Session, test: usize) -> f64 {
    [1e-3, -2e-3, 0.5e-3, 1.5e-3][test % 4]
}

fn location_unknowns(session: &Session) -> Vec<Unknown> {
    let unknown = |(axis, component, _): (&str, Component, f64)| Unknown {
        quantity: Quantity::Location { axis: session.machine.axis_index(axis).unwrap(), component },
        label: format!("{component:?}0{axis}"),
        measure: Measure::Length,
        prior_sigma: f64::INFINITY,
        prior_mean: 0.0,
    };
    LOCATION_ERRORS.into_iter().map(unknown).collect()
}

fn setup_unknown(quantity: Quantity, prior_sigma: f64) -> Unknown {
    Unknown { quantity, label: format!("{quantity:?}"), measure: Measure::Length, prior_sigma, prior_mean: 0.0 }
}

/// Eight location errors and the reading error of every bar, no priors: 12 unknowns for four tests.
pub fn unknowns_without_priors(session: &Session) -> Vec<Unknown> {
    let mut unknowns = location_unknowns(session);
    unknowns.extend((0..session.tests.len()).map(|setup| setup_unknown(Quantity::Bar { setup }, f64::INFINITY)));
    unknowns
}

/// Eight location errors and both balls of every test with a prior of 5 µm per coordinate: 32 unknowns for four tests.
pub fn unknowns_with_priors(session: &Session) -> Vec<Unknown> {
    let mut unknowns = location_unknowns(session);
    for setup in 0..session.tests.len() {
        for coordinate in 0..3 {
            unknowns.push(setup_unknown(Quantity::Pivot { setup, coordinate }, 5e-3));
            unknowns.push(setup_unknown(Quantity::SpindleBall { setup, coordinate }, 5e-3));
        }
    }
    unknowns
}

/// Everything that a fit borrows.
pub struct Prepared {
    pub session: Session,
    pub chain: Chain,
    pub setups: Setups,
}

impl Prepared {
    pub fn of(sweeps: &[Sweep], samples: usize) -> Prepared {
        let session = session(sweeps, samples);
        Prepared { chain: Chain::of(&session.machine), setups: Setups::of(&session), session }
    }

    pub fn problem(&self, unknowns: Vec<Unknown>) -> Problem<'_> {
        Problem::new(&self.session, &self.chain, &self.setups, unknowns).unwrap()
    }
}

/// Readings of every test with white noise of a seed.
pub fn noisy_readings(problem: &Problem, seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, NOISE_MM).unwrap();
    let noisy = |readings: &Vec<f64>| readings.iter().map(|reading| reading + noise.sample(&mut rng)).collect();
    problem.tests.iter().map(|test| &test.reading_mm).map(noisy).collect()
}

/// Samples of all tests with the given readings.
pub fn samples(problem: &Problem, readings: &[Vec<f64>]) -> Vec<Evidence> {
    (0..problem.tests.len()).map(|test| Evidence::samples(problem, test, &[]).with_readings(&readings[test])).collect()
}

/// The same, compressed about the prior means.
pub fn compressed(problem: &Problem, samples: &[Evidence]) -> Vec<Evidence> {
    let start: Vec<f64> = problem.unknowns.iter().map(|unknown| unknown.prior_mean).collect();
    samples.iter().enumerate().map(|(test, evidence)| evidence.clone().compressed(problem, test, &start)).collect()
}

//! What `report` writes as YAML, `load` reads back unchanged: shipped machines, committed sessions and random ones.

use crate::shared_data;
use std::path::{Path, PathBuf};

use fiveaxis::load::{load_machine, load_session, machine_from_yaml};
use fiveaxis::machine::{AxisKind, Component, ComponentError, ComponentForm, Directions, Harmonic, Machine};
use fiveaxis::report::{machine_yaml, session_yaml};
use fiveaxis::session::{Ball, CirclePlane, Follow, Marks, Path as TestPath, Session, Spread, Test};
use nalgebra::Vector3;
use rand::RngExt;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

fn project(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)
}

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries.filter(|file| file.extension().is_some_and(|e| e == extension)).collect();
    files.sort();
    files
}

fn reads_back(machine: &Machine) {
    let text = machine_yaml(machine);
    let read = machine_from_yaml(Path::new("written.yaml"), text.clone()).unwrap_or_else(|why| panic!("{why}\n{text}"));
    assert_eq!(read, *machine, "{text}");
}

#[test]
fn shipped_machines_read_back() {
    let files = files(&project("machines"), "yaml");
    assert!(files.len() >= 16, "{}", files.len());
    for file in files {
        reads_back(&load_machine(&file).unwrap());
    }
}

/// A session written beside a copy of its recordings reads back as the same value.
fn session_reads_back(session: &Session, recordings: Option<&Path>) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(&session.machine_file), machine_yaml(&session.machine)).unwrap();
    let text = session_yaml(session);
    let file = folder.path().join("session.yaml");
    std::fs::write(&file, &text).unwrap();
    for name in session.tests.iter().filter_map(|test| test.recording_file.as_ref()) {
        if let Some(from) = recordings {
            std::fs::copy(from.join(name), folder.path().join(name)).unwrap();
        }
    }
    let read = load_session(&file).unwrap_or_else(|why| panic!("{why}\n{text}"));
    assert_eq!(read.machine, session.machine);
    assert_eq!(read.spread, session.spread);
    for (found, due) in read.tests.iter().zip(&session.tests) {
        // missing readings are NaN, which is not equal to itself
        assert_eq!(format!("{found:?}"), format!("{due:?}"), "{text}");
    }
    assert_eq!(read.tests.len(), session.tests.len());
    assert_eq!((read.name, read.machine_file), (session.name.clone(), session.machine_file.clone()));
}

#[test]
fn committed_sessions_read_back() {
    for chapter in ["chapter4", "chapter5", "chapter6"] {
        let folder = project("examples/thesis").join(chapter);
        session_reads_back(&load_session(&folder.join("session.yaml")).unwrap(), Some(&folder));
    }
}

#[test]
fn practice_sessions_read_back() {
    let Some(folder) = shared_data::folder("recordings/practice") else { return };
    for case in ["case-001", "case-005", "case-012"] {
        let folder = folder.join(case);
        session_reads_back(&load_session(&folder.join("session.yaml")).unwrap(), Some(&folder));
    }
}

#[test]
fn random_machines_and_sessions_read_back() {
    let seed = 20_240_501;
    println!("seed {seed}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let shipped: Vec<Machine> =
        files(&project("machines"), "yaml").iter().map(|file| load_machine(file).unwrap()).collect();
    for round in 0..60 {
        let mut machine = shipped[round % shipped.len()].clone();
        disturb(&mut machine, &mut random);
        reads_back(&machine);
        session_reads_back(&random_session(machine, &mut random), None);
    }
}

/// Random errors, component errors, inclined directions, machine zeros and link names.
fn disturb(machine: &mut Machine, random: &mut ChaCha8Rng) {
    machine.name = "Versuch \"7\": µ # {x} \\ -".into();
    for axis in &mut machine.axes {
        for error in &mut axis.location_errors {
            if random.random_bool(0.5) {
                *error = random.random_range(-1e-2..1e-2);
            }
        }
        axis.reversed = random.random_bool(0.3);
        axis.origin = Vector3::from_fn(|_, _| random.random_range(-500.0..500.0));
        if random.random_bool(0.3) {
            axis.direction = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0)).normalize();
        }
        if random.random_bool(0.2) {
            axis.range = None;
        }
        let forms = [
            ComponentForm::Polynomial((0..3).map(|_| random.random_range(-1e-4..1e-4)).collect()),
            ComponentForm::Fourier(vec![Harmonic {
                frequency: match axis.kind {
                    AxisKind::Rotary => 2.0,
                    AxisKind::Linear => std::f64::consts::TAU / random.random_range(5.0..50.0f64),
                },
                cosine: 1e-3,
                sine: random.random_range(-1e-3..1e-3),
            }]),
            ComponentForm::Table {
                position: [-10.0, 0.5, 30.0].map(|value| axis.kind.from_file_unit(value)).to_vec(),
                value: (0..3).map(|_| random.random_range(-1e-3..1e-3)).collect(),
            },
        ];
        let components = [Component::EX, Component::EB, Component::EC];
        axis.component_errors = components
            .into_iter()
            .zip(forms)
            .map(|(component, form)| ComponentError { component, form: written_once(axis.kind, form) })
            .collect();
    }
    machine.directions = [None, Some(Directions::Carried), Some(Directions::Iso841)][random.random_range(0..3)];
    machine.machine_zero[0] = Some(random.random_range(-1000.0..1000.0));
    machine.caveats = vec!["no maker's drawing: \"round\" values".into(), "# not a comment".into()];
    machine.gauge_length_mm = Some(random.random_range(50.0..300.0));
    machine.link_names = vec![("table plate".into(), Some(0)), ("true".into(), None)];
    // a file states degrees and um: values that no decimal reaches exactly settle after one writing
    *machine = machine_from_yaml(Path::new("once.yaml"), machine_yaml(machine)).unwrap();
}

fn written_once(kind: AxisKind, form: ComponentForm) -> ComponentForm {
    match (kind, form) {
        // polynomials of rotary axes are stated per degree: round to what a file can state
        (AxisKind::Rotary, ComponentForm::Polynomial(list)) => ComponentForm::Polynomial(
            list.iter().enumerate().map(|(k, c)| (c * 1e6).round() * 1e-6 * 1f64.to_degrees().powi(k as i32)).collect(),
        ),
        (_, form) => form,
    }
}

fn random_session(machine: Machine, random: &mut ChaCha8Rng) -> Session {
    let linear: Vec<usize> =
        (0..machine.axes.len()).filter(|&axis| machine.axes[axis].kind == AxisKind::Linear).collect();
    let axis_count = machine.axes.len();
    let tests = (0..4)
        .map(|index| {
            let mut number = |from: f64, to: f64| random.random_range(from..to);
            let path = if index % 2 == 0 {
                // slides follow a rotary axis alone
                let turns = machine.axes[0].kind == AxisKind::Rotary;
                let follow = if index == 0 && turns { Follow::Radial } else { Follow::None };
                TestPath::Sweep {
                    axis: 0,
                    from: -1.0,
                    to: number(0.0, 3.0),
                    step: number(0.01, 0.5),
                    follow,
                    length_mm: None,
                }
            } else {
                let plane = CirclePlane { first: linear[1], second: linear[0] };
                TestPath::Circle { plane, radius_mm: number(10.0, 20.0), from: 0.0, to: 360.0, step: 1.0 }
            };
            let mut ball = |link: &str| Ball {
                link: link.into(),
                at: Vector3::new(number(-99.0, 99.0), 0.1, -0.0),
                setup: (index == 2).then(|| "second: time".into()),
                spread_mm: (index == 3).then(|| number(1e-4, 1e-1)),
                indexed_about: (link != "w" && index > 0).then_some(index % 3),
            };
            let (pivot, spindle_ball) = (ball("w"), ball("table plate"));
            Test {
                name: format!("test {index}: \"quoted\""),
                recording_file: (index == 1).then(|| "planned name.csv".into()),
                recording: None,
                path: Some(path),
                started_at_s: number(0.0, 1e4),
                bar_length_mm: (index != 0).then(|| number(50.0, 300.0)),
                bar_setup: (index == 3).then(|| "2".into()),
                zero: Default::default(),
                bar_error_mm: if index > 1 { number(-1e-2, 1e-2) } else { 0.0 },
                pivot,
                spindle_ball,
                positions: (0..axis_count)
                    .map(|axis| Some(machine.axes[axis].kind.from_file_unit((number(0.0, 9.0) * 1e4).round() / 1e4)))
                    .collect(),
                feed_mm_per_min: (index > 0).then(|| number(10.0, 5000.0)),
                overshoot: (index == 1).then(|| number(0.0, 5.0)),
                marks: (index % 2 == 1).then(|| Marks {
                    move_mm: number(0.02, 0.9) * if index == 1 { -1.0 } else { 1.0 },
                    feed_mm_per_min: number(1.0, 100.0),
                    hold_s: number(0.1, 5.0),
                    rest_s: number(0.1, 5.0),
                    gap_s: number(0.1, 9.0),
                    seen_mm: (index == 3).then(|| [number(-0.5, 0.5), number(-0.5, 0.5)]),
                }),
                approached: (0..axis_count)
                    .map(|axis| (axis == index).then_some(if axis % 2 == 0 { 1.0 } else { -1.0 }))
                    .collect(),
                reading: fiveaxis::readings::Reading::Length,
            }
        })
        .collect();
    let spread = Spread {
        pivot_mm: 0.0123,
        spindle_ball_mm: random.random_range(1e-4..1e-2),
        bar_length_mm: 5e-4,
        pivot_length_mm: 0.0,
    };
    Session { name: "12".into(), machine_file: "machine.yaml".into(), machine, spread, tests }
}

//! Trends: drifts and steps are found at their size, scatter is not taken for either, and the command reads dated folders.

use std::path::Path;

use assert_cmd::Command;
use fiveaxis::history::{Course, Point, trend};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

/// Twelve sessions a month apart, values known to 0.3 with a scatter of 0.4 between sessions.
fn sessions(seed: u64, course: impl Fn(f64) -> f64) -> Vec<Point> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let noise = Normal::new(0.0, (0.3f64 * 0.3 + 0.4 * 0.4).sqrt()).expect("normal");
    (0..12)
        .map(|k| {
            let day = 30.0 * f64::from(k);
            Point { day, value: 5.0 + course(day) + noise.sample(&mut random), sigma: 0.3 }
        })
        .collect()
}

#[test]
fn drifts_and_steps_are_told_from_scatter() {
    let (mut false_alarms, mut drifts, mut steps, mut within) = (0, 0, 0, 0);
    const RUNS: u64 = 400;
    for seed in 0..RUNS {
        if trend(&sessions(seed, |_| 0.0)).course != Course::Steady {
            false_alarms += 1;
        }
        // 0.3 a month: 3.3 over the year
        if let Course::Drift { per_day, sigma } = trend(&sessions(1000 + seed, |day| 0.01 * day)).course {
            drifts += 1;
            within += u64::from((per_day - 0.01).abs() < 2.0 * sigma);
        }
        let course = trend(&sessions(2000 + seed, |day| if day > 170.0 { 3.0 } else { 0.0 })).course;
        if let Course::Step { by, sigma, after_day, before_day } = course {
            assert!(after_day < before_day);
            let is_there = after_day == 150.0 && before_day == 180.0;
            steps += u64::from(is_there && (by - 3.0).abs() < 4.0 * sigma);
        }
    }
    println!("false {false_alarms}, drifts {drifts} ({within} within two sigma), steps {steps} of {RUNS}");
    assert!(false_alarms <= RUNS / 20, "{false_alarms} of {RUNS} steady courses are told as moving");
    assert!(drifts >= RUNS * 9 / 10 && within * 100 >= drifts * 85, "{drifts}, {within}");
    assert!(steps >= RUNS * 9 / 10, "{steps}");
    // three sessions tell nothing
    assert_eq!(trend(&sessions(1, |day| day)[..3]).course, Course::Steady);
}

#[test]
fn few_sessions_tell_a_step_and_a_drift_that_are_far_above_their_scatter() {
    const RUNS: u64 = 100;
    for sessions in 4..=8 {
        let mut random = ChaCha8Rng::seed_from_u64(sessions);
        let noise = Normal::new(0.0, 0.05).expect("normal");
        let (mut told, mut within) = (0, 0);
        for _ in 0..RUNS {
            let mut points = |course: &dyn Fn(u64) -> f64| -> Vec<Point> {
                let of = |k| Point {
                    day: 30.0 * k as f64,
                    value: 10.0 + course(k) + noise.sample(&mut random),
                    sigma: 0.05,
                };
                (0..sessions).map(of).collect()
            };
            let step = trend(&points(&|k| if k >= sessions / 2 { 200.0 } else { 0.0 }));
            let drift = trend(&points(&|k| 50.0 * k as f64));
            if let Course::Step { by, sigma, .. } = step.course {
                (told, within) = (told + 1, within + u64::from((by - 200.0).abs() < 2.0 * sigma));
            }
            if let Course::Drift { per_day, sigma } = drift.course {
                (told, within) = (told + 1, within + u64::from((30.0 * per_day - 50.0).abs() < 60.0 * sigma));
            }
        }
        println!("{sessions} sessions: {told} of {} told, {within} within two sigma", 2 * RUNS);
        assert_eq!(told, 2 * RUNS, "{sessions} sessions");
        assert!(within * 100 >= told * 90, "{sessions} sessions: {within} of {told}");
    }
}

#[test]
fn a_machine_that_only_scatters_is_told_steady_however_few_the_sessions() {
    // eight errors of a machine, sessions that know them to 0.2 and scatter by less and more: one machine in twenty at most is told as moving
    const MACHINES: u64 = 400;
    for sessions in [4, 5, 6, 7, 8, 12] {
        let mut random = ChaCha8Rng::seed_from_u64(sessions);
        for scatter in [0.3, 4.0, 0.5, 0.7, 1.0, 1.4] {
            let noise = Normal::new(0.0, scatter).expect("normal");
            let moves = |random: &mut ChaCha8Rng| {
                let of = |k| Point { day: 30.0 * k as f64, value: noise.sample(random), sigma: 0.2 };
                trend(&(0..sessions).map(of).collect::<Vec<_>>()).course != Course::Steady
            };
            let told = (0..MACHINES).filter(|_| (0..8).fold(false, |told, _| moves(&mut random) || told)).count();
            println!("{sessions} sessions, scatter {scatter}: {told} of {MACHINES}");
            assert!(told as u64 <= MACHINES / 20, "{sessions} sessions, scatter {scatter}: {told} of {MACHINES}");
        }
    }
}

#[test]
fn the_command_reads_a_folder_of_dated_sessions() {
    let scratch = tempfile::tempdir().expect("folder");
    let copy = |to: &str| copied("examples/thesis/chapter5", &scratch.path().join(to));
    copy("2026-01-10");
    copy("2026-02-11-after-service");
    let (code, value) = run(scratch.path());
    assert_eq!(code, Some(0), "{value}");
    assert_eq!(value["sessions"][1]["day"], 32.0);
    let error =
        value["errors"].as_array().expect("errors").iter().find(|error| error["error"] == "EY0C").expect("EY0C");
    assert!((error["mean"].as_f64().expect("mean") + 52.9).abs() < 0.1 && error["course"]["kind"] == "steady");
    // two of one day, whose names tell no time, and two that do
    copy("2026-02-11-before-service");
    let (_, value) = run(scratch.path());
    assert!(value["warnings"].to_string().contains("are of one time"), "{value}");
    std::fs::remove_dir_all(scratch.path().join("2026-02-11-before-service")).expect("removed");
    copy("2026-02-11T18-00-evening");
    let (code, value) = run(scratch.path());
    assert!(code == Some(0) && !value["warnings"].to_string().contains("are of one time"), "{value}");
    assert_eq!(
        (&value["sessions"][2]["day"], &value["sessions"][2]["date"]),
        (&32.75.into(), &"2026-02-11 18:00".into())
    );
    copy("yesterday");
    let (code, value) = run(scratch.path());
    assert_eq!(code, Some(2));
    assert!(value["error"].to_string().contains("no date in its name"), "{value}");
}

/// Exit code and output of the command on a folder.
fn run(folder: &Path) -> (Option<i32>, serde_json::Value) {
    let output =
        Command::cargo_bin("fiveaxis").expect("built").arg("history").arg(folder).arg("--json").output().expect("run");
    let text = String::from_utf8(output.stdout).expect("text");
    (output.status.code(), serde_json::from_str(&text).expect("JSON"))
}

/// A session of a folder under a name, copied from the examples.
fn copied(from: &str, folder: &Path) {
    std::fs::create_dir_all(folder).expect("folder");
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(from)).expect("example") {
        let file = entry.expect("entry").path();
        std::fs::copy(&file, folder.join(file.file_name().expect("name"))).expect("copied");
    }
}

#[test]
fn a_history_is_of_one_machine_and_of_days_of_the_calendar() {
    let scratch = tempfile::tempdir().expect("folder");
    copied("examples/thesis/chapter5", &scratch.path().join("2024-02-29"));
    // a folder without a session is named
    std::fs::create_dir(scratch.path().join("2024-03-10")).expect("folder");
    let (code, value) = run(scratch.path());
    assert_eq!(code, Some(0), "{value}");
    assert!(value["warnings"].to_string().contains("2024-03-10 is left out: it holds no session.yaml"), "{value}");
    // two machines of one code
    copied("examples/gallery/01-worm-gear", &scratch.path().join("2024-03-10"));
    let (code, value) = run(scratch.path());
    assert_eq!(code, Some(2));
    let says = value["error"].to_string();
    assert!(says.contains("Five-axis 200") && says.contains("Hermle C600U") && says.contains("one machine"), "{says}");
    // the same name, an axis elsewhere
    std::fs::remove_dir_all(scratch.path().join("2024-03-10")).expect("removed");
    let moved = scratch.path().join("2024-04-30");
    copied("examples/thesis/chapter5", &moved);
    let machine = std::fs::read_to_string(moved.join("machine.yaml")).expect("machine");
    std::fs::write(moved.join("machine.yaml"), machine.replace("A: {origin: [0, 0, 0]", "A: {origin: [0, 0, 0.01]"))
        .expect("written");
    let (code, value) = run(scratch.path());
    assert_eq!(code, Some(2));
    assert!(value["error"].to_string().contains("A about"), "{value}");
    for wrong in ["2025-02-30", "2025-04-31", "2023-02-29", "2025-13-01", "0000-01-01"] {
        let scratch = tempfile::tempdir().expect("folder");
        copied("examples/thesis/chapter5", &scratch.path().join(wrong));
        let (code, value) = run(scratch.path());
        assert_eq!(code, Some(2), "{wrong}");
        assert!(value["error"].to_string().contains(&format!("{wrong} is no day of the calendar")), "{value}");
    }
}

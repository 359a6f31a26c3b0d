//! Captures in one piece, as gauges write them, are placed where the machine was; what cannot be placed is refused.
//!
//! `FIVEAXIS_CAPTURES` says how many simulated captures are placed (example `import_trial` prints each); one of each test else.

use crate::captured;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::LazyLock;

use captured::{Drawn, Erring, HABITS, Habit, Kind, Planned, planned};
use fiveaxis::import::{Feeds, ImportError, Pair, place, recordings};
use fiveaxis::load::{CaptureHints, Moment, load_capture};
use fiveaxis::session::{Follow, LengthColumn, Path as TestPath};
use serde_json::Value;

/// Axis positions that a placement must reach where the readings tell more, deg.
const REACH_DEG: f64 = 0.05;

/// The plan that most tests share, its programs with marks and without.
static MARKED: LazyLock<Planned> = LazyLock::new(|| planned("hermle-c600u.yaml", 1500.0, true));
static PLAIN: LazyLock<Planned> = LazyLock::new(|| planned("hermle-c600u.yaml", 1500.0, false));
/// At 1500 mm/min the shortest run takes 2.8 s: two paces leave two places open there, which is refused.
static SLOW: LazyLock<Planned> = LazyLock::new(|| planned("hermle-c600u.yaml", 500.0, true));

fn count(usual: u64) -> u64 {
    std::env::var("FIVEAXIS_CAPTURES").map_or(usual, |count| count.parse().expect("a number of captures"))
}

/// Captures of a plan's programs, each sought among all tests of the plan.
fn placed_among_all(planned: &Planned, seeds: std::ops::Range<u64>) {
    let mut good = 0;
    let count = seeds.end - seeds.start;
    for seed in seeds {
        let pair = seed as usize % planned.pairs.len();
        let drawn = planned.drawn(&mut Erring::drawn(&planned.session.machine, seed), pair, seed, Kind::Sound);
        let placement = match place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed) {
            Ok(placement) => placement,
            Err(why) => {
                println!("{seed}: {}: {why}", drawn.says);
                continue;
            }
        };
        assert_eq!(placement.pair, planned.pairs[pair], "{seed}: {}", drawn.says);
        assert!(placement.by_marks, "{seed}");
        let (off, [(there, _), (back, _)]) = planned.compared(&drawn, &placement);
        println!("{seed}: {}: off {off:.4} sigma {:.4}", drawn.says, placement.position_sigma);
        assert!(off < REACH_DEG.max(6.0 * placement.position_sigma), "{seed}: {}: misplaced by {off}", drawn.says);
        let pace_off = (placement.timing.pace() - drawn.pace).abs();
        assert!(pace_off < 2e-3 + 6.0 * placement.sigma[2], "{seed}: pace off by {pace_off}");
        good += u64::from(off < REACH_DEG.max(3.0 * placement.position_sigma));
        assert!(there.readings() > 50 && back.readings() > 50, "{seed}");
    }
    assert!(100 * good >= 99 * count, "{good} of {count}");
}

#[test]
fn captures_with_marks_are_placed_among_all_tests() {
    let planned = &*MARKED;
    // circles in YZ and ZX, which move alike, are among them
    assert!(planned.session.tests.iter().any(|test| test.name.starts_with("zx")));
    assert!(planned.session.tests.iter().all(|test| test.marks.is_some()));
    placed_among_all(planned, 0..count(planned.pairs.len() as u64));
}

fn refusal(planned: &Planned, among: &[Pair], drawn: &Drawn) -> ImportError {
    match place(&planned.session, among, &drawn.capture, Feeds::Programmed) {
        Ok(placement) => panic!("{}: placed to ± {}", drawn.says, placement.position_sigma),
        Err(why) => why,
    }
}

#[test]
fn what_was_cut_off_or_stood_still_is_refused() {
    for marks in [true, false] {
        let planned = if marks { &*MARKED } else { &*PLAIN };
        // a circle, whose readings tell much, and the example tries others
        let pair = planned.pairs.iter().position(|pair| planned.session.tests[pair.tests[0]].name.starts_with("xy"));
        let pair = pair.expect("a circle");
        let mut erring = Erring::drawn(&planned.session.machine, 5);
        for kind in [Kind::CutAtStart, Kind::CutAtEnd, Kind::BarOff, Kind::Standing] {
            let drawn = planned.drawn(&mut erring, pair, 5, kind);
            let why = refusal(planned, &[planned.pairs[pair]], &drawn);
            println!("{marks} {kind:?} {}: {why}", drawn.says);
            match (kind, marks) {
                (Kind::BarOff, _) => assert!(matches!(why, ImportError::BarOff { .. }), "{why}"),
                (Kind::CutAtStart | Kind::CutAtEnd, true) => {
                    assert!(matches!(why, ImportError::MarksMissing { .. }), "{why}");
                }
                (Kind::Standing, true) => {
                    assert!(matches!(why, ImportError::NoMarks { .. }), "{why}");
                    // among many tests none is meant
                    let among_all = refusal(planned, &planned.pairs, &drawn).to_string();
                    assert!(
                        among_all.starts_with("none of the 4 marks that a program of the session makes"),
                        "{among_all}"
                    );
                }
                _ => {}
            }
        }
    }
}

#[test]
fn another_program_s_capture_is_refused() {
    let planned = &*MARKED;
    let drawn = planned.drawn(&mut Erring::drawn(&planned.session.machine, 5), 1, 5, Kind::Sound);
    for (k, &other) in planned.pairs.iter().enumerate().filter(|(k, _)| *k != 1) {
        let why = refusal(planned, &[other], &drawn);
        println!("{} as {k}: {why}", drawn.says);
        let told = matches!(
            why,
            ImportError::OtherTest { .. } | ImportError::OtherRuns { .. } | ImportError::OtherFeed { .. }
        );
        assert!(told, "{why}");
    }
}

#[test]
fn circles_held_alike_in_both_runs_are_refused() {
    let planned = &*MARKED;
    // a short sweep whose lengths change little may pass for one with longer ramps
    let is_circle = |pair: &usize| {
        let name = &planned.session.tests[planned.pairs[*pair].tests[0]].name;
        ["xy", "yz", "zx"].iter().any(|plane| name.starts_with(plane))
    };
    for (pair, seed) in (0..planned.pairs.len()).filter(is_circle).flat_map(|pair| [(pair, 21), (pair, 22)]) {
        let drawn = planned.drawn(&mut Erring::drawn(&planned.session.machine, seed), pair, seed, Kind::Held);
        let why = refusal(planned, &planned.pairs, &drawn);
        println!("{}: {why}", drawn.says);
        assert!(matches!(why, ImportError::Uneven { .. } | ImportError::TooFlat { .. }), "{}: {why}", drawn.says);
    }
}

#[test]
fn what_a_machine_does_beside_location_errors_refuses_no_capture_with_marks() {
    let planned = &*MARKED;
    let machine = &planned.session.machine;
    let slides = ["X", "Y"].map(|name| machine.axis_index(name).expect("a slide"));
    for (pair, (wave_mm, play_mm)) in
        (0..planned.pairs.len()).zip([(2e-3, 0.0), (0.0, 6e-3), (4e-3, 4e-3)].iter().cycle())
    {
        let mut drawn =
            planned.drawn(&mut Erring::drawn(machine, 11 + pair as u64), pair, 11 + pair as u64, Kind::Sound);
        // a screw of each slide and its lost motion, as if all of it lay along the bar
        let mut before = drawn.positions[0].clone();
        let mut way = [1.0; 2];
        for (reading, q) in drawn.capture.reading_mm.iter_mut().zip(&drawn.positions) {
            for (way, &slide) in way.iter_mut().zip(&slides) {
                if (q[slide] - before[slide]).abs() > 1e-4 {
                    *way = (q[slide] - before[slide]).signum();
                }
                *reading += wave_mm * (std::f64::consts::TAU * q[slide] / 10.0).sin() - play_mm * *way;
            }
            before.clone_from(q);
        }
        let placement = place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed)
            .unwrap_or_else(|why| panic!("{}: {why}", drawn.says));
        assert_eq!(placement.pair, planned.pairs[pair], "{}", drawn.says);
        let (off, _) = planned.compared(&drawn, &placement);
        println!(
            "{}: off {off:.4} sigma {:.4} left {:.2} um",
            drawn.says,
            placement.position_sigma,
            1e3 * placement.left_mm
        );
        assert!(off < REACH_DEG.max(3.0 * placement.position_sigma), "{}: {off}", drawn.says);
    }
}

#[test]
fn captures_of_programs_without_marks_are_placed_by_their_lengths() {
    let planned = &*PLAIN;
    let pair = planned.pairs.iter().position(|pair| planned.session.tests[pair.tests[0]].name.starts_with("xy"));
    let pair = pair.expect("a circle");
    let drawn = planned.drawn(&mut Erring::drawn(&planned.session.machine, 7), pair, 7, Kind::Sound);
    let placement = place(&planned.session, &[planned.pairs[pair]], &drawn.capture, Feeds::Programmed).expect("placed");
    let (off, _) = planned.compared(&drawn, &placement);
    assert!(!placement.by_marks && off < REACH_DEG.max(3.0 * placement.position_sigma), "{off}");
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn what_controls_and_operators_do_beside_the_program_misplaces_nothing() {
    let planned = &*SLOW;
    let names = |pair: usize| planned.session.tests[planned.pairs[pair].tests[0]].name.as_str();
    for (k, habit) in HABITS.into_iter().enumerate() {
        let pair = k % planned.pairs.len();
        let seed = 40 + 10 * k as u64 + pair as u64;
        let mut erring = Erring::drawn(&planned.session.machine, seed);
        let drawn = planned.drawn_by(&mut erring, pair, seed, Kind::Sound, habit);
        let placement = match place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed) {
            Ok(placement) => placement,
            // without the gap that tells tests apart, tests that read alike are not guessed
            Err(ImportError::TwoTests { .. }) if habit == Habit::Waits => continue,
            Err(why) => panic!("{}: {why}", drawn.says),
        };
        assert_eq!(placement.pair, planned.pairs[pair], "{}: as {}", drawn.says, names(pair));
        let (off, _) = planned.compared(&drawn, &placement);
        println!("{}: off {off:.4} sigma {:.4}", drawn.says, placement.position_sigma);
        // how much longer a rest before a run is than one after it shows in nothing but the readings of the run
        let hidden_deg = if habit == Habit::UnevenRests { 0.02 * placement.course.rate() } else { 0.0 };
        let allowed = REACH_DEG.max(4.0 * placement.position_sigma) + hidden_deg;
        assert!(off < allowed, "{}: misplaced by {off}", drawn.says);
    }
}

#[test]
fn a_wait_of_tenths_of_a_second_makes_no_other_test_of_a_capture() {
    let planned = &*SLOW;
    let (mut right, mut all) = (0, 0);
    for (k, waits_s) in [0.14, 0.2, 0.27, 0.4, 0.55].into_iter().enumerate() {
        let pair = k % planned.pairs.len();
        let seed = 300 + 10 * k as u64 + pair as u64;
        let mut erring = Erring::drawn(&planned.session.machine, seed);
        let drawn = planned.drawn_by(&mut erring, pair, seed, Kind::Sound, Habit::WaitsFor(waits_s));
        all += 1;
        let placement = match place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed) {
            Ok(placement) => placement,
            Err(why) => {
                println!("{}: {why}", drawn.says);
                assert!(why.to_string().contains("--test"), "{}: {why}", drawn.says);
                // what it asks for settles it
                place(&planned.session, &[planned.pairs[pair]], &drawn.capture, Feeds::Programmed)
                    .unwrap_or_else(|why| panic!("{}: {why}", drawn.says))
            }
        };
        assert_eq!(placement.pair, planned.pairs[pair], "{}", drawn.says);
        let (off, _) = planned.compared(&drawn, &placement);
        println!("{}: off {off:.4} sigma {:.4} odds {:.1}", drawn.says, placement.position_sigma, placement.odds_tests);
        assert!(off < REACH_DEG.max(4.0 * placement.position_sigma), "{}: misplaced by {off}", drawn.says);
        right += usize::from(placement.odds_tests > 3.0);
    }
    assert!(2 * right > all, "{right} of {all}");
}

#[test]
fn servos_that_lag_are_placed_where_the_machine_was() {
    let planned = &*SLOW;
    for (k, lag_s) in [0.015, 0.03, 0.05].into_iter().enumerate() {
        let pair = k % planned.pairs.len();
        let seed = 400 + 10 * k as u64 + pair as u64;
        let mut erring = Erring::drawn(&planned.session.machine, seed);
        let drawn = planned.drawn_by(&mut erring, pair, seed, Kind::Sound, Habit::Lags(lag_s));
        let placement = place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed)
            .unwrap_or_else(|why| panic!("{}: {why}", drawn.says));
        assert_eq!(placement.pair, planned.pairs[pair], "{}", drawn.says);
        let (off, _) = planned.compared(&drawn, &placement);
        let found_s = placement.timing.lag_s;
        println!("{}: off {off:.4} sigma {:.4} lag {found_s:.3}", drawn.says, placement.position_sigma);
        assert!(off < REACH_DEG.max(4.0 * placement.position_sigma), "{}: misplaced by {off}", drawn.says);
    }
}

/// A plan whose tests differ from those that ran.
fn edited(planned: &Planned, edit: impl Fn(&mut fiveaxis::session::Test)) -> fiveaxis::session::Session {
    let mut session = planned.session.clone();
    session.tests.iter_mut().for_each(edit);
    session
}

#[test]
fn a_wait_shorter_than_every_program_s_is_refused() {
    let planned = &*MARKED;
    for (pair, longer_s) in [(0, 0.3), (1, 1.0)] {
        let seed = 500 + pair as u64;
        let drawn = planned.drawn(&mut Erring::drawn(&planned.session.machine, seed), pair, seed, Kind::Sound);
        // all programs of the session wait longer than this one did
        let longest_s = planned.session.tests.iter().filter_map(|test| test.marks).fold(0.0, |s, own| own.gap_s.max(s));
        let session = edited(planned, |test| {
            test.marks = test.marks.map(|own| fiveaxis::session::Marks { gap_s: longest_s + longer_s, ..own });
        });
        let why = place(&session, &planned.pairs, &drawn.capture, Feeds::Programmed).expect_err(&drawn.says);
        println!("{}: {why}", drawn.says);
        assert!(matches!(why, ImportError::WaitsLess { .. }), "{}: {why}", drawn.says);
        place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed).expect(&drawn.says);
    }
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn what_ends_where_the_search_ends_is_not_placed() {
    let planned = &*SLOW;
    let mut at_bound = 0;
    for (pair, slower) in (0..planned.pairs.len()).zip([1.13, 1.14].into_iter().cycle()) {
        let seed = 600 + pair as u64;
        let mut erring = Erring::drawn(&planned.session.machine, seed);
        let drawn = planned.drawn_by(&mut erring, pair, seed, Kind::Sound, Habit::Plain);
        // the runs of this program are slower than the session says, and its marks are not
        let session = edited(planned, |test| test.feed_mm_per_min = test.feed_mm_per_min.map(|feed| slower * feed));
        match place(&session, &[planned.pairs[pair]], &drawn.capture, Feeds::Programmed) {
            Ok(found) => {
                let timing = found.timing;
                println!("{}: paces {:?} ramp {:.2} s", drawn.says, timing.paces, timing.ramp_s);
                assert!(timing.paces.iter().all(|pace| *pace > 0.901) && timing.ramp_s < 1.11, "{timing:?}");
            }
            Err(why) => {
                println!("{}: {why}", drawn.says);
                at_bound += usize::from(matches!(why, ImportError::AtBound { .. } | ImportError::OtherFeed { .. }));
            }
        }
    }
    assert!(at_bound > 0);
}

/// A capture with rows before it and behind it, so many s of each reading.
fn framed(drawn: &mut Drawn, before: &[(f64, f64)], behind: &[(f64, f64)]) {
    let step_s = drawn.capture.time_s[1] - drawn.capture.time_s[0];
    let rows = |parts: &[(f64, f64)]| -> Vec<f64> {
        parts.iter().flat_map(|(seconds, mm)| vec![*mm; (seconds / step_s) as usize]).collect()
    };
    let (before, behind) = (rows(before), rows(behind));
    let first_s = drawn.capture.time_s[0];
    let place = |row: usize| drawn.positions[row].clone();
    let (first, last) = (place(0), place(drawn.positions.len() - 1));
    drawn.positions.splice(0..0, vec![first; before.len()]);
    drawn.positions.extend(vec![last; behind.len()]);
    let all = before.len() + drawn.capture.time_s.len() + behind.len();
    drawn.capture.time_s = (0..all).map(|row| first_s + (row as f64 - before.len() as f64) * step_s).collect();
    drawn.capture.reading_mm.splice(0..0, before);
    drawn.capture.reading_mm.extend(behind);
}

/// Readings before the marks and behind them: each so many s of so many mm.
type Outside = (Vec<(f64, f64)>, Vec<(f64, f64)>);

#[test]
fn what_lies_outside_of_the_marks_is_cut_off() {
    // lengthened by hand, as a mark does
    are_cut_off(vec![(vec![(1.0, 0.0), (1.5, 0.5), (1.0, 0.0)], vec![])]);
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn a_bar_that_was_off_outside_of_the_marks_is_cut_off() {
    are_cut_off(vec![
        (vec![(6.0, 1.0), (2.0, 0.4)], vec![]),
        (vec![], vec![(20.0, 1.0)]),
        (vec![(5.0, -0.9)], vec![(40.0, 0.999)]),
    ]);
}

fn are_cut_off(outside: Vec<Outside>) {
    let planned = &*SLOW;
    for (case, (before, behind)) in outside.into_iter().enumerate() {
        let (pair, seed) = (case % planned.pairs.len(), 700 + case as u64);
        let mut erring = Erring::drawn(&planned.session.machine, seed);
        let mut drawn = planned.drawn(&mut erring, pair, seed, Kind::Sound);
        let whole = place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed).expect(&drawn.says);
        assert_eq!(whole.cut_s, [0.0; 2], "{}", drawn.says);
        framed(&mut drawn, &before, &behind);
        let placement = place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed)
            .unwrap_or_else(|why| panic!("{}: {why}", drawn.says));
        assert_eq!(placement.pair, planned.pairs[pair], "{}", drawn.says);
        let (off, _) = planned.compared(&drawn, &placement);
        println!("{}: off {off:.4} sigma {:.4} cut {:?}", drawn.says, placement.position_sigma, placement.cut_s);
        assert!(off < REACH_DEG.max(4.0 * placement.position_sigma), "{}: misplaced by {off}", drawn.says);
        for (cut_s, parts) in placement.cut_s.iter().zip([&before, &behind]) {
            let moved_s: f64 = parts.iter().filter(|(_, mm)| mm.abs() > 0.1).map(|(seconds, _)| seconds).sum();
            assert!(*cut_s > moved_s - 0.2, "{}: {cut_s} s of {parts:?}", drawn.says);
        }
        // nothing is cut between the marks: looked at once
        if case == 0 {
            let rows = (2.0 / (drawn.capture.time_s[1] - drawn.capture.time_s[0])) as usize;
            let mut touched = drawn.capture.clone();
            let from = touched.time_s.partition_point(|time| *time < placement.timing.start_s[0] + 5.0);
            touched.reading_mm[from..from + rows].fill(1.2);
            let found = place(&planned.session, &planned.pairs, &touched, Feeds::Programmed);
            assert!(found.is_err(), "{}: touched", drawn.says);
        }
    }
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn halves_of_two_machines_are_told() {
    let planned = &*SLOW;
    let pair = planned.pairs.iter().position(|pair| planned.session.tests[pair.tests[0]].name.starts_with("xy"));
    let pair = pair.expect("a circle");
    let drawn = |erring: u64| {
        let mut erring = Erring::drawn(&planned.session.machine, erring);
        planned.drawn(&mut erring, pair, 801, Kind::Sound)
    };
    let one = drawn(801);
    let placed =
        |capture: &fiveaxis::import::Capture| place(&planned.session, &planned.pairs, capture, Feeds::Programmed);
    let sound = placed(&one.capture).expect(&one.says);
    assert_eq!(sound.runs_apart_mm, None);
    let from = one.capture.time_s.partition_point(|time| *time < sound.marks_s[1][1] + 0.3);
    let run_s = [sound.timing.start_s[1], sound.timing.start_s[1] + sound.timing.moving_s(1, sound.course.run_s)];
    // the second run of other machines, and of one whose ball stands elsewhere
    let of_others = (802..805).map(|seed| drawn(seed).capture.reading_mm[from..].to_vec());
    let elsewhere = one.capture.time_s.iter().zip(&one.capture.reading_mm).skip(from).map(|(time, reading)| {
        let share = ((time - run_s[0]) / (run_s[1] - run_s[0])).clamp(0.0, 1.0);
        reading + 0.06 * (std::f64::consts::TAU * share).sin()
    });
    let mut told = 0;
    for half in of_others.chain([elsewhere.collect()]) {
        let mut spliced = one.capture.clone();
        spliced.reading_mm[from..].copy_from_slice(&half);
        match placed(&spliced) {
            Ok(found) => {
                println!("{}: left {:.4} mm, apart {:?} mm", one.says, found.left_mm, found.runs_apart_mm);
                told += usize::from(found.runs_apart_mm.is_some_and(|[together, each]| together > 4.0 * each));
            }
            Err(why) => println!("{}: {why}", one.says),
        }
    }
    assert!(told > 0);
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn an_override_is_placed_where_it_is_asked_for() {
    let planned = &*MARKED;
    let pair = planned.pairs.iter().position(|pair| planned.session.tests[pair.tests[0]].name.starts_with("xy"));
    let pair = pair.expect("a circle");
    for (seed, part) in [(3, 0.5), (6, 1.6)] {
        let mut erring = Erring::drawn(&planned.session.machine, seed);
        let drawn = planned.drawn_by(&mut erring, pair, seed, Kind::Sound, Habit::Override(part));
        let why = refusal(planned, &planned.pairs, &drawn).to_string();
        println!("{}: {why}", drawn.says);
        assert!(why.contains("--any-feed"), "{part}: {why}");
        let placement = place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Any)
            .unwrap_or_else(|why| panic!("{}: {why}", drawn.says));
        assert_eq!(placement.pair, planned.pairs[pair], "{}", drawn.says);
        let (off, _) = planned.compared(&drawn, &placement);
        println!("off {off:.4} sigma {:.4}", placement.position_sigma);
        assert!(off < REACH_DEG.max(4.0 * placement.position_sigma), "{part}: misplaced by {off}");
    }
}

#[test]
fn readings_of_another_sense_unit_or_clock_are_named() {
    let planned = &*MARKED;
    let cases = [
        (-1.0, 1.0, "the readings have the other sense"),
        (1.0 / 25.4, 1.0, "the readings are in inches"),
        (0.1, 1.0, "ten times too small"),
        (10.0, 1.0, "ten times too large"),
        (1e-3, 1.0, "a thousand times too small, millimetres taken as µm"),
        (1e3, 1.0, "a thousand times too large, µm taken as millimetres"),
        (1.0, 1e3, "the times are milliseconds"),
        (1.0, 1e-3, "the times are seconds"),
    ];
    for (k, (by, time_by, due)) in cases.into_iter().enumerate() {
        let (pair, seed) = (k % planned.pairs.len(), 60 + k as u64);
        let mut drawn = planned.drawn(&mut Erring::drawn(&planned.session.machine, seed), pair, seed, Kind::Sound);
        if k == 0 {
            place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed).expect("placed as it is");
        }
        drawn.capture.reading_mm.iter_mut().for_each(|reading| *reading *= by);
        drawn.capture.time_s.iter_mut().for_each(|time| *time *= time_by);
        let why = refusal(planned, &planned.pairs, &drawn);
        println!("{}: {why}", drawn.says);
        assert!(matches!(why, ImportError::OtherReading { .. }), "{by} {time_by}: {why}");
        assert!(why.to_string().contains(due), "{by} {time_by}: {why}");
    }
}

/// A session of one pair of tests whose recordings without positions are these columns.
fn written(planned: &Planned, pair: Pair, halves: &[String; 2], folder: &Path) -> std::path::PathBuf {
    let mut session = planned.session.clone();
    session.tests = pair.tests.map(|test| planned.session.tests[test].clone()).to_vec();
    for (test, text) in session.tests.iter_mut().zip(halves) {
        let name = format!("{}.csv", test.name);
        std::fs::write(folder.join(&name), text).unwrap();
        test.recording_file = Some(name);
    }
    session.machine_file = "machine.yaml".into();
    std::fs::write(folder.join("machine.yaml"), fiveaxis::report::machine_yaml(&session.machine)).unwrap();
    let file = folder.join("session.yaml");
    std::fs::write(&file, fiveaxis::report::session_yaml(&session)).unwrap();
    file
}

#[test]
fn a_capture_cut_by_hand_is_no_recording_of_an_arc() {
    let planned = &*MARKED;
    let (mut by_duration, mut by_marks) = (0, 0);
    for (k, &pair) in planned.pairs.iter().enumerate() {
        let seed = 80 + k as u64;
        let drawn = planned.drawn(&mut Erring::drawn(&planned.session.machine, seed), k, seed, Kind::Sound);
        let capture = &drawn.capture;
        let placement = place(&planned.session, &[pair], capture, Feeds::Programmed).expect("placed");
        let (timing, run_s) = (&placement.timing, placement.course.run_s);
        let run = [0, 1].map(|way| [timing.start_s[way], timing.start_s[way] + timing.moving_s(way, run_s)]);
        let marks = planned.session.tests[pair.tests[0]].marks.expect("marked");
        let mark_s = marks.rest_s + 2.0 * marks.move_s() + marks.hold_s + 0.4;
        let arcs = recordings(&placement, capture, 0.0, LengthColumn::DeviationMm);
        // from the start to the middle of the pause and on; a mark beside each run; the arcs alone
        let middle = 0.5 * (run[0][1] + run[1][0]);
        let all = [[f64::MIN, middle], [middle, f64::MAX]];
        let near = run.map(|[begin, end]| [begin - mark_s, end]);
        let arc = [0, 1].map(|way: usize| {
            let time = arcs[way].0.time_s().expect("times");
            [arcs[way].1 + time[0] - 1e-6, arcs[way].1 + time[time.len() - 1] + 1e-6]
        });
        for (windows, is_arc) in [(all, false), (near, false), (arc, true)] {
            for with_times in [true, false] {
                let folder = tempfile::tempdir().unwrap();
                let halves = windows.map(|[from, to]| {
                    let rows = capture.time_s.iter().zip(&capture.reading_mm);
                    let rows = rows.filter(|(time, reading)| (from..=to).contains(*time) && reading.is_finite());
                    let head = if with_times { "time_s,deviation_mm\n" } else { "deviation_mm\n" };
                    rows.fold(head.to_string(), |text, (time, reading)| match with_times {
                        true => text + &format!("{time:.6},{reading:.6}\n"),
                        false => text + &format!("{reading:.6}\n"),
                    })
                });
                let session = written(planned, pair, &halves, folder.path());
                let loaded = fiveaxis::load::load_session(&session);
                if is_arc {
                    assert!(loaded.is_ok(), "{}: {}", drawn.says, loaded.unwrap_err());
                    continue;
                }
                let why = loaded.expect_err(&drawn.says).to_string();
                assert!(why.contains("fiveaxis import"), "{why}");
                by_duration += usize::from(why.contains("at the test's feed"));
                by_marks += usize::from(why.contains("the readings show a mark"));
                println!("{}: {why}", drawn.says);
                let mut command = Command::new(env!("CARGO_BIN_EXE_fiveaxis"));
                let output = command.arg("identify").arg(&session).output().unwrap();
                assert_eq!(output.status.code(), Some(2), "{}", String::from_utf8_lossy(&output.stderr));
            }
        }
    }
    assert!(by_duration > 0 && by_marks > 0, "{by_duration} {by_marks}");
}

/// A turning axis that lifts off where it stood, as brakes and oil films let it: readings are off there by some size, and no longer
/// once the axis has turned this far, deg.
fn lifted(drawn: &mut Drawn, axis: usize, sizes_mm: [f64; 4]) {
    const WAY_DEG: f64 = 4.0;
    let rows = drawn.positions.len();
    let ends = [drawn.positions[0][axis], drawn.positions[rows / 2][axis]];
    for (row, (reading, q)) in drawn.capture.reading_mm.iter_mut().zip(&drawn.positions).enumerate() {
        for (end, from) in ends.iter().enumerate() {
            let way_deg = (q[axis] - from).abs().to_degrees();
            *reading += sizes_mm[2 * usize::from(2 * row > rows) + end] * (1.0 - way_deg / WAY_DEG).max(0.0);
        }
    }
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn nearly_flat_sweeps_keep_the_pace_of_their_marks() {
    let mut good = 0;
    let count = count(8);
    for seed in 0..count {
        let planned: &Planned = if seed % 2 == 0 { &MARKED } else { &SLOW };
        let machine = &planned.session.machine;
        // sweeps in which one rotary axis moves alone
        let alone: Vec<(usize, usize)> = (planned.pairs.iter().enumerate())
            .filter_map(|(k, pair)| match &planned.session.tests[pair.tests[0]].path {
                Some(TestPath::Sweep { axis, follow: Follow::None, .. }) => Some((k, *axis)),
                _ => None,
            })
            .collect();
        let (pair, axis) = alone[seed as usize / 2 % alone.len()];
        let mut erring = Erring::by_part(machine, seed, 0.1);
        let mut drawn = planned.drawn_by(&mut erring, pair, seed, Kind::Sound, Habit::Exact);
        // at 500 mm/min a lift is a small part of a run
        if seed % 4 == 1 {
            lifted(&mut drawn, axis, [7.3, 3.1, 5.7, 9.9].map(|k| 1.4e-3 * (k * seed as f64).sin()));
        }
        let placement = match place(&planned.session, &planned.pairs, &drawn.capture, Feeds::Programmed) {
            Ok(placement) => placement,
            Err(why) => {
                println!("{seed}: {}: {why}", drawn.says);
                continue;
            }
        };
        assert_eq!(placement.pair, planned.pairs[pair], "{seed}: {}", drawn.says);
        let (off, _) = planned.compared(&drawn, &placement);
        let (pace_off, pace_sigma) = ((placement.timing.pace() - 1.0).abs(), placement.sigma[2]);
        println!("{seed}: {}: off {off:.4} sigma {:.4}", drawn.says, placement.position_sigma);
        println!("    pace off {pace_off:.5} sigma {pace_sigma:.5} ramp {:.3}", placement.timing.ramp_s);
        assert!(pace_off < 3.0 * pace_sigma, "{seed}: {}: pace off by {pace_off} ± {pace_sigma}", drawn.says);
        good += u64::from(off < REACH_DEG.max(3.0 * placement.position_sigma));
    }
    assert!(100 * good >= 99 * count, "{good} of {count}");
}

fn import(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fiveaxis")).arg("import").args(arguments).output().unwrap()
}

/// Imports a file among the shipped tests, into a folder within this one.
fn import_among_shipped(file: &Path, folder: &Path) -> Output {
    let (session, out) = (format!("{SHIPPED}/session.yaml"), folder.join("out"));
    import(&[file.to_str().unwrap(), "--session", &session, "--out", out.to_str().unwrap()])
}

#[test]
fn the_example_of_the_help_runs() {
    let help = String::from_utf8(import(&["--help"]).stdout).unwrap();
    // the last paragraph, on as many lines as a terminal makes of it
    let (_, command) = help.split_once("Example: fiveaxis ").expect("an example");
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join(SHIPPED);
    std::fs::create_dir_all(&copy).unwrap();
    for file in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(SHIPPED)).unwrap() {
        let file = file.unwrap().path();
        if file.is_file() {
            std::fs::copy(&file, copy.join(file.file_name().unwrap())).unwrap();
        }
    }
    let mut example = Command::new(env!("CARGO_BIN_EXE_fiveaxis"));
    let output = example.args(command.split_whitespace()).current_dir(folder.path()).output().unwrap();
    assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.path().join("imported/session.yaml").is_file(), "{command}");
}

/// The shipped captures: LinuxCNC's planner moved the axes.
const SHIPPED: &str = "examples/captures";

#[test]
fn a_shipped_capture_becomes_recordings_of_its_tests() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("imported");
    let session = format!("{SHIPPED}/session.yaml");
    let captures = [format!("{SHIPPED}/xy-100-1.csv")];
    let output = import(&[
        &captures[0],
        "--session",
        &session,
        "--test",
        "xy-100-1-ccw",
        "--out",
        out.to_str().unwrap(),
        "--json",
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let placed = &json["captures"][0];
    assert_eq!(placed["tests"][0], "xy-100-1-ccw");
    assert!(placed["position_sigma"].as_f64().unwrap() < 0.1 && placed["by_marks"] == true, "{placed}");
    assert!(json["warnings"].is_array() && !json["missing"].as_array().unwrap().is_empty());
    for file in ["session.yaml", "machine.yaml", "xy-100-1-ccw.csv", "xy-100-1-cw.csv", "xy-100-1-ccw.svg"] {
        assert!(out.join(file).is_file(), "{file}");
    }
    // the lines break where marks are left out; numbers on the axes are round
    let picture = std::fs::read_to_string(out.join("xy-100-1-ccw.svg")).unwrap();
    assert!(picture.contains("marks left out in grey bands") && picture.matches("<polyline").count() > 2, "{picture}");
    let levels: Vec<&str> = picture.split("text-anchor=\"end\">").skip(1).filter_map(|t| t.split('<').next()).collect();
    assert!(
        levels.len() >= 3 && levels.iter().all(|level| level.replace('−', "").parse::<i32>().is_ok()),
        "{levels:?}"
    );
    let imported = fiveaxis::load::load_session(&out.join("session.yaml")).unwrap();
    assert_eq!(imported.tests.len(), 2);
    // positions against those that the planner commanded, every tenth of a second on the gauge's clock
    let truth = std::fs::read_to_string(format!("{SHIPPED}/truth/xy-100-1-positions.csv")).unwrap();
    let truth: Vec<[f64; 3]> = truth
        .lines()
        .skip(1)
        .map(|line| {
            let values: Vec<f64> = line.split(',').map(|value| value.parse().unwrap()).collect();
            [values[0], values[1], values[2]]
        })
        .collect();
    let test = &imported.tests[0];
    let recording = test.recording.as_ref().unwrap();
    let begins_s = placed["arcs_s"][0][0].as_f64().unwrap();
    let column = |name: &str| {
        let axis = imported.machine.axis_index(name).unwrap();
        &recording.positions[recording.axes.iter().position(|&k| k == axis).unwrap()]
    };
    let (x, y, time) = (column("X"), column("Y"), recording.time_s().unwrap());
    let (mut worst, mut seen): (f64, usize) = (0.0, 0);
    for [at, true_x, true_y] in &truth {
        let Some(row) = time.windows(2).position(|pair| pair[0] <= at - begins_s && at - begins_s < pair[1]) else {
            continue;
        };
        let part = (at - begins_s - time[row]) / (time[row + 1] - time[row]);
        let found = [x, y].map(|q| q[row] + part * (q[row + 1] - q[row]));
        worst = worst.max((found[0] - true_x).hypot(found[1] - true_y));
        seen += 1;
    }
    let limit_mm = 100.0 * (4.0 * placed["position_sigma"].as_f64().unwrap()).to_radians();
    assert!(seen > 50 && worst < limit_mm, "{seen} rows, {worst} mm of {limit_mm}");
}

#[test]
fn shipped_captures_are_placed_and_tell_the_errors_that_made_them() {
    let folder = tempfile::tempdir().unwrap();
    let (session, out) = (format!("{SHIPPED}/session.yaml"), folder.path().join("imported"));
    let names = ["c-axial-100-1", "yz-100-1", "xy-100-1", "zx-100-1", "a-100-1", "a-100-2"];
    let placed = |captures: &[String]| {
        let mut arguments: Vec<&str> = captures.iter().map(String::as_str).collect();
        arguments.extend(["--session", &session, "--out", out.to_str().unwrap(), "--force", "--json"]);
        let output = import(&arguments);
        assert!(output.status.success(), "{captures:?}: {}", String::from_utf8_lossy(&output.stdout));
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        for (capture, placed) in captures.iter().zip(json["captures"].as_array().unwrap()) {
            let name = Path::new(capture).file_stem().unwrap().to_str().unwrap();
            assert_eq!(
                (&placed["tests"][0], &placed["by_marks"]),
                (&Value::from(format!("{name}-ccw")), &Value::from(true))
            );
        }
        json
    };
    for again in ["a-100-1", "xy-100-1", "yz-100-1", "zx-100-1"] {
        placed(&[format!("{SHIPPED}/again/{again}.csv")]);
    }
    let json = placed(&names.map(|name| format!("{SHIPPED}/{name}.csv")));
    assert_eq!(json["times"], "captures");
    let imported = fiveaxis::load::load_session(&out.join("session.yaml")).unwrap();
    let fit = fiveaxis::identify::identify(&imported, &Default::default()).unwrap();
    // the marks of the programs show which way the axes go
    for test in &imported.tests {
        let marks = test.marks.unwrap();
        let seen_mm = marks.seen_mm.unwrap();
        assert!(seen_mm.iter().all(|seen| (seen - marks.move_mm).abs() < 0.01), "{}: {seen_mm:?}", test.name);
    }
    let senses = fiveaxis::identify::turned_senses(&imported, &fit).unwrap();
    // each alone; a mirror image of the machine, C and X turned together, fits as well
    for sense in senses.iter().filter(|sense| sense.axes.len() == 1) {
        let name = sense.named(&imported.machine);
        assert!(sense.is_told() && !sense.looks_wrong(), "{name}: {sense:?}");
    }
    let machine = format!("{SHIPPED}/truth/machine.yaml");
    let truth = fiveaxis::load::load_machine(Path::new(&machine)).unwrap();
    let axis = |name: &str| &truth.axes[truth.axis_index(name).unwrap()].location_errors;
    for (name, due) in [
        ("EY0A", axis("A")[1]),
        ("EZ0A", axis("A")[2]),
        ("EB0A", axis("A")[4]),
        ("EC0A", axis("A")[5]),
        ("EX0C", axis("C")[0]),
        ("EY0C", axis("C")[1]),
        ("EA0C", axis("C")[3]),
        ("EB0C", axis("C")[4]),
    ] {
        let found = fit.error(name).unwrap();
        assert!(due != 0.0 && found.determined, "{name}");
        assert!((found.value - due).abs() < 3.0 * found.sigma, "{name}: {} ± {}, {due}", found.value, found.sigma);
    }
}

#[test]
fn files_of_gauges_are_read_and_others_refused() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, text: &str, hints: CaptureHints| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        let why = |why: fiveaxis::load::LoadError| why.to_string().rsplit('/').next().unwrap_or_default().to_string();
        load_capture(&file, hints).map_err(why)
    };
    let rows: String = (0..40).map(|k| format!("{},{}\n", 0.1 * f64::from(k), 1.5 * f64::from(k))).collect();
    let due: Vec<f64> = (0..40).map(|k| 1.5e-3 * f64::from(k)).collect();
    let same = |found: &[f64]| found.iter().zip(&due).all(|(a, b)| (a - b).abs() < 1e-12) && found.len() == due.len();
    let none = CaptureHints::default();
    let table = read("a.csv", &format!("Recorder, readings of today\n\nt [s],Deviation [µm]\n{rows}"), none).unwrap();
    assert!(same(&table.reading_mm) && (table.time_s[39] - 3.9).abs() < 1e-12);
    let german = rows.replace(',', ";").replace('.', ",");
    let table =
        read("b.csv", &format!("Zeit ms;Temperatur;Abweichung mm\n{}", german.replace(';', ";20;")), none).unwrap();
    assert_eq!((table.column, table.not_read), (LengthColumn::DeviationMm, vec!["Temperatur".to_string()]));
    assert!((table.time_s[10] - 1e-3).abs() < 1e-12);
    // commas in numbers and commas between fields, as spreadsheets quote them
    let quoted: String = german
        .lines()
        .map(|row| row.split(';').map(|field| format!("\"{field}\"")).collect::<Vec<_>>().join(",") + "\n")
        .collect();
    let table = read("q.csv", &format!("\"time_s\",\"deviation_um\"\n{quoted}"), none).unwrap();
    assert!(same(&table.reading_mm) && (table.time_s[39] - 3.9).abs() < 1e-12);
    let values: String = (0..40).map(|k| format!("{} ", 1.5 * f64::from(k))).collect();
    let xml = format!(
        "<?xml version=\"1.0\"?><Test><Operator>A B</Operator><SampleRate>10</SampleRate><Units>um</Units><Readings>{values}</Readings></Test>"
    );
    let found = read("c.b5r", &xml, none).unwrap();
    assert!(same(&found.reading_mm) && (found.time_s[39] - 3.9).abs() < 1e-12);
    assert_eq!(found.not_read, ["Operator"]);
    let single: String = (0..40).map(|k| format!("<Reading><Value>{}</Value></Reading>", 1.5 * f64::from(k))).collect();
    let hints = CaptureHints { rate_hz: Some(10.0), column: Some(LengthColumn::DeviationUm) };
    assert!(same(&read("d.xml", &format!("<Test>{single}</Test>"), hints).unwrap().reading_mm));
    let stated = read("e.txt", &format!("Sample rate: 250 Hz\ndeviation_um\n{}", "1.0\n".repeat(40)), none).unwrap();
    assert!((stated.time_s[1] - 0.004).abs() < 1e-12);
    // readings in attributes, units in a row of their own, lost readings, comments, a separator at the end of rows
    let samples: String =
        (0..40).map(|k| format!("<s t='{}' dev_um=\"{}\"/>", 0.1 * f64::from(k), 1.5 * f64::from(k))).collect();
    let found =
        read("h.xml", &format!("<Test version=\"2\">{samples}</Test>"), CaptureHints { column: hints.column, ..none });
    let found = found.unwrap();
    assert!(same(&found.reading_mm) && (found.time_s[39] - 3.9).abs() < 1e-12);
    let lost = "Zeit;Abweichung\ns;µm\n0;-;\n# pause\n0,1;nan;\n0,2;1,5;\n";
    let found = read("i.csv", lost, none).unwrap();
    assert_eq!(found.column, LengthColumn::DeviationUm);
    assert!(found.reading_mm[0].is_nan() && found.reading_mm[1].is_nan() && found.reading_mm[2] == 1.5e-3);
    let clock = "time;deviation_um\n2026-11-24T10:00:59.5;1\n2026-11-24T10:01:00.25;2\n";
    assert!((read("j.csv", clock, none).unwrap().time_s[1] - 0.75).abs() < 1e-9);
    // a clock of ten counts a second, a pause after the second count
    let coarse = "time_s,deviation_um\n0,1\n0,2\n0.1,3\n0.1,4\n0.5,5\n0.6,6\n";
    let due_s = [0.0, 0.05, 0.1, 0.15, 0.5, 0.6];
    assert!(read("k.csv", coarse, none).unwrap().time_s.iter().zip(due_s).all(|(a, b)| (a - b).abs() < 1e-12));
    for (text, says) in [
        (
            "only words\n",
            "f.csv: has no header that names readings; a capture has columns such as time_s and deviation_um, with numbers below",
        ),
        (
            "time_s,deviation\n0,1\n",
            "f.csv: the readings 'deviation' have no unit; name the column deviation_um, deviation_mm or length_mm, or say --unit",
        ),
        (
            "time_s,Deviation [in]\n0,1\n",
            "f.csv: the readings 'Deviation [in]' have the unit 'in', which is not read; convert them to um or mm, and say --unit",
        ),
        (
            "deviation_um\n1\n2\n",
            "f.csv: has neither times nor a sampling rate; add a column time_s or say --rate with the readings a second",
        ),
        ("time_s,deviation_um\n1,1\n0,2\n", "f.csv:3: times go from 1 to 0 s; times rise from row to row"),
        (
            "time_s,deviation_um\n0,1\n0,2\n",
            "f.csv: all rows have the same time; the clock stood, or the column is another",
        ),
        ("time_s,deviation_um\n0,1\n1,x\n", "f.csv:3: column deviation_um: 'x' is not a number; correct it"),
        (
            "time_s,deviation_um\n0,1\nlate,2\n",
            "f.csv:3: column time_s: 'late' is neither a number nor a time of day; correct it",
        ),
        (
            "time_s,deviation_um\n0,1\n1\n",
            "f.csv:3: has 1 fields where the header (line 1) has 2; the file may be cut off",
        ),
    ] {
        assert_eq!(read("f.csv", text, none).unwrap_err(), says);
    }
    let xml = read("g.b5r", "<Test><A>1 2 3</A></Test>", none).unwrap_err();
    assert!(xml.starts_with("g.b5r: is XML without a list of at least 30 readings (numbers found in: A)"), "{xml}");
}

#[test]
fn names_and_numbers_of_many_gauges_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let read = |text: &str| {
        let file = folder.path().join("a.csv");
        std::fs::write(&file, text).unwrap();
        let why = |why: fiveaxis::load::LoadError| why.to_string().rsplit('/').next().unwrap_or_default().to_string();
        load_capture(&file, CaptureHints::default()).map_err(why)
    };
    // a step of 20 ms, and readings of -1 and 2 µm
    for text in [
        "DateTime,Deviation [um]\n2026-11-26T10:00:00.00,-1\n2026-11-26T10:00:00.02,2\n",
        "Timestamp;Deviation [um]\n10:00:00.00;-1\n10:00:00.02;2\n",
        "Datum;Uhrzeit;Abweichung [µm]\n26.11.2026;10:00:00,00;-1,0\n26.11.2026;10:00:00,02;2,0\n",
        "Sample interval: 20 ms\ndeviation_um\n-1\n2\n",
        "Interval: 0,02 s\nsample,Deviation (mm)\n0,-0.001\n1,0.002\n",
        "Sample rate: 0.05 kHz\ndeviation_um\n-1\n2\n",
        "Channel 2, rate 50 Hz\ndeviation_um\n-1\n2\n",
        "Time[s],Length deviation[micron]\n0,-1\n0.02,2\n",
        "t/s;ΔL/µm\n0;-1\n0.02;2\n",
        "Zeit/s;Messwert/µm\n0;-1\n0.02;2\n",
        "Temps (s);Écart (µm)\n0;-1\n0,02;2\n",
        "Elapsed [us],Displacement [µm]\n0,-1\n20000,2\n",
        "Elapsed time (s);error code;Error (µm)\n0;7;-1\n0.02;7;2\n",
        "time_s;deviation_um\n0;\u{2212}1\n0.02;2\n",
    ] {
        let found = read(text).unwrap_or_else(|why| panic!("{text}: {why}"));
        assert!((found.time_s[1] - 0.02).abs() < 1e-9, "{text}: {:?}", found.time_s);
        assert!(found.reading_mm.iter().zip([-1e-3, 2e-3]).all(|(a, b)| (a - b).abs() < 1e-12), "{text}: {found:?}");
    }
    let beyond = read("time_s,deviation_um\n0,1\n0.1,OVL\n0.2,overload\n").unwrap();
    assert!(beyond.reading_mm[1].is_nan() && beyond.reading_mm[2].is_nan());
    // a unit on the element around, and readings that are missing
    let rows: String =
        (0..40).map(|k| format!("<r t=\"{}\">{}</r>", 0.02 * f64::from(k), 1e-3 * f64::from(k))).collect();
    let found = read(&format!("<test><readings unit=\"mm\">{rows}</readings></test>")).unwrap();
    assert!(found.column == LengthColumn::DeviationMm && (found.time_s[1] - 0.02).abs() < 1e-9);
    let list: String = (0..40).map(|k| if k == 7 { "NaN ".into() } else { format!("{k} ") }).collect();
    let found = read(&format!("<test><Rate>50</Rate><Deviations unit=\"um\">{list}</Deviations></test>")).unwrap();
    assert!(found.reading_mm[7].is_nan() && (found.reading_mm[8] - 8e-3).abs() < 1e-12);
    let times = list.replace('7', "8");
    let why =
        read(&format!("<test><Time>{times}</Time><Deviations unit=\"um\">{list}</Deviations></test>")).unwrap_err();
    assert!(why.ends_with("Time: time 8 of 40 is no number; correct it"), "{why}");
    // what is not understood is named
    let why = read("Dauer;Weg [µm]\n0;1\n0.1;2\n").unwrap_err();
    assert!(why.contains("names readings (none of 'Dauer', 'Weg [µm]' is known for them); a capture has"), "{why}");
    let why = read("Dauer;deviation_um\n0;1\n0.1;2\n").unwrap_err();
    assert!(why.contains("sampling rate (not understood: column Dauer); add a column time_s"), "{why}");
}

#[test]
fn stamps_of_packets_are_evened_out() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.csv");
    let read = |step_s: f64, packets: u32| {
        let row = |k: u32| format!("{:.4},{}\n", 0.1 * f64::from(k / 10) + step_s * f64::from(k % 10), k % 7);
        let rows: String = (0..10 * packets).map(row).collect();
        std::fs::write(&file, format!("time_s,deviation_um\n{rows}")).unwrap();
        load_capture(&file, CaptureHints::default()).unwrap().time_s
    };
    // ten rows that came within a millisecond
    let even = read(1e-4, 40);
    assert!(even.iter().enumerate().all(|(row, time)| (time - 0.01 * row as f64).abs() < 1e-9), "{even:?}");
    // ten rows in half of each tenth of a second were read so, and few packets are none
    assert!((read(5e-3, 40)[1] - 5e-3).abs() < 1e-9);
    assert!((read(1e-4, 5)[1] - 1e-4).abs() < 1e-9);
}

#[test]
fn rows_lost_in_a_file_without_times_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = load_capture(Path::new(SHIPPED).join("xy-100-1.csv").as_path(), CaptureHints::default()).unwrap();
    assert!(shipped.has_times);
    let rate_hz = 1.0 / (shipped.time_s[1] - shipped.time_s[0]);
    let file = folder.path().join("rows.csv");
    // rows within the first run
    let without = |lost: std::ops::Range<usize>| {
        let kept = shipped.reading_mm.iter().enumerate().filter(|(row, _)| !lost.contains(row));
        let rows: String = kept.map(|(_, mm)| format!("{:.2}\n", 1e3 * mm)).collect();
        std::fs::write(&file, format!("Sample rate: {rate_hz} Hz\ndeviation_um\n{rows}")).unwrap();
        assert!(!load_capture(&file, CaptureHints::default()).unwrap().has_times);
        import_among_shipped(&file, folder.path())
    };
    let said = |output: &Output| String::from_utf8_lossy(&output.stderr).to_string();
    let whole = without(0..0);
    assert!(whole.status.success() && !said(&whole).contains("rows of one"), "{}", said(&whole));
    let some = without(1000..1003);
    assert!(some.status.success() && said(&some).contains("rows of one may be lost"), "{}", said(&some));
    let more = without(1000..1006);
    assert!(more.status.code() == Some(3) && said(&more).contains("rows of one of them are lost"), "{}", said(&more));
}

#[test]
fn lengths_of_another_bar_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = load_capture(Path::new(SHIPPED).join("xy-100-1.csv").as_path(), CaptureHints::default()).unwrap();
    let file = folder.path().join("lengths.csv");
    let import = |bar_mm: f64| {
        let rows = shipped.time_s.iter().zip(&shipped.reading_mm);
        let rows: String = rows.map(|(time, mm)| format!("{time},{:.5}\n", bar_mm + mm)).collect();
        std::fs::write(&file, format!("time_s,length_mm\n{rows}")).unwrap();
        import_among_shipped(&file, folder.path())
    };
    let other = import(150.0);
    let said = String::from_utf8_lossy(&other.stderr).to_string();
    assert!(
        other.status.code() == Some(3) && said.contains("lengths of about 150.0 mm, and the bar of xy-100-1"),
        "{said}"
    );
    let own = import(100.0);
    assert!(own.status.success(), "{}", String::from_utf8_lossy(&own.stderr));
}

#[test]
fn times_of_any_unit_are_read_and_far_off_ones_refused() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str, text: &str, hints: CaptureHints| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        load_capture(&file, hints).map_err(|why| why.to_string())
    };
    let none = CaptureHints::default();
    let hints = CaptureHints { column: Some(LengthColumn::DeviationUm), ..none };
    for unit in ["us", "µs", "usec"] {
        let found = read("a.csv", &format!("time_{unit},deviation_um\n0,1\n20000,2\n40000,3\n"), none).unwrap();
        assert!((found.time_s[2] - 0.04).abs() < 1e-12, "{unit}: {:?}", found.time_s);
    }
    let values: String = (0..40).map(|k| format!("{} ", 1.5 * f64::from(k))).collect();
    let times: String = (0..40).map(|k| format!("{} ", 20 * k)).collect();
    let xml = |unit: &str| format!("<Test><Time unit=\"{unit}\">{times}</Time><Deviation>{values}</Deviation></Test>");
    assert!((read("b.xml", &xml("ms"), hints).unwrap().time_s[1] - 0.02).abs() < 1e-12);
    let unknown = read("b.xml", &xml("parsec"), hints).unwrap_err();
    assert!(unknown.contains("unit 'parsec' is not known; allowed are s, ms or us"), "{unknown}");
    // one row a milliard seconds later, and a rate of one reading in a quarter of an hour
    let far = read("c.csv", "time_s,deviation_um\n0,1\n0.1,2\n1e9,3\n", none).unwrap_err();
    assert!(
        far.ends_with(
            "1000000000 seconds of a capture; at most 86400 are allowed, check the unit of its times, or its rate"
        ),
        "{far}"
    );
    let slow = format!("deviation_um\n{}", "1.0\n".repeat(200));
    assert!(read("d.csv", &slow, CaptureHints { rate_hz: Some(1e-3), ..none }).unwrap_err().contains("199000 seconds"));
    // a transfer that broke within the last number
    let cut = read("e.csv", "time_s,deviation_um\n0,1.25\n0.1,2.50\n0.2,3.7", none).unwrap_err();
    assert!(cut.contains("e.csv:4: the last line ends after '3.7'"), "{cut}");
    // sparse readings are searched where they are
    let shipped = load_capture(Path::new(SHIPPED).join("xy-100-1.csv").as_path(), none).unwrap();
    let rows = shipped.time_s.iter().zip(&shipped.reading_mm);
    let rows: String = rows.map(|(time, mm)| format!("{time},{:.1}\n", 1e3 * mm)).collect();
    let file = folder.path().join("xy-100-1.csv");
    std::fs::write(&file, format!("time_s,deviation_um\n{rows}80000,1.0\n")).unwrap();
    let output = import_among_shipped(&file, folder.path());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("another test of the session"), "{said}");
}

#[test]
fn xml_states_how_often_a_gauge_reads_by_words_and_units() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.b5r");
    let values: String = (0..40).map(|k| format!("<Reading>{}</Reading>", 1.5 * f64::from(k))).collect();
    let step_s = |head: &str| {
        std::fs::write(&file, format!("<B5R>{head}<Unit>um</Unit><Deviations>{values}</Deviations></B5R>")).unwrap();
        load_capture(&file, CaptureHints::default()).map(|read| read.time_s[1]).map_err(|why| why.to_string())
    };
    for (head, due_s) in [
        ("<SampleRate>50</SampleRate><Calibrated>100.0</Calibrated>", 0.02),
        ("<SampleRate>50</SampleRate><MachineFeedRate>1500</MachineFeedRate>", 0.02),
        ("<SampleRate>50</SampleRate><RunUpRate>10</RunUpRate>", 0.02),
        ("<Capture SampleRate=\"50\"><Feedrate>1000</Feedrate></Capture>", 0.02),
        ("<BaudRate>9600</BaudRate><Rate>25</Rate><SAMPLERATE>50</SAMPLERATE>", 0.02),
        ("<sampling_frequency unit=\"kHz\">0.05</sampling_frequency>", 0.02),
        ("<SampleRate units=\"Hz\">50</SampleRate><FeedRate units=\"mm/min\">1500</FeedRate>", 0.02),
        ("<SampleInterval unit=\"ms\">20</SampleInterval>", 0.02),
        ("<SamplePeriodMs>20</SamplePeriodMs>", 0.02),
        ("<Interval>0.02</Interval>", 0.02),
        ("<Calibration><SampleRate>10</SampleRate></Calibration><DataRate>50</DataRate>", 0.02),
        ("<X><Calibration><SampleRate>10</SampleRate></Calibration></X><RateOfSampling>50</RateOfSampling>", 0.02),
    ] {
        let found = step_s(head);
        assert!(found.as_ref().is_ok_and(|step_s| (step_s - due_s).abs() < 1e-9), "{head}: {found:?}");
    }
    let none = "has neither times nor a sampling rate; add an element SampleRate in Hz or say --rate with the readings a second";
    for head in ["<Feedrate>1500</Feedrate>", "<Calibrated>100.0</Calibrated>", "<BaudRate>9600</BaudRate>"] {
        assert!(step_s(head).is_err_and(|why| why.ends_with(none)), "{head}");
    }
    let other = step_s("<SampleInterval unit=\"parsec\">20</SampleInterval>").unwrap_err();
    assert!(
        other
            .ends_with("SampleInterval: unit 'parsec' is not known; allowed are s, ms or us; correct it or say --rate"),
        "{other}"
    );
    // a second list is told, for it may be the second direction
    let list: String = (0..40).map(|k| format!("{} ", 1.5 * f64::from(k))).collect();
    let both = format!("<B5R><Rate>50</Rate><Unit>um</Unit><CW>{list}</CW><CCW>{list} 1</CCW></B5R>");
    std::fs::write(&file, both).unwrap();
    assert_eq!(load_capture(&file, CaptureHints::default()).unwrap().not_read, ["CW (40 numbers)"]);
    let output = import_among_shipped(&file, folder.path());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(3) && said.contains("(not read in it: CW (40 numbers))"), "{said}");
}

#[test]
fn captures_of_windows_1252_are_read_and_others_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.csv");
    let read = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        load_capture(&file, CaptureHints::default())
    };
    let found = read(b"Pr\xfcfung \x80\nZeit [s];Abweichung [\xb5m]\n0,0;-5,1\n0,1;-5,2\n").unwrap();
    assert!(found.is_latin && found.column == LengthColumn::DeviationUm);
    assert!(found.reading_mm.iter().zip([-5.1e-3, -5.2e-3]).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    assert!(!read("Zeit [s];Abweichung [µm]\n0,0;-5,1\n0,1;-5,2\n".as_bytes()).unwrap().is_latin);
    for bytes in [b"time_s,deviation_um\n0,1\n\xff\0\x01,2\n".as_slice(), b"time_s,deviation_um\n0,1\n\x81,2\n"] {
        let why = read(bytes).unwrap_err().to_string();
        assert!(why.ends_with("a.csv:3: is not UTF-8 text; save it as UTF-8"), "{why}");
    }
}

#[test]
fn captures_state_when_they_were_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let zero = |text: &str| {
        let file = folder.path().join("capture.csv");
        std::fs::write(&file, text).unwrap();
        load_capture(&file, CaptureHints::default()).unwrap().began_at
    };
    let rows = "time_s;deviation_um\n5.0;1\n6.0;2\n";
    let due = Moment::from_text("2026-11-26 10:15:32").map(|moment| moment.seconds_since_1970());
    for head in [
        "Recorded: 2026-11-26 10:15:32",
        "Calibrated: 01.02.2020 08:00\nDatum: 26.11.2026\nUhrzeit: 10:15:32",
        "Test;XY circle\nStart;11/26/2026 10:15:32 AM",
    ] {
        let found = zero(&format!("{head}\n{rows}"));
        assert_eq!(found.map(|moment| moment.seconds_since_1970()), due, "{head}");
    }
    assert_eq!(zero(&format!("Software version 1.2.2026\n{rows}")), None);
    // stamps of rows are nearer than the preamble, which may have the day of both
    for (head, first) in
        [("Recorded: 2026-11-26 10:00\n", "2026-11-26T10:00:59.5"), ("Date: 2026-11-26\n", "10:00:59.5")]
    {
        let stamped = zero(&format!("{head}time;deviation_um\n{first};1\n{};2\n", first.replace(":59.5", ":59.75")));
        let due = Moment::from_text("2026-11-26 10:00:59.5").map(|moment| moment.seconds_since_1970());
        assert_eq!(stamped.map(|moment| moment.seconds_since_1970()), due, "{head}");
    }
    let columns = zero("Date;Time;deviation_um\n26.11.2026;10:15:32;1\n26.11.2026;10:15:33;2\n");
    assert_eq!(columns.map(|moment| moment.seconds_since_1970()), due);
    let values = "1 ".repeat(40);
    let xml = format!(
        "<Test date=\"26/11/2026\"><StartTime>10:15:32</StartTime><Rate>10</Rate><Unit>um</Unit><Readings>{values}</Readings></Test>"
    );
    let file = folder.path().join("capture.b5r");
    std::fs::write(&file, xml).unwrap();
    let found = load_capture(&file, CaptureHints::default()).unwrap();
    assert_eq!(found.began_at, Moment::from_text("2026-11-26 10:15:32"));
    assert!(found.not_read.is_empty(), "{:?}", found.not_read);
    // the date of what stands around it; elements that are not closed, or closed twice
    let around = format!(
        "<Test><Open><Calibration by='lab'><Date>01.02.2020</Date><Start at='08:00:00'/></Calibration></Calibration><Export version='2'/><Date>26.11.2026</Date><Time>10:15:32</Time><Rate>10</Rate><Unit>um</Unit><Readings>{values}</Readings></Test>"
    );
    std::fs::write(&file, around).unwrap();
    let found = load_capture(&file, CaptureHints::default()).unwrap();
    assert_eq!(found.began_at, Moment::from_text("2026-11-26 10:15:32"));
    // a line that promises a time, and says none that is understood, is told
    std::fs::write(&file, format!("Recorded: 2026-11-31 10:15\nStart of sweep no. 7\nRate 10 Hz\n{rows}")).unwrap();
    let found = load_capture(&file, CaptureHints::default()).unwrap();
    assert_eq!(found.began_at, None);
    assert_eq!(found.not_read, ["'Recorded: 2026-11-31 10:15'", "'Start of sweep no. 7'"]);
}

#[test]
fn tests_have_the_times_at_which_their_captures_were_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let of = |name: &str, recorded: &str| {
        let text = std::fs::read_to_string(format!("{SHIPPED}/{name}.csv")).unwrap();
        // without the time that it states itself
        let text: String =
            text.lines().filter(|line| !line.starts_with("Recorded")).map(|line| format!("{line}\n")).collect();
        let file = folder.path().join(format!("{name}.csv"));
        std::fs::write(&file, text.replacen("Sample rate", &format!("{recorded}\nSample rate"), 1)).unwrap();
        file.to_str().unwrap().to_string()
    };
    let (session, out) = (format!("{SHIPPED}/session.yaml"), folder.path().join("imported"));
    let run = |captures: &[String], more: &[&str]| {
        let mut arguments: Vec<&str> = captures.iter().map(String::as_str).collect();
        arguments.extend(["--session", &session, "--force", "--json", "--out", out.to_str().unwrap()]);
        arguments.extend(more);
        import(&arguments)
    };
    let started = |name: &str| {
        let session = fiveaxis::load::load_session(&out.join("session.yaml")).unwrap();
        session.tests.iter().find(|test| test.name == name).unwrap().started_at_s
    };
    // the other way round than planned
    let circle = of("xy-100-1", "Recorded: 2026-11-26 10:30:00");
    let swept = of("a-100-1", "Recorded: 2026-11-26 10:10:00");
    let both = [circle.clone(), swept.clone()];
    let output = run(&both, &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["times"], "captures");
    let begins = |k: usize| json["captures"][k]["arcs_s"][0][0].as_f64().unwrap();
    let near = |found: f64, due: f64| assert!((found - due).abs() < 0.1, "{found} {due}");
    near(started("a-100-1-ccw"), begins(1));
    near(started("xy-100-1-ccw"), 1200.0 + begins(0));
    let alone = std::slice::from_ref(&swept);
    assert!(run(alone, &["--test", "a-100-1-ccw", "--began", "26.11.2026 10:00"]).status.success());
    near(started("a-100-1-ccw"), 600.0 + begins(1));
    // what cannot be: a session that began later, no time at all
    for (began, says) in
        [("2026-11-26 10:20", "was recorded before"), ("noon", "is no time"), ("2026-11-31 10:00", "is no time")]
    {
        let refused = run(&both, &["--began", began]);
        assert_eq!(refused.status.code(), Some(2));
        assert!(
            String::from_utf8_lossy(&refused.stdout).contains(says),
            "{}",
            String::from_utf8_lossy(&refused.stdout)
        );
    }
    // one of two that states nothing: the plan's times, and a warning
    let silent = of("a-100-1", "Bar: 100 mm");
    let output = run(&[circle, silent], &[]);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["times"], "plan");
    assert!(json["warnings"].to_string().contains("does not state when it was recorded"), "{}", json["warnings"]);
}

#[test]
fn a_refused_capture_writes_nothing_and_ends_with_3() {
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("flat.csv");
    let rows: String =
        (0..900).map(|k| format!("{},{}\n", 0.1 * f64::from(k), (k * 7919 % 13) as f64 * 0.02)).collect();
    std::fs::write(&capture, format!("time_s,deviation_um\n{rows}")).unwrap();
    let out = folder.path().join("out");
    let session = format!("{SHIPPED}/session.yaml");
    let output = import(&[
        capture.to_str().unwrap(),
        "--session",
        &session,
        "--test",
        "xy-100-1-ccw",
        "--out",
        out.to_str().unwrap(),
        "--json",
    ]);
    assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stdout));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["error"]["kind"], "data fault");
    assert!(!Path::new(&out).exists());
}

/// An axis that ends its arc at the end of its travel has no run-out: what is read while it rests there is none of the arc.
#[test]
fn readings_at_rest_are_left_out_where_the_arc_ends_with_the_travel() {
    let scratch = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(scratch.path().join(name), text).unwrap();
    write(
        "machine.yaml",
        "name: mill\ncode: \"[wCBbXYZt]\"\ndirections: iso841\naxes:\n  B: {range: [-110, 110]}\n  C: {range: [-360, 360]}\n",
    );
    let test = |name: &str, from: f64, to: f64| {
        format!(
            "  - name: {name}\n    bar_length: 100\n    pivot: {{link: C, at: [100, 0, 0]}}\n    spindle_ball: {{link: Z, at: [0, 0, 0]}}\n    positions: {{X: 0, Y: 0, Z: 0, B: 0}}\n    feed: 1000\n    sweep: {{axis: C, from: {from}, to: {to}, step: 1}}\n"
        )
    };
    write(
        "session.yaml",
        &format!("machine: machine.yaml\ntests:\n{}{}", test("there", 0.0, 360.0), test("back", 360.0, 0.0)),
    );
    // 3 s of rest, a turn at 1000 mm/min with 0.1 s to come to speed, 2 s of rest, the turn back, 8 s of rest
    let turn_s = 60.0 * std::f64::consts::TAU * 100.0 / 1000.0;
    let gone = |since_s: f64| {
        let [whole, ramp] = [turn_s + 0.1, 0.1];
        let rising = |t: f64| if t < ramp { 0.5 * t * t / ramp } else { t - 0.5 * ramp };
        let t = since_s.clamp(0.0, whole);
        (if t < whole - ramp { rising(t) } else { turn_s - 0.5 * (whole - t).powi(2) / ramp }) / turn_s
    };
    let mut capture = String::from("time_s,deviation_um\n");
    let back_s = 3.0 + turn_s + 0.1 + 2.0;
    for row in 0..((back_s + turn_s + 8.0) * 50.0) as usize {
        let time_s = row as f64 / 50.0;
        let angle = std::f64::consts::TAU * (gone(time_s - 3.0) - gone(time_s - back_s));
        let noise = 0.1 * ((row * 7919 % 101) as f64 / 50.0 - 1.0);
        capture += &format!("{time_s:.2},{:.1}\n", 12.0 * angle.cos() - 20.0 * angle.sin() + noise);
    }
    write("capture.csv", &capture);
    let path = |name: &str| scratch.path().join(name).to_str().unwrap().to_string();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_fiveaxis"))
        .args(["import", &path("capture.csv"), "--session", &path("session.yaml"), "--out", &path("run")])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for name in ["run/there.csv", "run/back.csv"] {
        let rows = std::fs::read_to_string(scratch.path().join(name)).unwrap().lines().count() - 1;
        // a hundred rows more would be the rest between the turns
        assert!((rows as f64 - 50.0 * (turn_s + 0.1)).abs() < 40.0, "{name}: {rows} rows");
    }
}

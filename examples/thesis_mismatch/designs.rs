//! The thesis's three designs with the same machine in each, their extensions, and recordings of them by the library's forward model.

use std::error::Error;
use std::path::Path;

use fiveaxis::chain::Composition;
use fiveaxis::load::load_session;
use fiveaxis::machine::{ErrorName, Machine};
use fiveaxis::methods::{MethodError, ThesisEstimate, chapter4, chapter5, chapter6};
use fiveaxis::session::{CirclePlane, Clock, Path as TestPath, Recording, Session, Test};
use fiveaxis::simulate::{Instrument, SetupErrors, simulate_with};

use super::causes::{Extension, LeftOut, Nature};

/// Nominal length of the extended bar, mm.
pub const EXTENDED_MM: f64 = 150.0;
/// Location errors of the machine, the same in every design, µm and arcsec: the thesis's Tables 4.2 and 4.3.
pub const INSERTED: [(&str, f64); 8] = [
    ("EY0A", 34.2),
    ("EZ0A", -35.3),
    ("EB0A", 6.62),
    ("EC0A", 1.89),
    ("EX0C", 1.3),
    ("EY0C", -52.5),
    ("EA0C", -22.32),
    ("EB0C", -3.75),
];

type Method = fn(&Session) -> Result<ThesisEstimate, MethodError>;

/// One chapter's design.
pub struct Design {
    pub chapter: u8,
    pub method: Method,
    pub session: Session,
}

/// The three designs as `examples/thesis` has them, six of the ten repeats: motions, balls and times; lengths are simulated anew.
pub fn designs() -> Result<Vec<Design>, Box<dyn Error>> {
    let methods: [(u8, Method); 3] = [(4, chapter4), (5, chapter5), (6, chapter6)];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/thesis");
    let load = |(chapter, method)| {
        let mut session = load_session(&folder.join(format!("chapter{chapter}/session.yaml")))?;
        // three runs in each direction of five: as much is seen, in less time
        session.tests.retain(|test| ["-1", "-2", "-3"].iter().any(|run| test.name.ends_with(run)));
        Ok(Design { chapter, method, session })
    };
    methods.into_iter().map(load).collect()
}

/// The session in which a cause can be told, and what it adds in words.
pub fn extended(designs: &[Design], extension: Extension) -> (Session, &'static str) {
    let of = |chapter: u8| designs.iter().find(|design| design.chapter == chapter).map(|d| d.session.clone());
    let (Some(four), Some(five), Some(six)) = (of(4), of(5), of(6)) else { return (designs[0].session.clone(), "") };
    match extension {
        Extension::RepeatAtEnd => {
            let mut session = five;
            let again: Vec<Test> = session.tests.iter().filter(|test| test.name.contains("short")).cloned().collect();
            append(&mut session, again, "again-");
            (session, "chapter 5, its short-bar tests again at the end")
        }
        Extension::ShortAtDistance => {
            let mut session = four;
            let moved = short_at_distance(&session);
            let extended = first_two_runs(&session, "extended");
            append(&mut session, moved, "");
            // without a return to the extended bar a slip of the ball would do as well
            append(&mut session, extended, "again-");
            (session, "chapter 4, then the short bar where the extended one stood, then the extended one again")
        }
        Extension::PlanarCircles => {
            let mut session = six;
            let circles = circles(&session);
            append(&mut session, circles, "");
            (session, "chapter 6 and planar circles XY, XZ at X = ±150 mm")
        }
    }
}

/// Seconds between two tests that are appended.
const CHANGE_S: f64 = 30.0;

/// Adds tests after the last one, in their order and with their pauses.
fn append(session: &mut Session, tests: Vec<Test>, prefix: &str) {
    let ends_s = |test: &Test| {
        let rows = test.recording.as_ref().and_then(Recording::time_s).and_then(<[f64]>::last);
        // a circle of 100 mm radius at 500 mm/min lasts 75 s
        test.started_at_s + rows.copied().unwrap_or(75.4)
    };
    let from_s = session.tests.iter().map(ends_s).fold(0.0, f64::max) + CHANGE_S;
    let first_s = tests.iter().map(|test| test.started_at_s).fold(f64::INFINITY, f64::min);
    for mut test in tests {
        test.name = format!("{prefix}{}", test.name);
        test.started_at_s += from_s - first_s;
        session.tests.push(test);
    }
}

/// The short-bar tests of chapter 4 with both balls moved along the axis to where the extended test has its spindle ball:
/// slides and standing ball are those of the extended test, only the bar does not reach along the axis.
fn short_at_distance(session: &Session) -> Vec<Test> {
    let machine = &session.machine;
    let mut tests = Vec::new();
    for (axis, short, slide) in [("a", "a-short", "X"), ("c", "c-short", "Z")] {
        let extended = session.tests.iter().find(|test| test.name.starts_with(&format!("{axis}-extended")));
        let (Some(extended), Some(slide)) = (extended, machine.axis_index(slide)) else { continue };
        let Some(place_mm) = extended.positions[slide] else { continue };
        for mut test in first_two_runs(session, short) {
            test.name = test.name.replace("short", "short-at-distance");
            test.positions[slide] = Some(place_mm);
            test.pivot.at[if axis == "a" { 0 } else { 2 }] = place_mm;
            tests.push(test);
        }
    }
    tests
}

/// One run in each direction of the tests of this name, the pivot mounted anew.
fn first_two_runs(session: &Session, name: &str) -> Vec<Test> {
    let runs = session.tests.iter().filter(|test| test.name.contains(name) && test.name.ends_with("w-1"));
    runs.cloned()
        .map(|mut test| {
            test.pivot.setup = Some("anew".into());
            test
        })
        .collect()
}

/// Planar circles in both directions about pivots on the table at X = ±150 mm; XZ as the half circle above the table.
fn circles(session: &Session) -> Vec<Test> {
    let machine = &session.machine;
    let Some(model) = session.tests.first() else { return Vec::new() };
    let axis = |name: &str| machine.axis_index(name).unwrap_or(0);
    let mut tests = Vec::new();
    for x_mm in [-150.0, 150.0] {
        for (second, arc) in [("Y", (-180.0, 180.0)), ("Z", (0.0, 180.0))] {
            for (way, (from, to)) in [("ccw", arc), ("cw", (arc.1, arc.0))] {
                let mut test = model.clone();
                test.name = format!("x{second}-{x_mm}-{way}").to_lowercase();
                test.recording = None;
                test.recording_file = None;
                test.pivot.at = [x_mm, 0.0, 0.0].into();
                test.started_at_s = 100.0 * tests.len() as f64;
                test.positions = vec![Some(0.0); machine.axes.len()];
                let plane = CirclePlane { first: axis("X"), second: axis(second) };
                test.positions[plane.first] = None;
                test.positions[plane.second] = None;
                test.path = Some(TestPath::Circle { plane, radius_mm: 100.0, from, to, step: 0.5 });
                tests.push(test);
            }
        }
    }
    tests
}

/// The machine with the inserted location errors.
fn inserted(machine: &Machine) -> Result<Machine, Box<dyn Error>> {
    let mut wrong = machine.clone();
    for (name, size) in INSERTED {
        let name = ErrorName::parse(name, &machine.axis_names())?;
        let axis = machine.axis_index(&name.axis).ok_or("no such axis")?;
        wrong.axes[axis].location_errors[name.component.index()] = size / name.component.measure().to_output(1.0);
    }
    Ok(wrong)
}

/// The session with recordings of a machine that has the inserted errors and the cause, read by the default instrument.
///
/// The machine in the session stays nominal: a method or diagnosis knows nothing of either.
pub fn record(session: &Session, cause: &LeftOut, seed: u64) -> Result<Session, Box<dyn Error>> {
    let mut wrong = session.clone();
    wrong.machine = inserted(&session.machine)?;
    wrong.machine.effects.extend(cause.effect(&session.machine, first_change_s(session))?);
    let mut setup = SetupErrors::drawn(session, seed);
    if let Nature::CarelessPivots(times) = cause.nature {
        setup.pivot_mm.iter_mut().for_each(|place| *place *= times);
    }
    let ideal = simulate_with(&wrong, Composition::Exact, &setup)?;
    let traces = Instrument::default().read(session, ideal, seed)?;
    let mut recorded = session.clone();
    for (test, trace) in recorded.tests.iter_mut().zip(traces) {
        match &mut test.recording {
            Some(recording) => recording.length_mm = trace.length_mm,
            None => {
                let motion = &trace.motion;
                test.recording = Some(Recording {
                    clock: motion.time_s.clone().map_or(Clock::Absent, Clock::TimeS),
                    axes: motion.moving.clone(),
                    positions: motion.moving.iter().map(|&axis| motion.axis(axis).collect()).collect(),
                    length_mm: trace.length_mm,
                    channels: Vec::new(),
                    leading_texts: std::sync::Arc::default(),
                    leading_header: String::new(),
                    column: Default::default(),
                    scatter: None,
                });
            }
        }
    }
    Ok(recorded)
}

/// Session time just before the second group of runs: where the bar or the pivot is changed for the first time.
fn first_change_s(session: &Session) -> f64 {
    let group = |name: &str| name.split("-ccw").next().unwrap_or(name).split("-cw").next().unwrap_or(name).to_string();
    let first = session.tests.first().map(|test| group(&test.name));
    session.tests.iter().find(|test| Some(group(&test.name)) != first).map_or(0.0, |test| test.started_at_s - 10.0)
}

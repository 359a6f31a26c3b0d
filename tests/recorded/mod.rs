//! Sessions for tests: small designs in the thesis's manner, and traces put back as recordings.
#![allow(dead_code)] // every test file uses its own part

use std::path::Path;

use fiveaxis::load::load_session;
use fiveaxis::session::{Clock, Path as TestPath, Recording, Session};
use fiveaxis::simulate::Trace;

/// The session with the traces as its recordings.
pub fn recorded(session: &Session, traces: &[Trace]) -> Session {
    let mut session = session.clone();
    for (test, trace) in session.tests.iter_mut().zip(traces) {
        let motion = &trace.motion;
        test.recording = Some(Recording {
            clock: motion.time_s.clone().map_or(Clock::Absent, Clock::TimeS),
            axes: motion.moving.clone(),
            positions: motion.moving.iter().map(|&axis| motion.axis(axis).collect()).collect(),
            length_mm: trace.length_mm.clone(),
            channels: Vec::new(),
            leading_texts: std::sync::Arc::default(),
            leading_header: String::new(),
            column: Default::default(),
            scatter: None,
        });
    }
    session
}

/// Chapter 5's four tests, one run in each direction, planned with so many samples each.
pub fn planned_thesis_session(samples: usize) -> Session {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/thesis/chapter5/session.yaml");
    let mut session = load_session(&file).unwrap();
    session.tests.retain(|test| test.name.ends_with("-1"));
    for test in &mut session.tests {
        let recording = test.recording.take().unwrap();
        test.recording_file = None;
        let axis = recording.axes[0];
        let (first, last) = (recording.positions[0][0], recording.positions[0][recording.len() - 1]);
        let (from, to) = (first.to_degrees(), last.to_degrees());
        let step = (to - from).abs() / (samples - 1) as f64;
        test.path =
            Some(TestPath::Sweep { axis, from, to, step, follow: fiveaxis::session::Follow::None, length_mm: None });
    }
    session
}

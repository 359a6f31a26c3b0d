//! Placed captures as recordings of their tests: rows on the capture arcs alone, each with its positions. It judges nothing.

use super::capture::Capture;
use super::place::Placement;
use super::session_times::SessionTimes;
use crate::session::{Clock, LengthColumn, Marks, Recording, Session};

/// The two recordings of a placed capture, `bar_mm` added to its readings, and when each began, s after the capture's zero.
pub fn recordings(
    placement: &Placement,
    capture: &Capture,
    bar_mm: f64,
    column: LengthColumn,
) -> [(Recording, f64); 2] {
    let (course, timing) = (&placement.course, &placement.timing);
    let spikes = capture.spikes();
    [0, 1].map(|direction| {
        let [begin, end] = [course.arc_s[0], course.arc_s[1]];
        let gone = |time: f64| timing.gone_s(direction, time - timing.start_s[direction], course.run_s);
        // the second direction comes from the far end of the run
        let (enter, leave) = if direction == 0 { (begin, end) } else { (course.run_s - end, course.run_s - begin) };
        let begins_s = timing.time_at(direction, enter, course.run_s);
        // an arc may end where the run does: at rest the axes stay there
        let rests_s = timing.ends_s(direction, course.run_s);
        let rows: Vec<usize> = (0..capture.time_s.len())
            .filter(|&row| {
                let gone = gone(capture.time_s[row]);
                let runs = capture.time_s[row] > timing.start_s[direction] && capture.time_s[row] <= rests_s;
                runs && gone >= enter && gone <= leave
            })
            .collect();
        let along = |row: usize| match direction {
            0 => gone(capture.time_s[row]),
            _ => course.run_s - gone(capture.time_s[row]),
        };
        let positions = course
            .moving()
            .iter()
            .map(|&axis| rows.iter().map(|&row| course.position(axis, along(row))).collect::<Vec<f64>>());
        let reading = |&row: &usize| match spikes[row] {
            true => f64::NAN,
            false => capture.reading_mm[row] + bar_mm,
        };
        let recording = Recording {
            clock: Clock::TimeS(rows.iter().map(|&row| capture.time_s[row] - begins_s).collect()),
            axes: course.moving().to_vec(),
            positions: positions.collect(),
            length_mm: rows.iter().map(reading).collect(),
            channels: Vec::new(),
            leading_texts: std::sync::Arc::default(),
            leading_header: String::new(),
            column,
            scatter: None,
        };
        (recording, begins_s)
    })
}

/// The session with recordings in place of planned paths; tests without a capture are left out.
pub fn split_session(
    session: &Session,
    placed: &[(Placement, [(Recording, f64); 2])],
    times: &SessionTimes,
) -> Session {
    let mut split = session.clone();
    split.tests.clear();
    for (index, test) in session.tests.iter().enumerate() {
        for (k, (placement, recordings)) in placed.iter().enumerate() {
            let Some(direction) = placement.pair.tests.iter().position(|&test| test == index) else { continue };
            let (recording, begins_s) = &recordings[direction];
            let mut test = test.clone();
            test.recording_file = Some(format!("{}.csv", test.name));
            // without a time of its own the pair began as planned, its arcs as found
            let zero_s = match times {
                SessionTimes::Stated(zeros_s) => zeros_s[k],
                SessionTimes::Planned(_) => session.tests[placement.pair.tests[0]].started_at_s,
            };
            test.started_at_s = zero_s + begins_s;
            test.recording = Some(recording.clone());
            test.path = None;
            // to a tenth of a micrometre, as gauges read
            let seen_mm = placement.marks_mm[direction].map(|seen| seen.map(|mm| (mm * 1e4).round() / 1e4));
            test.marks = test.marks.map(|marks| Marks { seen_mm, ..marks });
            split.tests.push(test);
        }
    }
    split
}

//! Session files that are refused, each with its one message.

use super::{SESSION, changed, check_session};

#[test]
fn one_message_each() {
    let cases: Vec<(&str, String, &str)> = vec![
        (
            "unknown session key",
            format!("{SESSION}{}", "    fed: 500\n"),
            "session.yaml:10:5: unknown key 'fed' under tests[0]; did you mean 'feed'? (allowed: name, recording, started_at, bar_length, bar_setup, zero, bar_error, pivot, spindle_ball, readings, instrument, socket, target, columns, positions, approached, feed, overshoot, marks, sweep, circle)",
        ),
        (
            "bare spread",
            changed(SESSION, "tests:", "spread: {pivot: 20}\ntests:"),
            "session.yaml:3:10: '20' has no unit; write for example '20 um' (allowed: um, µm, μm, mm, nm, m)",
        ),
        (
            "no such axis",
            changed(SESSION, "X: 0,", "X: 0, B: 0,"),
            "session.yaml:9:23: the machine has no axis 'B'; its axes are C A Y X Z",
        ),
        (
            "axis nowhere",
            changed(SESSION, "X: 0, ", ""),
            "session.yaml:9:5: test 'a': axis X has neither a column in the recording nor a place in positions; add it, e.g. X: 0",
        ),
        (
            "standing outside",
            changed(SESSION, "X: 0,", "X: 999,"),
            "session.yaml:9:17: X = 999 mm is outside the axis's range -300 … 300 mm",
        ),
        (
            "no link",
            changed(SESSION, "link: C", "link: D"),
            "session.yaml:7:5: no link is called 'D'; did you mean 'b'? (links: b w t C A Y X Z)",
        ),
        (
            "index of a pivot",
            changed(SESSION, "at: [0, 100, 0]}", "at: [0, 100, 0], indexed_about: z}"),
            "session.yaml:7:5: a pivot is not indexed; 'indexed_about' is for the spindle ball",
        ),
        (
            "index about no direction",
            changed(SESSION, "at: [0, 0, 0]}", "at: [0, 0, 0], indexed_about: w}"),
            "session.yaml:8:5: indexed_about 'w' is not the direction of R along which the spindle lies with all axes at zero: x, y or z",
        ),
        (
            "same name twice",
            format!("{SESSION}{}", &SESSION[SESSION.find("  - name").unwrap()..]),
            "session.yaml:10:5: the name 'a' stands twice; each test has its own",
        ),
        (
            "escape",
            changed(SESSION, "recording: a.csv", "recording: ../a.csv"),
            "session.yaml:5:5: recording '../a.csv' leaves the session's folder; put the file beside the session",
        ),
        (
            "no recording",
            changed(SESSION, "recording: a.csv", "recording: b.csv"),
            "b.csv: is not there; check its name and folder",
        ),
        (
            "nan at",
            changed(SESSION, "[0, 100, 0]", "[0, .nan, 0]"),
            "session.yaml:7:5: 'NaN' is not a finite number between -10000000 and 10000000",
        ),
        (
            "no tests",
            format!("{}tests: []\n", &SESSION[..SESSION.find("tests:").unwrap()]),
            "session.yaml:3:1: 0 tests; a session has 1 to 5000",
        ),
        (
            "test name",
            changed(SESSION, "name: a", "name: ../a"),
            "session.yaml:4:5: test '../a': recordings are named after their tests; a name is 1 to 200 characters without / and \\",
        ),
        (
            "bar 0",
            changed(SESSION, "100.002", "0"),
            "session.yaml:6:5: test 'a': bar_length 0 is not a number from 0.001 to 10000000 mm",
        ),
        (
            "sweep range",
            changed(SESSION, "recording: a.csv", "sweep: {axis: A, from: 0, to: 200}"),
            "session.yaml:5:5: A = 200 deg is outside the axis's range -30 … 110 deg",
        ),
        (
            "follow of a slide",
            changed(SESSION, "recording: a.csv", "sweep: {axis: X, from: 0, to: 20, follow: radial}"),
            "session.yaml:5:5: 'follow' has the linear axes follow a rotary axis, and X is linear; leave it out, or name a rotary axis",
        ),
    ];
    for (name, text, message) in cases {
        check_session(name, &text, message);
    }
}

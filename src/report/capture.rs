//! Placed captures as a table, as JSON and as pictures: readings over time with the two arcs. It computes nothing.

use std::fmt::Write as _;

use serde::Serialize;

use crate::import::{Placement, SessionTimes};
use crate::report::wording::markup::escape;
use crate::report::wording::table::Table;
use crate::session::Session;
use crate::units::UM_PER_MM;

/// One placed capture.
#[derive(Debug, Clone, Serialize)]
pub struct PlacedJson {
    /// File as named by the user.
    pub file: String,
    /// The two tests, in the order in which they ran.
    pub tests: [String; 2],
    /// Rows of their recordings.
    pub rows: [usize; 2],
    /// Begin of motion in each direction after the first reading, by the gauge's clock, s, with standard deviations. A constant delay of the gauge
    /// cannot be told from them and is part of them.
    pub start_s: [f64; 2],
    pub start_sigma_s: [f64; 2],
    /// Begin and end of each capture arc after the first reading, s.
    pub arcs_s: [[f64; 2]; 2],
    /// Mean speed over the programmed feed, and that of each direction.
    pub pace: f64,
    pub paces: [f64; 2],
    pub pace_sigma: f64,
    /// Time in which the control came to speed, s.
    pub ramp_s: f64,
    /// Time constant of the servos' lag, s, as the marks show it.
    pub lag_s: f64,
    /// Standard deviation of the path position of a reading, in `position_unit` (`deg` or `mm`).
    pub position_sigma: f64,
    pub position_unit: &'static str,
    /// What the model leaves of the readings, root mean square, and the noise of one reading, µm.
    pub left_um: f64,
    pub noise_um: f64,
    /// The program's marks told when the runs began and ended.
    pub by_marks: bool,
    /// Log odds against the next best place in time and the next best pair of tests; null where there is none.
    pub log_odds_place: Option<f64>,
    pub log_odds_tests: Option<f64>,
    /// Readings left out as spikes.
    pub spikes: usize,
    /// Columns or elements of the file that were not read.
    pub not_read: Vec<String>,
}

/// `fiveaxis import --json`.
#[derive(Debug, Clone, Serialize)]
pub struct ImportJson {
    pub session: String,
    /// Folder with session, machine, recordings and pictures.
    pub written: String,
    /// Whose times tests have.
    pub times: TimesOf,
    pub captures: Vec<PlacedJson>,
    /// Tests of the session that no capture holds.
    pub missing: Vec<String>,
}

/// Whose times the tests of a session have.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TimesOf {
    /// They state when they were recorded.
    Captures,
    Plan,
}

impl TimesOf {
    pub fn of(times: &SessionTimes) -> TimesOf {
        match times {
            SessionTimes::Stated(_) => TimesOf::Captures,
            SessionTimes::Planned(_) => TimesOf::Plan,
        }
    }
}

/// The JSON value of a placed capture.
pub fn placed_json(session: &Session, file: String, placement: &Placement, rows: [usize; 2]) -> PlacedJson {
    let (course, timing) = (&placement.course, &placement.timing);
    let known = |odds: f64| odds.is_finite().then_some(odds);
    let arcs_s = [0, 1].map(|direction| {
        let gone = |arc: f64| if direction == 0 { arc } else { course.run_s - arc };
        let [begin, end] = if direction == 0 { course.arc_s } else { [course.arc_s[1], course.arc_s[0]] };
        [begin, end].map(|arc| timing.time_at(direction, gone(arc), course.run_s))
    });
    PlacedJson {
        file,
        tests: placement.pair.tests.map(|test| session.tests[test].name.clone()),
        rows,
        start_s: timing.start_s,
        start_sigma_s: [placement.sigma[0], placement.sigma[1]],
        arcs_s,
        pace: timing.pace(),
        paces: timing.paces,
        pace_sigma: placement.sigma[2],
        ramp_s: timing.ramp_s,
        lag_s: timing.lag_s,
        position_sigma: placement.position_sigma,
        position_unit: if course.unit == "°" { "deg" } else { "mm" },
        left_um: placement.left_mm * UM_PER_MM,
        noise_um: placement.noise_mm * UM_PER_MM,
        by_marks: placement.by_marks,
        log_odds_place: known(placement.odds_place),
        log_odds_tests: known(placement.odds_tests),
        spikes: 0,
        not_read: Vec::new(),
    }
}

/// What an import did, for a terminal.
pub fn import_text(json: &ImportJson) -> String {
    let mut table =
        Table::new(&["capture", "tests", "rows", "begins s", "", "pace", "axis position", "left µm", "noise µm"]);
    for placed in &json.captures {
        let start = |k: usize| format!("{:.3} ± {:.3}", placed.start_s[k], placed.start_sigma_s[k]);
        table.row(vec![
            placed.file.clone(),
            placed.tests.join(", "),
            format!("{} + {}", placed.rows[0], placed.rows[1]),
            start(0),
            start(1),
            format!("{:.4}", placed.pace),
            format!("± {:.3} {}", placed.position_sigma, placed.position_unit),
            format!("{:.2}", placed.left_um),
            format!("{:.2}", placed.noise_um),
        ]);
    }
    let mut out = table.text();
    out.push_str(
        "  begins: after the first reading, by the gauge's clock; a constant delay of the gauge cannot be told from it and is part of it\n",
    );
    out.push_str(match json.times {
        TimesOf::Captures => "  times within the session: as the captures state\n",
        TimesOf::Plan => "  times within the session: as planned; correct started_at if the tests ran at others, as drift is told by them\n",
    });
    for placed in json.captures.iter().filter(|placed| !placed.not_read.is_empty()) {
        let _ = writeln!(out, "  {}: not read: {}", placed.file, placed.not_read.join(", "));
    }
    if !json.missing.is_empty() {
        let _ = writeln!(out, "  without a capture: {}", json.missing.join(", "));
    }
    let _ = writeln!(out, "written: {}", json.written);
    out
}

/// Size of a picture, px, and its margins.
const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 420.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 48.0;
const BOTTOM: f64 = 40.0;

/// A capture as SVG: readings over time, the model, the two capture arcs.
pub fn capture_svg(placed: &PlacedJson, placement: &Placement) -> String {
    let rows = &placement.averages;
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    };
    let (first, last) = range(&mut rows.iter().map(|row| row[0]));
    let (low, high) = range(&mut rows.iter().flat_map(|row| [row[1], row[1] - row[2]]));
    let room = 0.08 * (high - low).max(1e-6);
    let (low, high) = (low - room, high + room);
    let x = |time: f64| LEFT + (time - first) / (last - first).max(1e-9) * (WIDTH - LEFT - 16.0);
    let y = |value: f64| TOP + (high - value) / (high - low) * (HEIGHT - TOP - BOTTOM);
    let line = |value: &dyn Fn(&[f64; 3]) -> f64| -> String {
        rows.iter().map(|row| format!("{:.1},{:.1} ", x(row[0]), y(value(row)))).collect()
    };
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n<text x=\"{LEFT}\" y=\"20\" font-weight=\"bold\">{}</text>\n",
        escape(&format!(
            "{}: axis position ± {:.3} {}, pace {:.4}",
            placed.file, placed.position_sigma, placed.position_unit, placed.pace
        ))
    );
    for (name, [begin, end]) in placed.tests.iter().zip(placed.arcs_s) {
        let _ = writeln!(
            out,
            "<rect x=\"{:.1}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#dbe9f6\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" fill=\"#345\">{}</text>",
            x(begin),
            x(end) - x(begin),
            HEIGHT - TOP - BOTTOM,
            x(begin) + 4.0,
            TOP - 6.0,
            escape(name)
        );
    }
    let _ = writeln!(
        out,
        "<polyline fill=\"none\" stroke=\"#999\" stroke-width=\"3\" points=\"{}\"/>\n<polyline fill=\"none\" stroke=\"#b3261e\" stroke-width=\"1.2\" points=\"{}\"/>",
        line(&|row| row[1]),
        line(&|row| row[1] - row[2])
    );
    for k in 0..=4 {
        let (value, time) = (low + (high - low) * f64::from(k) / 4.0, first + (last - first) * f64::from(k) / 4.0);
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{:.1}</text>\n<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{time:.1} s</text>",
            LEFT - 6.0,
            y(value) + 4.0,
            value * UM_PER_MM,
            x(time),
            HEIGHT - BOTTOM + 20.0
        );
    }
    let _ = writeln!(
        out,
        "<text x=\"{:.1}\" y=\"20\" text-anchor=\"end\" fill=\"#555\">µm about the median: grey readings, red model; shaded: capture arcs</text>\n</svg>",
        WIDTH - 16.0
    );
    out
}

//! Placed captures as a table, as JSON and as pictures: readings over time with the two arcs. It computes nothing.

use std::fmt::Write as _;

use serde::Serialize;

use crate::import::{Placement, SessionTimes};
use crate::load::printable::shortened;
use crate::report::pictures::frame::{plain, round_step};
use crate::report::wording::markup::escape;
use crate::report::wording::table::Table;
use crate::session::Session;
use crate::units::{MS_PER_S, UM_PER_MM};

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
    let mut table = Table::new(&[
        "capture",
        "tests",
        "rows",
        "begins s",
        "",
        "pace",
        "ramp s",
        "lag ms",
        "axis position",
        "left µm",
        "noise µm",
    ]);
    for placed in &json.captures {
        let start = |k: usize| format!("{:.3} ± {:.3}", placed.start_s[k], placed.start_sigma_s[k]);
        table.row(vec![
            placed.file.clone(),
            placed.tests.join(", "),
            format!("{} + {}", placed.rows[0], placed.rows[1]),
            start(0),
            start(1),
            format!("{:.4}", placed.pace),
            format!("{:.3}", placed.ramp_s),
            format!("{:.1}", placed.lag_s * MS_PER_S),
            format!("± {:.3} {}", placed.position_sigma, placed.position_unit),
            format!("{:.2}", placed.left_um),
            format!("{:.2}", placed.noise_um),
        ]);
    }
    let mut out = table.text();
    out.push_str(
        "  begins: after the first reading, by the gauge's clock; a constant delay of the gauge cannot be told from it and is part of it\n",
    );
    out.push_str(
        "  pace: speed over the programmed feed; ramp: time to come to speed; lag: time constant of the servos\n",
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
const HEIGHT: f64 = 460.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 100.0;
const BOTTOM: f64 = 40.0;
/// Heights of the lines of words above the picture, px: what it is of, how sure, what its colours mean, the two tests.
const TITLE: f64 = 20.0;
const SURE: f64 = 39.0;
const LEGEND: f64 = 58.0;
const TESTS: [f64; 2] = [78.0, 94.0];
/// Width of a letter, px, at most: names may lie so near to the right edge. Longest name shown, characters.
const LETTER: f64 = 8.5;
const LONGEST: usize = 90;
/// Numbers on the axes, about.
const LEVELS: f64 = 5.0;
const TIMES: f64 = 8.0;

/// Where times, s, and readings, mm, lie in a picture.
struct Places {
    first: f64,
    last: f64,
    low: f64,
    high: f64,
}

impl Places {
    fn of(rows: &[[f64; 3]]) -> Places {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
        };
        let (first, last) = range(&mut rows.iter().map(|row| row[0]));
        let (low, high) = range(&mut rows.iter().flat_map(|row| [row[1], row[1] - row[2]]));
        let room = 0.08 * (high - low).max(1e-6);
        Places { first, last, low: low - room, high: high + room }
    }

    fn x(&self, time: f64) -> f64 {
        LEFT + (time - self.first) / (self.last - self.first).max(1e-9) * (WIDTH - LEFT - RIGHT)
    }

    fn y(&self, value: f64) -> f64 {
        TOP + (self.high - value) / (self.high - self.low) * (HEIGHT - TOP - BOTTOM)
    }

    /// A band between two times over the whole height.
    fn band(&self, [begin, end]: [f64; 2], fill: &str) -> String {
        let (begin, end) = (begin.max(self.first), end.min(self.last));
        format!(
            "<rect x=\"{:.1}\" y=\"{TOP}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{fill}\"/>\n",
            self.x(begin),
            (self.x(end) - self.x(begin)).max(0.0),
            HEIGHT - TOP - BOTTOM
        )
    }

    /// Round numbers on both axes with lines across.
    fn numbers(&self) -> String {
        let mut out = String::new();
        for um in round_between(UM_PER_MM * self.low, UM_PER_MM * self.high, LEVELS) {
            let y = self.y(um / UM_PER_MM);
            let _ = writeln!(
                out,
                "<path d=\"M{LEFT} {y:.1}H{:.1}\" stroke=\"#e4e4e4\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                WIDTH - RIGHT,
                LEFT - 6.0,
                y + 4.0,
                plain(um)
            );
        }
        for time in round_between(self.first, self.last, TIMES) {
            let (x, below) = (self.x(time), HEIGHT - BOTTOM);
            let _ = writeln!(
                out,
                "<path d=\"M{x:.1} {below}v5\" stroke=\"#555\"/>\n<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{} s</text>",
                below + 20.0,
                plain(time)
            );
        }
        out
    }

    /// Lines through rows of one stretch after another, without one between them.
    fn lines(&self, stretches: &[&[[f64; 3]]], value: impl Fn(&[f64; 3]) -> f64, style: &str) -> String {
        let line = |rows: &[[f64; 3]]| -> String {
            rows.iter().map(|row| format!("{:.1},{:.1} ", self.x(row[0]), self.y(value(row)))).collect()
        };
        stretches.iter().map(|rows| format!("<polyline fill=\"none\" {style} points=\"{}\"/>\n", line(rows))).collect()
    }
}

/// About so many round numbers from one number to another.
fn round_between(low: f64, high: f64, about: f64) -> Vec<f64> {
    let step = round_step(((high - low) / about).max(1e-9));
    ((low / step).ceil() as i64..=(high / step).floor() as i64).map(|k| k as f64 * step).collect()
}

/// Rows between marks, which they leave out.
fn between_marks<'r>(rows: &'r [[f64; 3]], marks_s: &[[f64; 2]]) -> Vec<&'r [[f64; 3]]> {
    let before = |row: &[f64; 3]| marks_s.iter().filter(|[begin, _]| row[0] > *begin).count();
    rows.chunk_by(|one, next| before(one) == before(next)).collect()
}

/// A capture as SVG: readings over time, the model, the two capture arcs, the marks left out.
pub fn capture_svg(placed: &PlacedJson, placement: &Placement) -> String {
    let places = Places::of(&placement.averages);
    let stretches = between_marks(&placement.averages, &placement.marks_s);
    let name = placed.file.rsplit(['/', '\\']).next().unwrap_or(&placed.file);
    let sure =
        format!("axis position ± {:.3} {}, pace {:.4}", placed.position_sigma, placed.position_unit, placed.pace);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n<text x=\"{LEFT}\" y=\"{TITLE}\" font-weight=\"bold\">{}</text>\n<text x=\"{LEFT}\" y=\"{SURE}\">{sure}</text>\n{}",
        escape(&shortened(name, LONGEST)),
        legend(!placement.marks_s.is_empty())
    );
    placed.arcs_s.iter().for_each(|arc| out.push_str(&places.band(*arc, "#dbe9f6")));
    placement.marks_s.iter().for_each(|mark| out.push_str(&places.band(*mark, "#ececec")));
    out.push_str(&places.numbers());
    for ((name, [begin, _]), y) in placed.tests.iter().zip(placed.arcs_s).zip(TESTS) {
        let (name, x) = (shortened(name, LONGEST), places.x(begin) + 4.0);
        // a long name ends at the edge in place of beginning at its arc
        let fits = x + LETTER * name.chars().count() as f64 <= WIDTH - RIGHT;
        let (x, anchor) = if fits { (x, "start") } else { (WIDTH - RIGHT, "end") };
        let _ = writeln!(
            out,
            "<text x=\"{x:.1}\" y=\"{y}\" text-anchor=\"{anchor}\" fill=\"#345\">{}</text>",
            escape(&name)
        );
    }
    out.push_str(&places.lines(&stretches, |row| row[1], "stroke=\"#999\" stroke-width=\"3\""));
    out.push_str(&places.lines(&stretches, |row| row[1] - row[2], "stroke=\"#b3261e\" stroke-width=\"1.2\""));
    out.push_str("</svg>\n");
    out
}

/// What the colours mean, in one line.
fn legend(has_marks: bool) -> String {
    let marks = if has_marks { "; marks left out in grey bands" } else { "" };
    format!(
        "<text x=\"{LEFT}\" y=\"{LEGEND}\" fill=\"#555\">µm about the median: readings grey, model red; capture arcs in blue bands{marks}</text>\n"
    )
}

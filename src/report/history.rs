//! Trends of a machine as a table, JSON and a page. It fits nothing.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::history::{Course, Point, Trend};
use crate::report::pictures::cards::{Card, cards};
use crate::report::wording::markup::{escape, machine_head};
use crate::report::wording::table::Table;

/// One error over the sessions.
pub struct ErrorHistory {
    /// ISO 230-1 name.
    pub name: String,
    /// `µm` or `arcsec`.
    pub unit: &'static str,
    /// Values with the standard deviation of their noise, in the unit.
    pub points: Vec<Point>,
    /// Standard deviations with all that a session says of itself, in the order of the points.
    pub whole_sigma: Vec<f64>,
    pub trend: Trend,
}

/// A machine over its sessions.
pub struct HistoryReport {
    pub machine: String,
    /// Date and name of each session.
    pub sessions: Vec<(String, String)>,
    /// Days since the first session, by session.
    pub days: Vec<f64>,
    pub errors: Vec<ErrorHistory>,
    /// Sessions that give no point, with why.
    pub left_out: Vec<String>,
}

/// Points from which a course is told.
const LEAST_POINTS: usize = 4;

/// Days of a month for rates.
const MONTH: f64 = 30.0;

/// What changed between the first and the last of few sessions, in words.
fn from_first_to_last(error: &ErrorHistory) -> String {
    match (error.points.first(), error.points.last()) {
        (Some(first), Some(last)) if error.points.len() > 1 => format!(
            "{:+.2} ± {:.2} {} from first to last; a course is told from {LEAST_POINTS} sessions on",
            last.value - first.value,
            first.sigma.hypot(last.sigma),
            error.unit
        ),
        _ => format!("one session; a course is told from {LEAST_POINTS} on"),
    }
}

/// The course in words.
fn course(error: &ErrorHistory, report: &HistoryReport) -> String {
    let date = |day: f64| {
        let at = report.days.iter().position(|other| *other == day);
        at.map_or_else(String::new, |k| report.sessions[k].0.clone())
    };
    match error.trend.course {
        Course::Steady if error.points.len() < LEAST_POINTS => from_first_to_last(error),
        Course::Steady => "steady".into(),
        Course::Drift { per_day, sigma } => {
            format!("drifts by {:+.2} ± {:.2} {} a month", per_day * MONTH, sigma * MONTH, error.unit)
        }
        Course::Step { by, sigma, after_day, before_day } => format!(
            "jumps by {by:+.2} ± {sigma:.2} {} between {} and {}",
            error.unit,
            date(after_day),
            date(before_day)
        ),
    }
}

fn course_json(course: &Course) -> Value {
    match *course {
        Course::Steady => json!({ "kind": "steady" }),
        Course::Drift { per_day, sigma } => {
            json!({ "kind": "drift", "per_month": per_day * MONTH, "sigma": sigma * MONTH })
        }
        Course::Step { by, sigma, after_day, before_day } => {
            json!({ "kind": "step", "by": by, "sigma": sigma, "after_day": after_day, "before_day": before_day })
        }
    }
}

/// As text.
pub fn history_text(report: &HistoryReport) -> String {
    let mut text = format!("{}: {} sessions", report.machine, report.sessions.len());
    if let (Some(first), Some(last)) = (report.sessions.first(), report.sessions.last()) {
        let _ = write!(text, " from {} to {}", first.0, last.0);
    }
    text.push_str("\n\n");
    let mut table = Table::new(&["error", "mean", "scatter", "unit", "sessions", "course"]);
    for error in &report.errors {
        table.row(vec![
            error.name.clone(),
            format!("{:.2}", error.trend.mean),
            format!("{:.2}", error.trend.scatter),
            error.unit.into(),
            error.points.len().to_string(),
            course(error, report),
        ]);
    }
    text.push_str(&table.text());
    text.push_str(
        "\nA drift or step is told when it explains the values seventy-four times better than scatter does.\n",
    );
    text
}

/// As JSON.
pub fn history_json(report: &HistoryReport) -> Value {
    let errors: Vec<Value> = report
        .errors
        .iter()
        .map(|error| {
            let points: Vec<Value> = error
                .points
                .iter()
                .zip(&error.whole_sigma)
                .map(|(point, sigma)| json!({ "day": point.day, "value": point.value, "sigma_noise": point.sigma, "sigma": sigma }))
                .collect();
            json!({
                "error": error.name,
                "unit": if error.unit == "µm" { "um" } else { error.unit },
                "mean": error.trend.mean,
                "mean_sigma": error.trend.mean_sigma,
                "scatter": error.trend.scatter,
                "evidence": error.trend.evidence,
                "course": course_json(&error.trend.course),
                "says": course(error, report),
                "points": points,
            })
        })
        .collect();
    let sessions: Vec<Value> = report
        .sessions
        .iter()
        .zip(&report.days)
        .map(|((date, name), day)| json!({ "date": date, "name": name, "day": day }))
        .collect();
    json!({ "machine": report.machine, "sessions": sessions, "errors": errors })
}

/// The page.
pub fn history_page(report: &HistoryReport) -> String {
    let says = format!("{} sessions", report.sessions.len());
    let mut page = machine_head("History", "History", &report.machine, &says);
    let moving = report.errors.iter().filter(|error| error.trend.course != Course::Steady).count();
    let largest = report
        .errors
        .iter()
        .filter(|error| error.trend.course != Course::Steady)
        .max_by(|a, b| a.trend.evidence.total_cmp(&b.trend.evidence));
    let head = [
        Card {
            label: "Errors that move",
            figure: format!("{moving} of {}", report.errors.len()),
            note: "beyond the scatter of the sessions".into(),
        },
        Card {
            label: "Clearest",
            figure: largest.map_or("none".into(), |error| escape(&error.name)),
            note: match largest {
                Some(error) => escape(&course(error, report)),
                None if report.errors.iter().all(|error| error.points.len() < LEAST_POINTS) => {
                    "few sessions: see the change of each error".into()
                }
                None => "all values within their scatter".into(),
            },
        },
    ];
    cards(&mut page, &head);
    for says in &report.left_out {
        let _ = writeln!(page, "<p class=\"warning\">{}</p>", escape(says));
    }
    page.push_str("<h2>Each error over time</h2><div class=\"tests\">\n");
    for error in &report.errors {
        let _ = writeln!(
            page,
            "<figure>{}<figcaption>{}: {}</figcaption></figure>",
            plot(error, report),
            escape(&error.name),
            escape(&course(error, report))
        );
    }
    page.push_str("</div>\n<footer>fiveaxis history; bars are one standard deviation with all that a session says of itself</footer></main></body></html>\n");
    page
}

/// Values over time with their bars and the course.
fn plot(error: &ErrorHistory, report: &HistoryReport) -> String {
    let (left, top, width, height) = (60.0, 14.0, 420.0, 180.0);
    let last = report.days.last().copied().filter(|day| *day > 0.0).unwrap_or(1.0);
    let ends = error
        .points
        .iter()
        .zip(&error.whole_sigma)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (point, sigma)| {
            (low.min(point.value - sigma), high.max(point.value + sigma))
        });
    let (low, high) = if ends.1 - ends.0 < 1e-9 { (ends.0 - 1.0, ends.1 + 1.0) } else { ends };
    let x = |day: f64| left + width * day / last;
    let y = |value: f64| top + height * (high - value) / (high - low);
    let mut svg =
        format!("<svg viewBox=\"0 0 500 230\" role=\"img\" aria-label=\"{} over time\">", escape(&error.name));
    let mut path = String::new();
    for (k, point) in error.points.iter().enumerate() {
        let _ = write!(
            path,
            "{}{:.1} {:.1}",
            if k == 0 { "M" } else { "L" },
            x(point.day),
            y(error.trend.at(&error.points, point.day))
        );
    }
    let _ = write!(svg, "<path d=\"{path}\" fill=\"none\" stroke=\"var(--accent)\" stroke-width=\"1.5\"/>");
    for (point, sigma) in error.points.iter().zip(&error.whole_sigma) {
        let _ = write!(
            svg,
            "<line x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{:.1}\" y2=\"{:.1}\" stroke=\"var(--soft)\"/><circle cx=\"{x:.1}\" cy=\"{:.1}\" r=\"3.5\" fill=\"var(--data)\"><title>{:.2} ± {sigma:.2} {}</title></circle>",
            y(point.value - sigma),
            y(point.value + sigma),
            y(point.value),
            point.value,
            error.unit,
            x = x(point.day)
        );
    }
    let label = |x: f64, y: f64, anchor: &str, text: &str| {
        format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"12\" fill=\"currentColor\">{text}</text>"
        )
    };
    svg.push_str(&label(left - 6.0, top + 10.0, "end", &format!("{high:.1}")));
    svg.push_str(&label(left - 6.0, top + height, "end", &format!("{low:.1}")));
    svg.push_str(&label(left - 6.0, top + 0.5 * height, "end", error.unit));
    if let (Some(first), Some(last)) = (report.sessions.first(), report.sessions.last()) {
        svg.push_str(&label(left, top + height + 18.0, "start", &first.0));
        svg.push_str(&label(left + width, top + height + 18.0, "end", &last.0));
    }
    svg.push_str("</svg>");
    svg
}

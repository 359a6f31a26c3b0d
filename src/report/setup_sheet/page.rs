//! The setup sheet: a stand-alone HTML page to print, one sheet of paper for the plan and one for each test. It computes nothing.

use std::fmt::Write as _;

use super::dry_run;
use super::mounting;
use super::picture;
use super::readings;
use super::sheet::Sheet;
use super::trade_off;
use crate::bodies::Kit;
use crate::machine::Machine;
use crate::nc::{Coordinates, without_machine_zero, zero_words};
use crate::plan::{Plan, PlannedTest, Settings};
use crate::report::wording::markup::escape;
use crate::units::Measure;

/// How a setup sheet begins: a plan writes over its own sheet alone.
pub const MARKER: &str = "<!doctype html><!-- planned by fiveaxis -->";

const STYLE: &str = include_str!("sheet.css");

/// The page of a plan.
pub fn setup_sheet(sheet: &Sheet) -> String {
    let mut out = String::new();
    let title = escape(&sheet.machine.name);
    let _ = write!(
        out,
        "{MARKER}<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Setup sheet, {title}</title>\
         <style>{STYLE}</style></head><body>"
    );
    overview(&mut out, sheet);
    for (index, planned) in sheet.plan.tests.iter().enumerate() {
        page(&mut out, sheet, index, planned);
    }
    out.push_str("</body></html>\n");
    out
}

/// The sheet of paper for the whole plan.
fn overview(out: &mut String, sheet: &Sheet) {
    let Sheet { machine, plan, kit, settings, .. } = sheet;
    let _ = write!(
        out,
        "<section class=\"first\"><h1>Setup sheet: {} <small>{}</small></h1><p class=\"lead\">{} in both directions, {}, about {:.0} minutes with mounting.</p>",
        escape(&machine.name),
        escape(&machine.code.to_string()),
        counted(plan.tests.len(), "test"),
        counted(plan.pivot_setups, "pivot setup"),
        plan.minutes
    );
    let mut rows: Vec<(&str, String)> = vec![("kit", parts_of(kit)), ("goal", goal(settings, plan))];
    rows.push((
        "made for",
        format!(
            "at least {} mm clear over runs and ways between, {} mm/min at the ball where ramps and blocks allow it",
            settings.margin_mm, settings.feed_mm_per_min
        ),
    ));
    if !settings.avoid.is_empty() {
        let avoided = settings.avoid.iter().map(|&(axis, from, to)| {
            let axis = &machine.axes[axis];
            format!("{} {} to {}", axis.name, axis.kind.to_file_unit(from), axis.kind.to_file_unit(to))
        });
        rows.push(("avoided", avoided.collect::<Vec<_>>().join(", ")));
    }
    rows.push(("readings", coordinates(machine)));
    let zero = zero_words(machine, sheet.bodies);
    if !zero.is_empty() {
        rows.push(("zero", format!("of the machine file, all axes at 0: {}", zero.join("; "))));
    }
    if let Some(directions) = machine.directions {
        rows.push(("sense of axes", format!("{directions}: {}", directions.meaning())));
    }
    if sheet.some_test_is_indexed() {
        rows.push(("spindle", INDEXING.into()));
    }
    if !machine.caveats.is_empty() {
        rows.push(("assumed", machine.caveats.join("; ")));
    }
    table(out, &rows);
    match plan.tests.is_empty() {
        true => out.push_str("<p class=\"lead\">No test can be run; the table says why.</p>"),
        false => {
            order(out, sheet);
            dry_run::dry_run(out, sheet);
            out.push_str(HOW_TO);
        }
    }
    trade_off::trade_off(out, plan, settings);
    determined(out, plan);
    out.push_str("</section>");
}

/// What must be in the case.
fn parts_of(kit: &Kit) -> String {
    let list = |lengths: &[f64]| lengths.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
    let mut words = format!("{}: {} mm bar", kit.name, kit.bar.length_mm);
    for (what, lengths) in [
        ("extensions", kit.bar.extensions_mm.as_slice()),
        ("fixture arms", kit.fixture.as_ref().map_or(&[], |fixture| fixture.arms_mm.as_slice())),
        ("calibrator", &kit.calibrator_mm),
    ] {
        if !lengths.is_empty() {
            let _ = write!(words, "; {what} {} mm", list(lengths));
        }
    }
    words
}

const INDEXING: &str = "some tests are run with the spindle at 0° and again at 180°. Orient the spindle (M19) and lock it before \
the spindle cup is mounted; mark this as 0°. Run the test at 0°, then turn the spindle by 180° with the cup and ball left in, \
lock it, and run the test that is called \u{201c}indexed\u{201d}. Turn back by 180° for the next test at 0°.";

const HOW_TO: &str = "<h2>Each test</h2><ol class=\"steps\"><li>Bring the axes to the park position by hand, in the order of the \
sheet's table from top to bottom. Mount pivot and spindle side there; leave the bar off.</li><li>Start the program: it goes to park one axis at a time, then the \
way to the start. Near the cups it stops before every leg and goes at feed: hand on the feed hold. At the start it stops.</li><li>Zero the bar on the calibrator, put it on, start the recording, start again: both directions run \
without a stop.</li><li>At the next stop end the recording and take the bar off; start again: the machine goes back to \
park.</li><li>Keep the recording in one piece, from before the start until after the stop. Do not cut it. Save it as NAME.csv, \
NAME as the sheet of the test says, beside session.yaml.</li><li>Type fiveaxis import NAME.csv --session session.yaml --out imported, with the \
files of all tests. It finds both directions and writes their recordings and a session, imported/session.yaml.</li></ol>";

fn goal(settings: &Settings, plan: &Plan) -> String {
    let goal = &settings.goal;
    let mut words = format!(
        "{} µm and {} arcsec (one standard deviation)",
        number(Measure::Length.to_output(goal.position_mm)),
        number(Measure::Angle.to_output(goal.orientation_rad))
    );
    if let Some(minutes) = goal.minutes {
        let _ = write!(words, ", the best in {minutes} minutes");
    }
    if let Some(method) = settings.method {
        let _ = write!(words, ", method of {}", format!("{method:?}").to_lowercase().replace("chapter", "chapter "));
    }
    if let Some(pivots) = settings.pivots {
        let _ = write!(words, ", at most {pivots} pivot setups");
    }
    words + if plan.goal_reached { ": reached" } else { ": not reached everywhere, see below" }
}

/// `1 test`, `5 tests`.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A number as short as it is: 4, not 4.0000000001.
fn number(value: f64) -> String {
    ((value * 1e6).round() / 1e6).to_string()
}

/// What the readings of this sheet count from.
fn coordinates(machine: &Machine) -> String {
    let stated = |axis: usize| Some(format!("{} {:.4}", machine.axes[axis].name, machine.machine_zero[axis]?));
    let zeros: Vec<String> = (0..machine.axes.len()).filter_map(stated).collect();
    let missing = without_machine_zero(machine);
    match Coordinates::of(machine) {
        Coordinates::Machine(_) => format!(
            "machine coordinates of the control; zero of the machine file at {}. The generic programs count from that zero: it must be the active work offset",
            zeros.join(", ")
        ),
        Coordinates::Work if missing.is_empty() => {
            "work coordinates with zero at the zero of the machine file: set the work offset so".into()
        }
        Coordinates::Work => format!(
            "work coordinates with zero at the zero of the machine file: machine_zero is stated for {} but not for {} and is not used",
            zeros.join(", "),
            missing.join(", ")
        ),
    }
}

/// The tests in the order in which they are run.
fn order(out: &mut String, sheet: &Sheet) {
    out.push_str(
        "<h2>Order</h2><table class=\"wide\"><tr><th></th><th>test</th><th>mount before it</th><th>moves</th><th>least clearance</th><th>min run</th></tr>",
    );
    let mut before: Option<&PlannedTest> = None;
    for (index, planned) in sheet.plan.tests.iter().enumerate() {
        let _ = write!(
            out,
            "<tr><td class=\"whole\"><span class=\"tick\"></span> {}</td><td class=\"whole\">{}</td><td>{}</td><td>{} {}° to {}°</td><td>{:.1} mm</td><td>{:.1}</td></tr>",
            index + 1,
            escape(&planned.test.name),
            escape(&mounting::changes(before, planned)),
            escape(&crate::report::words::what_moves(planned, sheet.machine)),
            planned.sweep.from_deg,
            planned.sweep.to_deg,
            planned.sweep.clearance_mm,
            planned.minutes,
        );
        before = Some(planned);
    }
    out.push_str("</table>");
}

/// The forecast.
fn determined(out: &mut String, plan: &Plan) {
    out.push_str("<h2>What the tests determine</h2><table class=\"wide\"><tr><th>error</th><th>1 sigma</th><th>relative to the spindle ball</th><th></th></tr>");
    for error in &plan.errors {
        let measure = if error.is_angle { Measure::Angle } else { Measure::Length };
        let _ = write!(
            out,
            "<tr><td>{}</td><td class=\"whole\">{:.2} {unit}</td><td>{:.2} {unit}</td><td>{}{}</td></tr>",
            error.name,
            measure.to_output(error.sigma),
            measure.to_output(error.sigma_relative),
            if error.determined { "" } else { "undetermined: " },
            escape(&error.reason),
            unit = measure.shown_unit(),
        );
    }
    out.push_str("</table>");
}

/// The sheet of paper for one test.
fn page(out: &mut String, sheet: &Sheet, index: usize, planned: &PlannedTest) {
    let before = index.checked_sub(1).map(|before| &sheet.plan.tests[before]);
    let _ = write!(
        out,
        "<section><h2>{} of {}: {}</h2><p class=\"ticks\">{}</p>",
        index + 1,
        sheet.plan.tests.len(),
        escape(&planned.test.name),
        ["mounted", "bar zeroed", "recorded in one piece", "imported"]
            .map(|what| format!("<span class=\"tick\"></span> {what}"))
            .join(" "),
    );
    let _ = write!(
        out,
        "<p class=\"lead\">Mount before this test: {}</p><div class=\"pair\"><div><h3>Mount</h3>",
        escape(&mounting::changes(before, planned))
    );
    table(out, &mounting::rows(sheet, planned));
    out.push_str("</div><div><h3>Run</h3>");
    table(out, &readings::rows(sheet, index, planned));
    out.push_str("</div></div>");
    readings::places(out, sheet, planned);
    if let Some(views) = sheet.pictures.get(index) {
        let bar_mm = planned.test.bar_length_mm.unwrap_or(0.0);
        out.push_str("<div class=\"pair\">");
        views.iter().for_each(|view| picture::picture(out, view, bar_mm, &planned.sweep.pair));
        out.push_str("</div>");
    }
    out.push_str("<p class=\"notes\">bar length found ____________ mm&emsp;temperature ________ °C&emsp;began at ________&emsp;remarks</p></section>");
}

/// Keys and values.
fn table(out: &mut String, rows: &[(&str, String)]) {
    out.push_str("<table>");
    for (key, value) in rows {
        let _ = write!(out, "<tr><th>{key}</th><td>{}</td></tr>", escape(value));
    }
    out.push_str("</table>");
}

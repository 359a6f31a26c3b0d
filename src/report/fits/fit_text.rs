//! A fit for a terminal: about a screenful, the rest is in JSON and in the HTML report.

use std::fmt::Write as _;

use super::fit::{FitJson, LocationErrorJson, TestJson};
use crate::identify::{Ambiguity, Fit};
use crate::report::wording::number::shown;
use crate::report::wording::sense_words::as_marks_show;
use crate::report::wording::table::Table;

/// More open errors than this are named in one line.
const OPEN_ROWS: usize = 8;
/// More ball and bar rows than this are left to JSON.
const SETUP_ROWS: usize = 12;
/// More facts of one remedy than this are told together.
const FACTS: usize = 5;
/// More tests than this are summed up.
const TESTS: usize = 30;
/// Width of wrapped lines.
const WIDTH: usize = 100;

/// The fit as text.
pub fn fit_text(json: &FitJson, fit: &Fit) -> String {
    let mut text = String::new();
    let left_out = match json.left_out {
        0 => String::new(),
        count => format!(" ({count} left out as gross outliers, {:.1} %)", 100.0 * json.left_out_share),
    };
    let _ = writeln!(text, "{} on {} {}", json.session, json.machine, json.code);
    let _ = writeln!(
        text,
        "{} tests, {} readings{left_out}; residual {:.2} µm rms, noise {:.2} µm",
        json.tests.len(),
        json.readings,
        json.rms_um,
        json.noise_um
    );
    if let Some(budget) = &json.linear_axes {
        let _ = writeln!(text, "{}", budget.says);
    }
    text.push('\n');
    misfit(&mut text, json);
    errors(&mut text, json, fit);
    open_directions(&mut text, &fit.ambiguities);
    control(&mut text, json);
    senses(&mut text, json);
    setups(&mut text, json);
    for warning in &json.warnings {
        text.push_str(&wrapped(warning, "  ! ", "    "));
    }
    tests(&mut text, &json.tests);
    text
}

/// Why nothing is determined, and which mistakes the recordings cannot tell apart.
fn misfit(text: &mut String, json: &FitJson) {
    let reasons = reasons(json);
    let Some((first, others)) = reasons.split_first() else { return };
    text.push_str(&wrapped(first, "", "  "));
    for other in others {
        text.push_str(&wrapped(other, "  or ", "     "));
    }
    if let Some(repeats_um) = json.repeats_um {
        let says =
            format!("residual {:.2} µm rms, where readings repeat to {repeats_um:.2} µm from row to row", json.rms_um);
        text.push_str(&wrapped(&says, "  ", "  "));
    }
    text.push('\n');
}

/// Why the fit is not to be believed, then which other mistakes say as much; none of a fit that is.
pub(crate) fn reasons(json: &FitJson) -> Vec<String> {
    let Some(reason) = &json.reason else { return Vec::new() };
    let lead = match json.verdict {
        "data fault" => "DATA FAULT, so nothing is determined: ",
        _ => "THE FIT IS NOT TO BE BELIEVED, so nothing is determined: ",
    };
    let sure =
        json.mistake.as_ref().map_or(String::new(), |mistake| format!(" ({:.0} %)", 100.0 * mistake.probability));
    let rivals = json.mistake.iter().flat_map(|mistake| &mistake.cannot_tell_from);
    let rivals = rivals.map(|rival| format!("{} ({:.0} %)", rival.says, 100.0 * rival.probability));
    std::iter::once(format!("{lead}{reason}{sure}")).chain(rivals).collect()
}

/// Verdict on one error.
pub(crate) fn verdict(json: &FitJson, error: &LocationErrorJson) -> &'static str {
    match (error.determined, error.relative_to_spindle_ball) {
        _ if json.verdict == "data fault" => "NOT determined: a mistake in the files",
        _ if json.verdict == "doubtful" => "NOT determined: see the warnings",
        _ if json.verdict != "fits" => "NOT determined: the model does not fit the recordings",
        (true, true) => "determined, relative to the spindle ball",
        (true, false) => "determined",
        (false, _) => "NOT determined by these recordings",
    }
}

/// `µm` or `arcsec`.
pub(crate) fn unit(error: &LocationErrorJson) -> &'static str {
    if error.unit == "um" { "µm" } else { error.unit }
}

fn errors(text: &mut String, json: &FitJson, fit: &Fit) {
    let names: Vec<&String> =
        fit.unknowns.iter().filter(|unknown| !unknown.quantity.is_setup()).map(|unknown| &unknown.label).collect();
    let open: Vec<&str> =
        names.iter().filter(|name| !json.location_errors[**name].determined).map(|name| name.as_str()).collect();
    let mut table =
        Table::new(&["error", "value", "± sigma", "unit", "to spindle ball", "noise alone", "from priors", "verdict"]);
    for name in names {
        let error = &json.location_errors[name];
        if open.len() > OPEN_ROWS && !error.determined {
            continue;
        }
        let (value, sigma) = shown(error.value, error.sigma);
        table.row(vec![
            name.clone(),
            value,
            sigma,
            unit(error).to_string(),
            format!("± {}", shown(0.0, error.sigma_to_spindle_ball).1),
            format!("± {}", shown(0.0, error.sigma_noise).1),
            format!("{:.0} %", 100.0 * error.prior_share),
            verdict(json, error).to_string(),
        ]);
    }
    text.push_str(&table.text());
    if open.len() > OPEN_ROWS {
        let says = format!("NOT determined by these recordings ({}): {}", open.len(), open.join(" "));
        text.push_str(&wrapped(&says, "  ", "  "));
    }
}

fn open_directions(text: &mut String, ambiguities: &[Ambiguity]) {
    if ambiguities.is_empty() {
        return;
    }
    text.push_str("\nThe recordings cannot tell apart:\n");
    for (remedy, facts) in by_remedy(ambiguities) {
        if facts.len() > FACTS {
            for fact in &facts[..2] {
                text.push_str(&wrapped(fact, "  • ", "    "));
            }
            let more = format!("{} more such combinations (--json lists them)", facts.len() - 2);
            text.push_str(&wrapped(&more, "  • ", "    "));
        } else {
            for fact in &facts {
                text.push_str(&wrapped(fact, "  • ", "    "));
            }
        }
        text.push_str(&wrapped(remedy, "    → ", "      "));
    }
}

/// Facts under the remedy that they share, in the order of appearance.
pub(crate) fn by_remedy(ambiguities: &[Ambiguity]) -> Vec<(&str, Vec<&str>)> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for ambiguity in ambiguities {
        match groups.iter_mut().find(|(remedy, _)| *remedy == ambiguity.remedy) {
            Some((_, facts)) => facts.push(&ambiguity.fact),
            None => groups.push((&ambiguity.remedy, vec![&ambiguity.fact])),
        }
    }
    groups
}

fn control(text: &mut String, json: &FitJson) {
    if let Some(why) = &json.control_withheld {
        text.push_str("\nNo numbers for the control:\n");
        text.push_str(&wrapped(why, "  ", "  "));
        return;
    }
    let known: Vec<&str> =
        json.control.iter().filter(|control| control.told).map(|control| control.says.as_str()).collect();
    if known.is_empty() {
        return;
    }
    text.push_str("\nFor the control (which parameter: docs/control.md):\n");
    for says in known {
        text.push_str(&wrapped(says, "  ", "     "));
    }
}

/// Senses that the recordings do not tell, or speak against: the numbers above stand and fall with them.
fn senses(text: &mut String, json: &FitJson) {
    if let Some(shown) = as_marks_show(&json.senses) {
        let _ = writeln!(text, "\n{shown}");
    }
    let untold: Vec<&str> =
        json.senses.iter().map(|sense| sense.says.as_str()).filter(|says| !says.is_empty()).collect();
    if untold.is_empty() {
        return;
    }
    text.push_str("\nAll this holds for the senses of the machine file:\n");
    for says in untold {
        text.push_str(&wrapped(says, "  ! ", "    "));
    }
}

fn setups(text: &mut String, json: &FitJson) {
    if json.setups.is_empty() || json.setups.len() > 3 * SETUP_ROWS {
        return;
    }
    text.push_str("\nBalls and bars, µm from where the session puts them:\n");
    let mut table = Table::new(&["setup", "x or length", "y", "z", "spread"]);
    for (name, values) in setup_rows(json) {
        let mut cells = vec![name];
        cells.extend(values.iter().map(|setup| {
            let (value, sigma) = shown(setup.value_um, setup.sigma_um);
            format!("{value} ± {sigma}")
        }));
        cells.resize(4, String::new());
        cells.push(format!("{}", values.first().map_or(0.0, |setup| (setup.spread_um * 1e6).round() / 1e6)));
        table.row(cells);
    }
    text.push_str(&table.text());
}

/// Coordinates of a ball together, by its name without the coordinate; bars alone.
pub(crate) fn setup_rows(json: &FitJson) -> Vec<(String, Vec<&super::fit::SetupJson>)> {
    let mut rows: Vec<(String, Vec<&super::fit::SetupJson>)> = Vec::new();
    for setup in &json.setups {
        let name = [", x", ", y", ", z"].iter().find_map(|end| setup.name.strip_suffix(end)).unwrap_or(&setup.name);
        match rows.iter_mut().find(|(other, _)| other == name) {
            Some((_, list)) => list.push(setup),
            None => rows.push((name.to_string(), vec![setup])),
        }
    }
    rows
}

fn tests(text: &mut String, tests: &[TestJson]) {
    text.push_str("\nResidual per test, µm rms:\n");
    let mut order: Vec<&TestJson> = tests.iter().collect();
    if tests.len() > TESTS {
        order.sort_by(|one, other| other.rms_um.total_cmp(&one.rms_um));
        let _ = writeln!(text, "  the {TESTS} largest of {}", tests.len());
        order.truncate(TESTS);
    }
    let items: Vec<String> = order
        .iter()
        .map(|test| {
            let out = match test.left_out.len() {
                0 => String::new(),
                count => format!(" ({count} out)"),
            };
            format!("{} {:.2}{out}", test.name, test.rms_um)
        })
        .collect();
    let widest = items.iter().map(|item| item.chars().count()).max().unwrap_or(0) + 2;
    let columns = ((WIDTH - 2) / widest).max(1);
    for row in items.chunks(columns) {
        let cells: Vec<String> = row.iter().map(|item| format!("{item:widest$}")).collect();
        let _ = writeln!(text, "  {}", cells.concat().trim_end());
    }
}

/// Words in lines of at most a hundred characters.
pub(crate) fn wrapped(words: &str, first: &str, rest: &str) -> String {
    let mut lines = String::new();
    let mut line = first.to_string();
    let mut is_empty = true;
    for word in words.split(' ') {
        if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            let _ = writeln!(lines, "{line}");
            line = rest.to_string();
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(word);
        is_empty = false;
    }
    let _ = writeln!(lines, "{line}");
    lines
}

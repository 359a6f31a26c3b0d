//! A diagnosis as one self-contained HTML page: no scripts, nothing to fetch, light and dark, fit for printing.

use std::fmt::Write as _;

use super::answers::answers;
use super::before_after::BeforeAfterPlots;
use super::chain_map::chain_map;
use super::diagnosis::{BlindJson, DiagnosisJson, FindingJson};
use super::diagnosis_text::{hanging, moved_words, verdict_words};
use super::finding_words::{
    cause_and_remedy, certainty_words, headline, next_words, range_words, rival_words, what, what_found,
};
use super::quantity_words::{tests_words, unit};
use super::unseen::{blind_words, cures, kinds_words, minutes_words};
use crate::diagnose::Diagnosis;
use crate::report::fits::fit_page::{circles_section, identifier};
use crate::report::pictures::cards::{Card, cards};
use crate::report::wording::markup::{escape, session_head};
use crate::report::wording::number;
use crate::session::Session;

const OWN_STYLE: &str = include_str!("diagnosis_page.css");
/// Tests drawn beside a finding.
const TESTS_SHOWN: usize = 2;
/// Shares listed.
const MOST_SHARES: usize = 12;

/// The page.
pub fn diagnosis_page(
    session: &Session,
    diagnosis: &Diagnosis,
    json: &DiagnosisJson,
    plots: &[BeforeAfterPlots],
) -> String {
    let (title, code) = (format!("Diagnosis of {}", session.name), session.machine.code.to_string());
    let machine = (session.machine.name.as_str(), code.as_str());
    let kind = if session.has_parts() { "Diagnosis" } else { "Ball-bar diagnosis" };
    let mut page = session_head(kind, &title, &session.name, machine, OWN_STYLE);
    let _ = writeln!(page, "<p class=\"verdict {}\">{}</p>", identifier(json.verdict), escape(&verdict_words(json)));
    answers(&mut page, session, json);
    for warning in &json.warnings {
        let _ = writeln!(page, "<p class=\"warning\">{}</p>", escape(warning));
    }
    figures(&mut page, json);
    let between = match session.has_parts() {
        true => "with what stands on it",
        false => "the bar stands between the pivot and the ball in the spindle",
    };
    let _ = write!(
        page,
        "<section>\n<h2>Where on the machine</h2>\n<figure class=\"map-figure\">\n{}<figcaption>Chain from workpiece to tool; {between}. Numbers are those \
         of the findings.</figcaption>\n</figure>\n</section>\n",
        chain_map(session, &json.findings)
    );
    for (index, finding) in json.findings.iter().enumerate() {
        section(&mut page, session, diagnosis, index, finding, plots);
    }
    // beside a mistake in the files nothing else is to be believed
    let is_believed = json.verdict != "data fault";
    if is_believed {
        shares(&mut page, json);
    }
    circles_section(&mut page, &json.circles);
    if is_believed {
        blind(&mut page, session, json);
        errors(&mut page, diagnosis, json);
    }
    tests(&mut page, diagnosis, plots);
    method(&mut page);
    let _ = write!(
        page,
        "<footer>fiveaxis {} · the numbers stand in <code>fiveaxis diagnose --json</code></footer>\n</main>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    );
    page
}

fn figures(page: &mut String, json: &DiagnosisJson) {
    let fit = &json.fit;
    let held_out = match (fit.heldout_before_um, fit.heldout_after_um) {
        (Some(before), Some(after)) => format!("{before:.2} → {after:.2} µm"),
        _ => "–".into(),
    };
    let shown = [
        Card {
            label: "residual before",
            figure: micrometres(fit.rms_before_um),
            note: "rms, location errors, balls and bars fitted".to_string(),
        },
        Card {
            label: "residual after",
            figure: micrometres(fit.rms_after_um),
            note: "rms, findings fitted with them".to_string(),
        },
        Card {
            label: "noise floor",
            figure: fit.noise_um.map_or("–".into(), |noise_um| format!("{noise_um:.2} µm")),
            note: "of one reading, whatever physics is missing".to_string(),
        },
        Card {
            label: "held-out readings",
            figure: held_out,
            note: "without and with findings from other readings".to_string(),
        },
    ];
    cards(page, &shown);
}

/// A residual, or a dash where nothing was fitted.
fn micrometres(value_um: f64) -> String {
    if value_um.is_finite() { format!("{value_um:.2} µm") } else { "–".into() }
}

fn section(
    page: &mut String,
    session: &Session,
    diagnosis: &Diagnosis,
    index: usize,
    finding: &FindingJson,
    plots: &[BeforeAfterPlots],
) {
    let _ = writeln!(
        page,
        "<section class=\"finding\">\n<h2 id=\"finding-{0}\"><span class=\"badge\">{0}</span> {1}</h2>\n<div class=\"pair\">\n<dl>",
        index + 1,
        escape(&headline(finding))
    );
    let found = diagnosis.findings.get(index);
    let range = finding.located.range.as_ref().map(|range| range_words(&session.machine, range)).unwrap_or_default();
    let (cause, remedy) = cause_and_remedy(finding);
    let next = finding.next_test.as_ref().map(next_words);
    let rows = [
        ("driven by", finding.driver.to_string()),
        ("components", finding.components.join(" ")),
        ("where", range),
        ("clearest in", tests_words(&finding.located.tests, 6)),
        ("shape", finding.shape.clone().unwrap_or_default()),
        ("how sure", certainty_words(finding)),
        ("usual cause", cause),
        ("what to do", remedy),
        ("next test", next.unwrap_or_default()),
    ];
    for (label, says) in rows.iter().filter(|(_, says)| !says.is_empty()) {
        let _ = writeln!(page, "<dt>{label}</dt><dd>{}</dd>", escape(says));
    }
    page.push_str("</dl>\n");
    evidence(page, finding, found.map(|found| found.gain));
    page.push_str("</div>\n<div class=\"tests\">\n");
    let mut shown: Vec<&BeforeAfterPlots> =
        finding.located.tests.iter().filter_map(|name| plots.iter().find(|plot| plot.test == *name)).collect();
    // a test in which the place can be pointed at says more than one in which it acts all along
    shown.sort_by_key(|plot| !plot.is_located);
    shown.truncate(TESTS_SHOWN);
    for (k, plot) in shown.iter().enumerate() {
        page.push_str("<figure>\n");
        // both directions of a pass stand in one picture
        let is_drawn = shown[..k].iter().any(|before| before.back.as_ref() == Some(&plot.test));
        if let Some(polar) = plot.polar.as_ref().filter(|_| !is_drawn) {
            page.push_str(polar);
        }
        page.push_str(&plot.unrolled);
        page.push_str("</figure>\n");
    }
    page.push_str("</div>\n</section>\n");
}

/// Probability of the finding and of what it cannot be told from, as bars.
fn evidence(page: &mut String, finding: &FindingJson, gain: Option<f64>) {
    page.push_str("<div class=\"evidence\">\n<h3>Evidence by candidate</h3>\n<table>\n");
    let lead = what_found(finding);
    let mut bar = |name: &str, probability: f64, class: &str| {
        let _ = writeln!(
            page,
            "<tr><td>{}</td><td><svg class=\"bar\" width=\"150\" height=\"12\" viewBox=\"0 0 150 12\" role=\"img\" aria-label=\"{:.0} %\">\
             <rect class=\"rest\" width=\"150\" height=\"12\"/><rect class=\"{class}\" width=\"{:.1}\" height=\"12\"/></svg></td><td class=\"n\">{:.1} %</td></tr>",
            escape(name),
            100.0 * probability,
            150.0 * probability.clamp(0.0, 1.0),
            100.0 * probability
        );
    };
    bar(&lead, finding.probability, "data");
    for rival in &finding.cannot_tell_from {
        let words = rival_words(rival);
        bar(words.rsplit_once(',').map_or(words.as_str(), |(name, _)| name), rival.probability, "prior");
    }
    page.push_str("</table>\n<p class=\"small\">Given the catalogue and these recordings. ");
    page.push_str(match finding.cannot_tell_from.len() {
        0 => "No other candidate comes within 1 : 50 of it.",
        _ => "The orange ones fit nearly as well: these recordings cannot tell them apart.",
    });
    if let Some(gain) = gain.filter(|gain| gain.is_finite()) {
        let _ = write!(page, " It raises the log likelihood by {gain:.0}.");
    }
    page.push_str("</p>\n</div>\n");
}

/// Causes ranked by what they add to the readings, as bars.
fn shares(page: &mut String, json: &DiagnosisJson) {
    if json.shares.is_empty() {
        return;
    }
    page.push_str(
        "<section>\n<h2>What the readings are made of</h2>\n<p class=\"small\">Root mean square of what each cause adds to the readings. \
         Parts may cancel each other: the bars rank them. What stands in one line the readings do not tell apart.</p>\n<div class=\"wide\"><table class=\"shares\">\n",
    );
    for share in json.shares.iter().take(MOST_SHARES) {
        let class = if share.kind == "finding" { "prior" } else { "data" };
        let _ = writeln!(
            page,
            "<tr><td>{}</td><td class=\"small\">{}</td><td><svg class=\"bar\" width=\"150\" height=\"12\" viewBox=\"0 0 150 12\" role=\"img\" aria-label=\"{:.0} %\">\
             <rect class=\"rest\" width=\"150\" height=\"12\"/><rect class=\"{class}\" width=\"{:.1}\" height=\"12\"/></svg></td><td class=\"n\">{:.2} µm</td><td class=\"n\">{:.1} %</td></tr>",
            escape(&share.name),
            share.kind,
            100.0 * share.share,
            150.0 * share.share.clamp(0.0, 1.0),
            share.rms_um,
            100.0 * share.share
        );
    }
    page.push_str("</table></div>\n</section>\n");
}

fn blind(page: &mut String, session: &Session, json: &DiagnosisJson) {
    if json.blind_to.is_empty() {
        return;
    }
    let _ = writeln!(
        page,
        "<section>\n<h2>What these tests cannot show</h2>\n<p class=\"small\">Not seen is not absent: {} causes may be there up to the sizes stated. What shows most of them comes first, after a look at the axes.</p>",
        json.blind_to.len()
    );
    for cure in cures(session, json) {
        let time = cure.minutes.map(|minutes| format!(", {}", minutes_words(minutes))).unwrap_or_default();
        let _ = writeln!(
            page,
            "<details class=\"blind\"><summary><b>{}</b> by: {}{time}<br><span class=\"small\">{}</span></summary>\n<ul>",
            cure.causes.len(),
            escape(&cure.says),
            escape(&kinds_words(&cure.causes))
        );
        for blind in &cure.causes {
            let _ = writeln!(page, "<li>{}</li>", escape(&blind_words(blind)));
        }
        page.push_str("</ul>\n</details>\n");
    }
    page.push_str("</section>\n");
}

fn errors(page: &mut String, diagnosis: &Diagnosis, json: &DiagnosisJson) {
    page.push_str(
        "<section>\n<h2>Location errors before and after</h2>\n<div class=\"wide\"><table>\n<thead><tr><th>error</th><th class=\"n\">before</th>\
         <th class=\"n\">after</th><th class=\"n\">σ</th><th>unit</th><th class=\"n\">change</th><th></th></tr></thead>\n<tbody>\n",
    );
    for moved in &diagnosis.location_errors {
        let json_moved = &json.location_errors[&moved.name];
        let text = |value: f64| number::shown(value, json_moved.sigma).0.replace('-', "−");
        let class = if json_moved.determined { "" } else { " class=\"open\"" };
        let _ = writeln!(
            page,
            "<tr{class}><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td></tr>",
            escape(&moved.name),
            text(json_moved.before),
            text(json_moved.after),
            number::shown(0.0, json_moved.sigma).1,
            unit(json_moved.unit),
            text(json_moved.after - json_moved.before),
            moved_words(diagnosis, moved)
        );
    }
    page.push_str("</tbody></table></div>\n");
    let hang = hanging(json, diagnosis.location_errors.iter().map(|moved| moved.name.as_str()));
    if !hang.is_empty() {
        let of = |(cause, errors): &(&BlindJson, Vec<&str>)| {
            format!("{}: {}", what(&cause.effect, &cause.place, &cause.components), errors.join(" "))
        };
        let all = escape(&hang.iter().map(of).collect::<Vec<_>>().join("; "));
        let _ = writeln!(page, "<p>σ holds what may be there unseen. {all}.</p>");
    }
    page.push_str("</section>\n");
}

fn tests(page: &mut String, diagnosis: &Diagnosis, plots: &[BeforeAfterPlots]) {
    page.push_str(
        "<section>\n<h2>Every test</h2>\n<div class=\"wide\"><table>\n<thead><tr><th>test</th><th class=\"n\">before, µm rms</th>\
         <th class=\"n\">after, µm rms</th><th class=\"n\">readings</th></tr></thead>\n<tbody>\n",
    );
    for test in &diagnosis.tests {
        let (before, after) = test.rms_um();
        let readings = test.kept.iter().filter(|kept| **kept).count();
        let _ = writeln!(
            page,
            "<tr><th scope=\"row\">{}</th><td class=\"n\">{before:.2}</td><td class=\"n\">{after:.2}</td><td class=\"n\">{readings}</td></tr>",
            escape(&test.name)
        );
    }
    page.push_str(
        "</tbody></table></div>\n<details>\n<summary>Residuals of every test</summary>\n<div class=\"tests\">\n",
    );
    for plot in plots {
        let _ = write!(page, "<figure id=\"test-{}\">\n{}</figure>\n", identifier(&plot.test), plot.unrolled);
    }
    page.push_str("</div>\n</details>\n</section>\n");
}

fn method(page: &mut String) {
    page.push_str(
        "<section>\n<h2>How it was found</h2>\n<p>Location errors, balls and bars are fitted first. What they leave is compared, reading by reading and \
         weighted by the noise, with the traces that each cause of a catalogue would leave at each place of the chain, after taking \
         out of those traces what location errors, balls and bars could imitate. A cause is accepted when the evidence demands it \
         against the cost of having looked at so many; then the question is asked again. Probabilities hold given the catalogue.</p>\n</section>\n",
    );
}

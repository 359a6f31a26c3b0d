//! The first screen of a diagnosis page: what is wrong, where, how sure, what to do, one row for each finding. It computes nothing.

use std::fmt::Write as _;

use super::diagnosis::{DiagnosisJson, FindingJson};
use super::finding_words::{cause_and_remedy, certainty_words, headline, next_words, range_words, rival_words};
use super::quantity_words::tests_words;
use super::unseen::{cures, minutes_words};
use crate::report::wording::markup::escape;
use crate::session::Session;

/// Findings and tests named in the table; the page has all.
const MOST_FINDINGS: usize = 5;
const MOST_TESTS: usize = 2;

/// One row: what, where, how sure, what to do.
type Answer = [String; 4];

/// Appends the table.
pub(super) fn answers(page: &mut String, session: &Session, json: &DiagnosisJson) {
    let mut rows: Vec<Answer> =
        json.findings.iter().take(MOST_FINDINGS).map(|finding| of_finding(session, finding)).collect();
    if rows.is_empty() {
        rows.push(of_nothing(session, json));
    }
    page.push_str(
        "<section class=\"wide answers\">\n<table>\n<thead><tr><th></th><th>what is wrong</th><th>where</th><th>how sure</th><th>what to do</th></tr></thead>\n<tbody>\n",
    );
    for (index, row) in rows.iter().enumerate() {
        let number = match json.findings.len() {
            0 => String::new(),
            _ => format!("<a class=\"badge\" href=\"#finding-{0}\">{0}</a>", index + 1),
        };
        let [what, place, sure, to_do] = row.each_ref().map(|text| escape(text));
        let _ = writeln!(
            page,
            "<tr><td>{number}</td><th scope=\"row\">{what}</th><td data-of=\"where\">{place}</td><td data-of=\"how sure\">{sure}</td><td data-of=\"what to do\">{to_do}</td></tr>"
        );
    }
    page.push_str("</tbody></table>\n");
    let more = json.findings.len().saturating_sub(MOST_FINDINGS);
    if more > 0 {
        let _ = writeln!(page, "<p class=\"small\">{more} smaller ones stand below.</p>");
    }
    page.push_str("</section>\n");
}

fn of_finding(session: &Session, finding: &FindingJson) -> Answer {
    let (_, remedy) = cause_and_remedy(finding);
    let range = finding.located.range.as_ref().map(|range| range_words(&session.machine, range));
    let tests = tests_words(&finding.located.tests, MOST_TESTS);
    let place = match range {
        Some(range) if !tests.is_empty() => format!("{range}; clearest in {tests}"),
        Some(range) => range,
        None => tests,
    };
    let mut sure = certainty_words(finding);
    if let Some(rival) = finding.cannot_tell_from.first() {
        let _ = write!(sure, "; next: {}", rival_words(rival));
    }
    let to_do = match &finding.next_test {
        // a test that settles it comes before a wrench
        Some(next) if finding.probability < 0.95 => format!("first {}; then {remedy}", next_words(next)),
        _ => remedy,
    };
    [headline(finding), place, sure, to_do]
}

/// Without a finding: what to do next is the test that would show most of what stays hidden.
fn of_nothing(session: &Session, json: &DiagnosisJson) -> Answer {
    let hidden = json.blind_to.len();
    // of equal ones the first, which is the shortest
    let next = cures(session, json).into_iter().rev().max_by_key(|cure| cure.causes.len()).map(|cure| {
        let time = cure.minutes.map(|minutes| format!(" ({})", minutes_words(minutes))).unwrap_or_default();
        format!("{}{time}: shows {} of the {hidden}", cure.says, cure.causes.len())
    });
    let place = "–".to_string();
    match json.verdict {
        "clean" => [
            "nothing that these tests can show".into(),
            place,
            format!("what is left is the gauge's noise; {hidden} causes could be there and would not show"),
            format!("use the location errors below; next, {}", next.unwrap_or_else(|| "nothing".into())),
        ],
        "cannot be judged" => [
            json.reason.clone().unwrap_or_default(),
            place,
            "nothing can be said of the machine".into(),
            "put right what is said and record again".into(),
        ],
        _ => [
            "something of a form that is not known".into(),
            place,
            "what is left is more than noise".into(),
            next.unwrap_or_else(|| "repeat the test with the largest residual".into()),
        ],
    }
}

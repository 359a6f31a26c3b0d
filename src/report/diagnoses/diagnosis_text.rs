//! A diagnosis as a story for the terminal, a screenful of at most a hundred columns. It computes no results.

use std::fmt::Write as _;

use super::diagnosis::{BlindJson, DiagnosisJson};
use super::finding_words::{cause_and_remedy, certainty_words, headline, next_words, range_words, rival_words};
use super::quantity_words::{tests_words, unit};
use super::unseen::{cures, kinds_words, minutes_words};
use crate::diagnose::{Diagnosis, MOVED_SIGMAS, Moved};
use crate::report::wording::number::shown;
use crate::report::wording::table::Table;
use crate::session::Session;

/// Columns of the story.
const WIDTH: usize = 100;
/// Columns before the text of a finding's line.
const INDENT: usize = 17;
/// Cures of what is unseen that are told.
const MOST_CURES: usize = 4;
/// Location errors listed.
const MOST_ERRORS: usize = 12;

/// The story.
pub fn diagnosis_text(session: &Session, diagnosis: &Diagnosis, json: &DiagnosisJson) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "{} on {} {}", session.name, session.machine.name, session.machine.code);
    paragraph(&mut text, "", 0, &verdict_words(json));
    for warning in &json.warnings {
        paragraph(&mut text, "  ! ", 4, warning);
    }
    for (index, finding) in json.findings.iter().enumerate() {
        let number = format!("\n{}. ", index + 1);
        paragraph(&mut text, &number, 3, &headline(finding));
        let mut place =
            finding.located.range.as_ref().map(|range| range_words(&session.machine, range)).unwrap_or_default();
        if !finding.located.tests.is_empty() {
            let lead = if place.is_empty() { "" } else { "; " };
            let _ = write!(place, "{lead}clearest in {}", tests_words(&finding.located.tests, 3));
        }
        line(&mut text, "where", &place);
        line(&mut text, "shape", finding.shape.as_deref().unwrap_or_default());
        line(&mut text, "how sure", &certainty_words(finding));
        let (cause, remedy) = cause_and_remedy(finding);
        line(&mut text, "usual cause", &cause);
        line(&mut text, "what to do", &remedy);
        let rivals: Vec<String> = finding.cannot_tell_from.iter().map(rival_words).collect();
        line(&mut text, "not told from", &rivals.join("; "));
        if let Some(next) = &finding.next_test {
            line(&mut text, "next test", &next_words(next));
        }
    }
    blind(&mut text, session, json);
    errors(&mut text, diagnosis, json);
    text
}

/// The verdict with its figures.
pub fn verdict_words(json: &DiagnosisJson) -> String {
    let fit = &json.fit;
    let open = json.findings.iter().filter(|finding| finding.probability < 0.5).count();
    let count = match (json.findings.len(), open) {
        (1, 0) => "one finding".to_string(),
        (1, _) => "one finding, whose cause stays open".to_string(),
        (count, 0) => format!("{count} findings"),
        (count, open) if open == count => format!("{count} findings, whose causes stay open"),
        (count, open) => format!("{count} findings, the cause of {open} open"),
    };
    let says = match json.verdict {
        "clean" if fit.noise_um.is_none() => format!(
            "NO FINDING in what these readings can show, where no pose has readings to spare: compare the {:.1} µm left with the \
             noise of the instrument",
            fit.rms_before_um
        ),
        "clean" => "NO FINDING in what these tests can show: location errors, balls and bars explain the recordings"
            .to_string(),
        "explained" => format!("EXPLAINED by {count}"),
        "partly explained" => format!("PARTLY EXPLAINED by {count}"),
        "unexplained" => "UNEXPLAINED: something is there, its form is unknown".to_string(),
        "cannot be judged" => {
            format!("THESE READINGS CANNOT BE JUDGED: {}", json.reason.as_deref().unwrap_or_default())
        }
        _ if is_fault_or_physics(json) => {
            "DATA FAULT, or what is named beside it: look which before anything is changed".to_string()
        }
        _ => "DATA FAULT: nothing else of these recordings is to be believed before it is put right".to_string(),
    };
    let held_out = match (fit.heldout_before_um, fit.heldout_after_um) {
        (Some(before), Some(after)) => format!("; held-out readings {before:.2} → {after:.2}"),
        _ => String::new(),
    };
    let residual = match json.verdict {
        _ if !fit.rms_before_um.is_finite() => "Nothing was fitted".to_string(),
        _ if fit.rms_before_um == fit.rms_after_um => format!("Residual {:.2} µm rms", fit.rms_before_um),
        "clean" => format!("Residual {:.2} µm rms", fit.rms_before_um),
        _ => format!("Residual {:.2} → {:.2} µm rms", fit.rms_before_um, fit.rms_after_um),
    };
    let noise = match fit.noise_um {
        Some(noise_um) => format!("; noise floor {noise_um:.2}"),
        None if ["clean", "data fault", "cannot be judged"].contains(&json.verdict) => String::new(),
        None => "; noise not known: no pose has readings to spare".to_string(),
    };
    format!("{says}. {residual}{held_out}{noise}{}.{}", outlier_words(json), left_words(json))
}

/// How many readings were left out.
fn outlier_words(json: &DiagnosisJson) -> String {
    match json.fit.readings {
        0 => String::new(),
        readings => format!(
            "; {} of {readings} readings ({:.1} %) left out as gross outliers",
            json.fit.left_out,
            100.0 * json.fit.left_out_share
        ),
    }
}

/// Whether an effect of the machine says as much as a mistake in the files.
fn is_fault_or_physics(json: &DiagnosisJson) -> bool {
    json.findings.iter().flat_map(|finding| &finding.cannot_tell_from).any(|rival| rival.driver != "data fault")
}

/// What stays unexplained of static poses, and of what kind it looks.
fn left_words(json: &DiagnosisJson) -> String {
    let Some(left) = &json.fit.left else { return String::new() };
    let kind = match left.arm_um > left.readings_um {
        true => "the balls of a pose share most of it: the arm itself stands elsewhere",
        false => "most of it is separate from ball to ball: the readings, or balls and bars",
    };
    format!(
        " Unexplained is {:.0} % of the mean square, {:.1} µm shared by the readings of a pose and {:.1} µm separate; {kind}.",
        100.0 * left.share,
        left.arm_um,
        left.readings_um
    )
}

/// What the tests cannot show, by the cure.
fn blind(text: &mut String, session: &Session, json: &DiagnosisJson) {
    if json.blind_to.is_empty() || json.verdict == "data fault" {
        return;
    }
    let count = json.blind_to.len();
    let _ = writeln!(
        text,
        "\nNot seen is not absent: {count} causes would not show here at sizes that matter (listed in --json).\nHow many of them would show by what:"
    );
    let cures = cures(session, json);
    for cure in cures.iter().take(MOST_CURES) {
        let time = cure.minutes.map(|minutes| format!(", {}", minutes_words(minutes))).unwrap_or_default();
        let lead = format!("  {:>3}  ", cure.causes.len());
        paragraph(text, &lead, lead.len(), &format!("{}{time}", cure.says));
        paragraph(text, &" ".repeat(lead.len() + 2), lead.len() + 2, &kinds_words(&cure.causes));
    }
    let left: usize = cures.iter().skip(MOST_CURES).map(|cure| cure.causes.len()).sum();
    if left > 0 {
        let _ = writeln!(text, "  {left:>3}  by {} further tests, all in --json", cures.len() - MOST_CURES);
    }
}

/// What became of a location error when the findings were modelled.
pub fn moved_words(diagnosis: &Diagnosis, moved: &Moved) -> &'static str {
    // where something is still unexplained nobody can say that a moved number is nearer to the truth
    match (moved.is_moved(), moved.determined && diagnosis.is_settled()) {
        (false, true) => "as before",
        (false, false) => "not determined",
        (true, _) if moved.is_within_unseen() => "moved, by less than unseen causes may do",
        (true, true) => "better: it had held part of a finding",
        (true, false) => "different, perhaps no better",
    }
}

fn errors(text: &mut String, diagnosis: &Diagnosis, json: &DiagnosisJson) {
    if !diagnosis.is_sound() || diagnosis.location_errors.is_empty() {
        return;
    }
    let all = diagnosis.location_errors.len();
    let moved = diagnosis.location_errors.iter().filter(|moved| moved.is_moved()).count();
    let heading = match (json.findings.is_empty(), moved) {
        (true, _) => "\nLocation errors".to_string(),
        (false, 0) => "\nLocation errors: none moved beyond its uncertainty".to_string(),
        (false, moved) => {
            format!("\nLocation errors: {moved} of {all} moved beyond {MOVED_SIGMAS} σ when the findings were modelled")
        }
    };
    let _ = writeln!(text, "{heading}");
    // what is neither determined nor moved has no number worth a line
    let still_open = |moved: &&Moved| !moved.determined && !moved.is_moved();
    let (open, mut told): (Vec<&Moved>, Vec<&Moved>) = diagnosis.location_errors.iter().partition(still_open);
    if !open.is_empty() {
        let list: Vec<&str> = open.iter().map(|moved| moved.name.as_str()).collect();
        paragraph(text, "  ", 4, &format!("not determined by these recordings: {}", list.join(" ")));
    }
    if told.is_empty() {
        return;
    }
    let count = told.len();
    if count > MOST_ERRORS {
        told.sort_by(|a, b| b.change_in_sigmas().total_cmp(&a.change_in_sigmas()));
        told.truncate(MOST_ERRORS);
    }
    let mut table = Table::new(&["error", "before", "after", "± σ", "unit", ""]);
    for &moved in &told {
        let in_units = &json.location_errors[&moved.name];
        let number = |value: f64| shown(value, in_units.sigma).0;
        table.row(vec![
            moved.name.clone(),
            number(in_units.before),
            number(in_units.after),
            shown(0.0, in_units.sigma).1,
            unit(in_units.unit).to_string(),
            moved_words(diagnosis, moved).to_string(),
        ]);
    }
    text.push_str(&table.text());
    if count > told.len() {
        let _ = writeln!(text, "  and {} that moved less, all in --json", count - told.len());
    }
    let hang = hanging(json, told.iter().map(|moved| moved.name.as_str()));
    if !hang.is_empty() {
        let causes: Vec<&BlindJson> = hang.iter().map(|(cause, _)| *cause).collect();
        paragraph(text, "  ", 4, &format!("± σ holds what may be there unseen: {}", kinds_words(&causes)));
    }
}

/// Unseen causes on which location errors hang, each with those errors; the ones that move most of them first.
pub fn hanging<'j>(
    json: &'j DiagnosisJson,
    names: impl Iterator<Item = &'j str>,
) -> Vec<(&'j BlindJson, Vec<&'j str>)> {
    let mut causes: Vec<(usize, Vec<&str>)> = Vec::new();
    for name in names {
        for one in &json.location_errors[name].hangs_on {
            match causes.iter_mut().find(|(known, _)| *known == one.blind_to) {
                Some((_, errors)) => errors.push(name),
                None => causes.push((one.blind_to, vec![name])),
            }
        }
    }
    causes.sort_by_key(|(_, errors)| std::cmp::Reverse(errors.len()));
    causes.into_iter().map(|(cause, errors)| (&json.blind_to[cause], errors)).collect()
}

fn line(text: &mut String, label: &str, says: &str) {
    if !says.is_empty() {
        paragraph(text, &format!("   {label:<width$}", width = INDENT - 3), INDENT, says);
    }
}

/// Text broken at the width, continued with an indent.
fn paragraph(text: &mut String, lead: &str, indent: usize, says: &str) {
    let mut line = lead.to_string();
    let mut length = lead.trim_start_matches('\n').chars().count();
    let mut first = true;
    for word in says.split_whitespace() {
        let count = word.chars().count();
        if !first && length + 1 + count > WIDTH {
            text.push_str(line.trim_end());
            text.push('\n');
            line = " ".repeat(indent);
            length = indent;
            first = true;
        }
        if !first {
            line.push(' ');
            length += 1;
        }
        line.push_str(word);
        length += count;
        first = false;
    }
    text.push_str(line.trim_end());
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_before_the_hundredth_column() {
        let mut text = String::new();
        paragraph(&mut text, "   where         ", 17, &"word µm ".repeat(60));
        assert!(text.lines().count() > 3);
        for line in text.lines().skip(1) {
            assert!(line.chars().count() <= WIDTH && line.starts_with(&" ".repeat(17)), "{line}");
        }
    }
}

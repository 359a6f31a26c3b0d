//! A finding in the words of the trade: headline, place, certainty. It reads the JSON contract and computes nothing.

pub use super::cause_title::{what, what_mistake};
use super::diagnosis::{FindingJson, NextTestJson, OtherSetupsJson, RangeJson, RivalJson, SizeJson};
use super::quantity_words::{digits, time_words, unit};
use crate::effects::{Signature, kind, signature};
use crate::machine::{AxisKind, Machine};

/// `10.2 ± 0.3 arcsec`, or that no size is known.
pub fn size_words(size: &SizeJson) -> String {
    let unit = unit(size.unit.unwrap_or_default());
    match (size.value, size.sigma) {
        (Some(value), Some(sigma)) => {
            format!("{} ± {} {unit}", digits(value, Some(sigma)), digits(sigma, Some(sigma)))
        }
        (Some(value), None) => format!("{} {unit}", digits(value, None)),
        _ => "size not known".into(),
    }
}

/// What the size measures, after the number: `to each side of every reversal`.
fn measures(effect: &str, meaning: &str) -> String {
    let is_of_parts = ["surest of", "rms of"].iter().any(|other| meaning.starts_with(other));
    let words = kind(effect).and_then(|kind| kind.measures).filter(|_| !is_of_parts);
    words.unwrap_or(meaning).into()
}

/// What was found, without its size: an effect of the machine or a mistake in the files.
pub fn what_found(finding: &FindingJson) -> String {
    match finding.fault {
        Some(kind) => what_mistake(kind, &finding.place, &finding.components),
        None => what(&finding.effect, &finding.place, &finding.components),
    }
}

/// One line that says what was found and how large it is.
pub fn headline(finding: &FindingJson) -> String {
    let mut what = what_found(finding);
    if let (Some(Signature::Play), Some(range)) = (signature(&finding.effect), &finding.located.range)
        && range.axis != finding.place
    {
        what = format!("{} tips as {} reverses ({})", finding.place, range.axis, finding.components.join(" "));
    }
    if finding.driver == "data fault" {
        return what;
    }
    format!("{what}: {} {}", size_words(&finding.size), measures(&finding.effect, &finding.size.meaning))
        .trim_end()
        .to_string()
}

/// Along which axis and from where to where.
pub fn range_words(machine: &Machine, range: &RangeJson) -> String {
    if range.axis == "time_s" {
        return format!("from {} to {} of the session", time_words(range.from), time_words(range.to));
    }
    let rotary = machine.axis_index(&range.axis).is_some_and(|axis| machine.axes[axis].kind == AxisKind::Rotary);
    let unit = if rotary { "°" } else { " mm" };
    let text = |value: f64| format!("{value:.0}").replace('-', "−");
    format!("{} from {}{unit} to {}{unit}", range.axis, text(range.from), text(range.to))
}

/// How sure a finding is.
pub fn certainty_words(finding: &FindingJson) -> String {
    let alone = finding.cannot_tell_from.is_empty();
    let can_repeat = matches!(finding.cross_validated, Some("passed" | "failed") | None);
    let mut words = match finding.probability {
        p if p >= 0.9 && alone && !can_repeat => "no other cause of the catalogue fits as well".to_string(),
        p if p >= 0.97 && alone => format!("no other cause of the catalogue fits ({:.0} %)", 100.0 * p),
        p if p >= 0.9 && alone => {
            format!("no other cause of the catalogue fits, but not all is proven ({:.0} %)", 100.0 * p)
        }
        p => format!("{:.0} % against the other causes of the catalogue", 100.0 * p),
    };
    words.push_str(match finding.cross_validated {
        Some("passed") => "; found again in held-out readings",
        Some("failed") => "; NOT confirmed by held-out readings",
        Some(_) => "; happened once, so no repeat can confirm it",
        None => "",
    });
    if let Some(other) = &finding.other_setups {
        // all of it and nothing of it are then not two sigma apart
        let is_open = other.sigma > 0.5;
        let says = match (is_open, other.carries) {
            (true, _) => "; these tests cannot say whether it is the same at other places of the balls".to_string(),
            (false, true) => format!("; it carries over{}", carried_words(other)),
            (false, false) => format!("; it does NOT carry over{}", carried_words(other)),
        };
        words.push_str(&says);
    }
    if let Some(placebo) = &finding.placebo {
        words.push_str(&format!(
            "; with the sense of motion drawn at random {:.0} % of its gain remain, {:.0} % at most",
            100.0 * placebo.mean,
            100.0 * placebo.largest
        ));
    }
    words
}

fn carried_words(other: &OtherSetupsJson) -> String {
    format!(
        " between {} places of the balls: each shows {:.2} ± {:.2} of what the others predict",
        other.setups, other.slope, other.sigma
    )
}

/// The next test, and what it would make of the finding.
pub fn next_words(next: &NextTestJson) -> String {
    let sure = match 100.0 * next.odds_after {
        percent if percent >= 99.0 => "over 99 %".to_string(),
        percent => format!("{percent:.0} %"),
    };
    format!("{}; {sure} if it shows the same again", next.says)
}

/// A rival as a phrase.
pub fn rival_words(rival: &RivalJson) -> String {
    if let Some(says) = &rival.says {
        return format!("{says}, {:.0} %", 100.0 * rival.probability);
    }
    let mut what = what(&rival.effect, &rival.place, &rival.components);
    if !what.contains('(') && !rival.components.is_empty() {
        what.push_str(&format!(" ({})", rival.components.join(" ")));
    }
    format!("{what}, {:.0} %", 100.0 * rival.probability)
}

/// Usual cause and what to do; for data faults what the check says.
pub fn cause_and_remedy(finding: &FindingJson) -> (String, String) {
    if finding.driver == "data fault" {
        let is_one = finding.cannot_tell_from.iter().all(|rival| rival.driver == "data fault");
        let (cause, first) = match is_one {
            true => ("the way in which the file was written, no physics", ""),
            false => {
                ("the way in which the file was written", "record those tests once more; if they come out so again, ")
            }
        };
        return (cause.into(), format!("{first}{}", finding.size.meaning));
    }
    kind(&finding.effect).map_or_else(Default::default, |kind| (kind.cause.to_string(), kind.remedy.to_string()))
}

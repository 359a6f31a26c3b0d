//! XML of a gauge: lists of numbers in elements or attributes. Tables are in `table`.

use std::path::Path;

use super::names::{Meaning, READINGS, meaning, plain_name};
use super::numbers::reading;
use super::raw::Raw;
use super::sampling::{Sampling, TIME_UNITS, time_unit_s};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::printable::{LONGEST_SHOWN, shortened};
use crate::load::moment::is_of_other;

/// Fewest numbers of a list of readings in XML.
const LEAST_OF_A_SERIES: usize = 30;
/// Most open elements of XML among which the one is looked for that an end tag closes.
const MOST_OPEN: usize = 1000;

/// A leaf of an XML text, or an attribute.
struct Leaf<'a> {
    name: &'a str,
    tag: &'a str,
    content: &'a str,
    /// Tag of the element around it.
    parent: &'a str,
    /// Whether an element around it, but the outermost, is about something else than the recording.
    is_of_other: bool,
    /// An attribute of an element that has a content of its own, which it is about.
    is_of_content: bool,
}

/// Leaves of an XML text, attributes among them. Elements that are not closed do no harm.
fn leaves(text: &str) -> Vec<Leaf<'_>> {
    let mut leaves = Vec::new();
    // open elements with their tags, and whether one up to there is about something else
    let mut open: Vec<(&str, &str, bool)> = Vec::new();
    let mut rest = text;
    while let Some(begin) = rest.find('<') {
        rest = &rest[begin + 1..];
        let Some(end) = rest.find('>') else { break };
        let (tag, after) = (&rest[..end], &rest[end + 1..]);
        let name = tag.trim_start_matches('/').split(|c: char| c.is_whitespace() || c == '/').next().unwrap_or(tag);
        if tag.starts_with('/') {
            // an end that fits none is passed over
            let at = open.iter().rev().take(MOST_OPEN).position(|(known, ..)| *known == name);
            open.truncate(at.map_or(open.len(), |at| open.len() - 1 - at));
        } else if !tag.starts_with(['?', '!']) {
            let (parent, around) = open.last().map_or(("", false), |(_, tag, is_of_other)| (*tag, *is_of_other));
            let own = around || !open.is_empty() && is_of_other(name);
            let content = after.find('<').map_or(after, |next| &after[..next]);
            let is_leaf = !tag.ends_with('/') && after[content.len()..].starts_with(&format!("</{name}"));
            let attribute = |(own_name, content)| Leaf {
                name: own_name,
                tag: name,
                content,
                parent,
                is_of_other: own,
                is_of_content: is_leaf,
            };
            leaves.extend(attributes(&tag[name.len()..]).into_iter().map(attribute));
            if is_leaf {
                leaves.push(Leaf {
                    name,
                    tag,
                    content: content.trim(),
                    parent,
                    is_of_other: around,
                    is_of_content: false,
                });
            }
            if !tag.ends_with('/') {
                open.push((name, tag, own));
            }
        }
        rest = after;
    }
    leaves
}

/// Attributes of a tag behind its name: `t="0.1" v='2'`.
fn attributes(tag: &str) -> Vec<(&str, &str)> {
    let mut found = Vec::new();
    let mut rest = tag;
    while let Some((name, after)) = rest.split_once('=') {
        let after = after.trim_start();
        let Some(quote) = after.chars().next().filter(|quote| matches!(quote, '"' | '\'')) else { break };
        let Some((value, behind)) = after[1..].split_once(quote) else { break };
        found.push((name.trim(), value.trim()));
        rest = behind;
    }
    found
}

pub(super) fn from_xml(file: &Path, text: &str) -> Result<Raw, LoadError> {
    // a list in one element, or one number in each of many
    let mut series: Vec<Series> = Vec::new();
    let mut raw = Raw { is_xml: true, ..Raw::default() };
    let mut unit = String::new();
    // how certain it is, and readings a second
    let mut rate: Option<(u8, f64)> = None;
    for leaf in leaves(text) {
        let Leaf { name, tag, content, parent, is_of_other, is_of_content } = leaf;
        let words = content.split(|c: char| c.is_whitespace() || c == ';' || c == ',').filter(|word| !word.is_empty());
        // where there is no reading stands NaN
        let numbers: Option<Vec<f64>> = words.map(reading).collect();
        let element = tag.split_whitespace().next().unwrap_or_default();
        let is_unit = plain_name(name).contains("unit");
        match (numbers, Sampling::of(name)) {
            (Some(numbers), Some(sampling)) if numbers.len() == 1 && numbers[0] > 0.0 => {
                // the first of the most certain ones holds; what is within a calibration comes last
                let certainty = if is_of_other { 0 } else { 1 + u8::from(sampling.is_certain) };
                if rate.is_none_or(|(known, _)| certainty > known) {
                    rate = Some((certainty, rate_hz(file, &leaf, sampling, numbers[0])?));
                }
            }
            (Some(numbers), _) if !numbers.is_empty() => match series.iter_mut().find(|known| known.name == name) {
                Some(known) => known.numbers.extend(numbers),
                None => series.push(Series { name, tag, parent, numbers }),
            },
            // the unit of another content is none of the readings
            _ if is_unit && is_of_content => {}
            _ if is_unit => unit = plain_name(content),
            _ if !is_of_other && raw.began.take(&format!("{element} {name}"), content) => {}
            _ => raw.not_read.push(name.to_string()),
        }
    }
    raw.rate_hz = rate.map(|(_, rate_hz)| rate_hz);
    with_series(file, raw, series, &unit)
}

/// Readings a second that a leaf states.
fn rate_hz(file: &Path, leaf: &Leaf<'_>, sampling: Sampling, value: f64) -> Result<f64, LoadError> {
    let unit = unit_of(leaf.tag);
    sampling.rate_hz(value, unit).map_err(|allowed| unknown_unit(file, leaf.name, unit.unwrap_or_default(), allowed))
}

/// The unit that a tag states as an attribute.
fn unit_of(tag: &str) -> Option<&str> {
    attributes(tag).into_iter().find(|(name, _)| plain_name(name).contains("unit")).map(|(_, unit)| unit)
}

fn unknown_unit(file: &Path, name: &str, unit: &str, allowed: &str) -> LoadError {
    let (name, unit) = (shortened(name, LONGEST_SHOWN), shortened(unit, LONGEST_SHOWN));
    LoadError::file(
        file,
        format!("{name}: unit '{unit}' is not known; allowed are {allowed}; correct it or say --rate"),
    )
}

/// Numbers under one name, with the tag of the first and of the element around it.
struct Series<'a> {
    name: &'a str,
    tag: &'a str,
    parent: &'a str,
    numbers: Vec<f64>,
}

/// The readings, and the times if there are any, among lists of numbers; what the others are named.
fn with_series(file: &Path, mut raw: Raw, mut series: Vec<Series<'_>>, unit: &str) -> Result<Raw, LoadError> {
    let is_time = |name: &str| matches!(meaning(name), Meaning::Time(_));
    let named =
        |name: &str| u8::from(plain_name(name).split('_').any(|word| READINGS.iter().any(|r| word.starts_with(r))));
    let best = (0..series.len())
        .filter(|&k| series[k].numbers.len() >= LEAST_OF_A_SERIES && !is_time(series[k].name))
        .max_by_key(|&k| (named(series[k].name), series[k].numbers.len()));
    let Some(best) = best else {
        let names: Vec<&str> = series.iter().map(|one| one.name).collect();
        return Err(LoadError::file(
            file,
            format!(
                "is XML without a list of at least {LEAST_OF_A_SERIES} readings (numbers found in: {}); export the readings as a table with time_s and deviation_um",
                if names.is_empty() { "none".into() } else { names.join(" ") }
            ),
        ));
    };
    let Series { name, tag, parent, numbers: readings } = series.swap_remove(best);
    // the name's own unit, that of the element, of the one around it, or of all
    let units = [Some(name), unit_of(tag), Some(tag), unit_of(parent), Some(unit)];
    raw.column = units.into_iter().flatten().find_map(|unit| match meaning(&format!("deviation_{name}_{unit}")) {
        Meaning::Readings(column) => column,
        _ => None,
    });
    if let Some(time) = series.iter().position(|one| is_time(one.name) && one.numbers.len() == readings.len()) {
        let Series { name, tag, numbers: times, .. } = series.swap_remove(time);
        if let Some(at) = times.iter().position(|time| !time.is_finite()) {
            return Err(LoadError::file(
                file,
                format!(
                    "{}: time {} of {} is no number; correct it",
                    shortened(name, LONGEST_SHOWN),
                    at + 1,
                    times.len()
                ),
            ));
        }
        let unit_s = match (unit_of(tag), meaning(name)) {
            (Some(unit), _) => {
                time_unit_s(&plain_name(unit)).ok_or_else(|| unknown_unit(file, name, unit, TIME_UNITS))?
            }
            (None, Meaning::Time(unit_s)) => unit_s,
            _ => 1.0,
        };
        raw.time = Some((times, unit_s));
        raw.rate_hz = None;
    }
    raw.not_read.extend(series.iter().map(|one| match one.numbers.len() {
        // another run, or a channel beside the readings
        count if count >= LEAST_OF_A_SERIES => format!("{} ({count} numbers)", one.name),
        _ => one.name.to_string(),
    }));
    raw.not_read.sort();
    raw.not_read.dedup();
    (raw.name, raw.readings) = (name.to_string(), readings);
    Ok(raw)
}

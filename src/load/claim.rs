//! Files of stated results (YAML, see docs/formats.md) with the session that is their design, to a [`Claim`].

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::limits::YAML_BYTES;
use crate::load::checked_text::message::{LoadError, did_you_mean};
use crate::load::checked_text::quantity::quantity;
use crate::load::checked_text::text::read_limited;
use crate::load::session_file::session::load_session;
use crate::machine::ErrorName;
use crate::session::{Claim, ClaimedValue, Reduction};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ClaimFile {
    name: Option<String>,
    session: String,
    method: String,
    errors: BTreeMap<String, ErrorFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ErrorFile {
    value: serde_yaml::Value,
    deviation: serde_yaml::Value,
}

/// Reads a file of results and the session that it names.
pub fn load_claim(file: &Path) -> Result<Claim, LoadError> {
    let document = Document::parse(file, read_limited(file, YAML_BYTES)?)?;
    let raw: ClaimFile = document.read()?;
    let reduction = reduction(&document, &raw.method)?;
    let session = load_session(&file.parent().unwrap_or(Path::new("")).join(&raw.session))?;
    if raw.errors.is_empty() {
        return Err(document.refuse(
            &[Step::Key("errors")],
            "states no error; add lines such as EX0C: {value: 1.3 um, deviation: 0.2 um}",
        ));
    }
    let mut values: Vec<ClaimedValue> = Vec::new();
    for (key, error) in &raw.errors {
        let place = [Step::Key("errors"), Step::Key(key)];
        let name = ErrorName::parse(key, &session.machine.axis_names())
            .map_err(|refusal| document.refuse(&place, refusal.to_string()))?;
        if !name.is_location {
            return Err(document.refuse(
                &place,
                format!("{name} is a component error; results compared are location errors such as EX0C"),
            ));
        }
        if values.iter().any(|value| value.name == name) {
            return Err(document.refuse(&place, format!("{name} stands twice; each error stands once")));
        }
        let of = |key: &'static str, text: &serde_yaml::Value| {
            let place = [place[0], place[1], Step::Key(key)];
            quantity(&document, &place, text, name.component.measure())
        };
        let (value, deviation) = (of("value", &error.value)?, of("deviation", &error.deviation)?);
        if deviation < 0.0 {
            let place = [place[0], place[1], Step::Key("deviation")];
            return Err(document.refuse(&place, "a standard deviation is zero or more"));
        }
        values.push(ClaimedValue { name, value, deviation });
    }
    let name = raw.name.unwrap_or_else(|| session.name.clone());
    Ok(Claim { name, session, reduction, values })
}

fn reduction(document: &Document, method: &str) -> Result<Reduction, LoadError> {
    let names = Reduction::ALL.map(|(name, _)| name);
    let known = Reduction::ALL.iter().find(|(name, _)| *name == method);
    known.map(|(_, reduction)| *reduction).ok_or_else(|| {
        let hint = did_you_mean(method, &names);
        document
            .refuse(&[Step::Key("method")], format!("unknown method '{method}'{hint} (allowed: {})", names.join(", ")))
    })
}

//! Machine files (YAML, see docs/formats.md) to a [`Machine`]; URDF has its own reader.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use super::axis::{AxisFile, axis};
use super::carried::{CarriedFile, carried};
use super::effects::effects;
use super::linear_axes::linear_axes;
use super::spindle::{SpindleFile, spindle};
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::limits::{AXES, LINKS, YAML_BYTES};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::quantity::{finite, unit_vector};
use crate::load::checked_text::text::read_limited;
use crate::load::urdf::{LinkChoice, machine_from_urdf};
use crate::machine::{Directions, Machine, StructuralCode};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MachineFile {
    name: String,
    code: Option<serde_yaml::Value>,
    chain: Option<Vec<String>>,
    directions: Option<String>,
    axes: BTreeMap<String, AxisFile>,
    gravity: Option<[f64; 3]>,
    #[serde(default)]
    machine_zero: BTreeMap<String, f64>,
    gauge_length: Option<f64>,
    #[serde(default)]
    links: Vec<LinkFile>,
    #[serde(default)]
    carried: Vec<CarriedFile>,
    #[serde(default)]
    effects: Vec<serde_yaml::Mapping>,
    linear_axes: Option<serde_yaml::Value>,
    #[serde(default)]
    caveats: Vec<String>,
    // solids are the business of the reader in `bodies`
    #[serde(rename = "bodies")]
    _bodies: Option<serde::de::IgnoredAny>,
    #[serde(rename = "mounts")]
    _mounts: Option<serde::de::IgnoredAny>,
    spindle: Option<SpindleFile>,
    #[serde(rename = "touching")]
    _touching: Option<serde::de::IgnoredAny>,
}

/// A further name of a link: places of robots are known by the names of their links.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LinkFile {
    name: String,
    carried_by: String,
}

/// Reads a machine file, YAML or URDF; links of a URDF are found by name.
pub fn load_machine(file: &Path) -> Result<Machine, LoadError> {
    load_machine_with_links(file, &LinkChoice::default())
}

/// Reads a machine file; `links` names the bed, workpiece and tool of a URDF.
pub fn load_machine_with_links(file: &Path, links: &LinkChoice) -> Result<Machine, LoadError> {
    let text = read_limited(file, YAML_BYTES)?;
    if is_urdf(file, &text) {
        return machine_from_urdf(file, &text, links);
    }
    if !links.is_empty() {
        return Err(LoadError::file(
            file,
            "is no URDF; root, workpiece and tool links are named for URDF only, a machine file has them in its code",
        ));
    }
    machine_from_yaml(file, text)
}

/// True for robot descriptions, by the file's name or its first character.
pub(crate) fn is_urdf(file: &Path, text: &str) -> bool {
    let is_named_so = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("urdf"));
    is_named_so || text.trim_start().starts_with('<')
}

/// Reads the text of a machine file; `file` is its name in messages.
pub fn machine_from_yaml(file: &Path, text: String) -> Result<Machine, LoadError> {
    let document = Document::parse(file, text)?;
    let raw: MachineFile = document.read()?;
    let code = structural_code(&document, &raw)?;
    let directions = raw.directions.as_deref().map(|word| directions(&document, word)).transpose()?;
    let names: Vec<String> = code.axis_names().cloned().collect();
    if let Some(message) = AXES.exceeded(names.len()) {
        return Err(document.refuse(&[Step::Key("chain")], message));
    }
    for name in raw.axes.keys() {
        if !names.contains(name) {
            return Err(document.refuse(
                &[Step::Key("axes"), Step::Key(name)],
                format!("axis '{name}' does not stand in the code {code}; its axes are {}", names.join(" ")),
            ));
        }
    }
    let all: Vec<&str> = names.iter().map(String::as_str).collect();
    let unstated = AxisFile::default();
    let axes = names
        .iter()
        .map(|name| axis(&document, raw.axes.get(name).unwrap_or(&unstated), name, &all))
        .collect::<Result<Vec<_>, _>>()?;
    let gravity = unit_vector(&document, &[Step::Key("gravity")], "gravity", raw.gravity.unwrap_or([0.0, 0.0, -1.0]))?;
    let mut machine_zero = vec![None; axes.len()];
    for (name, value) in &raw.machine_zero {
        let place = [Step::Key("machine_zero"), Step::Key(name)];
        let index = names.iter().position(|other| other == name).ok_or_else(|| {
            document.refuse(
                &place,
                format!(
                    "machine_zero names the axis '{name}', which the machine has not; its axes are {}",
                    names.join(" ")
                ),
            )
        })?;
        machine_zero[index] = Some(finite(&document, &place, *value)?);
    }
    let gauge_length_mm =
        raw.gauge_length.map(|value| finite(&document, &[Step::Key("gauge_length")], value)).transpose()?;
    let link_names = link_names(&document, &raw.links, &names)?;
    let carried = carried(&document, &raw.carried, &names, &link_names)?;
    let mut machine = Machine {
        name: raw.name,
        code,
        directions,
        axes,
        gravity,
        machine_zero,
        gauge_length_mm,
        spindle: None,
        link_names,
        carried,
        effects: Vec::new(),
        linear_axes: linear_axes(&document, raw.linear_axes.as_ref())?,
        caveats: caveats(&document, raw.caveats)?,
    };
    machine.spindle = raw.spindle.as_ref().map(|raw| spindle(&document, &machine, raw)).transpose()?;
    machine.effects = effects(&document, &machine, &raw.effects)?;
    Ok(machine)
}

/// Longest caveat, characters: one comment line of a program.
const LONGEST_CAVEAT: usize = 160;
/// Most caveats of a machine: they stand at the head of every program.
const MOST_CAVEATS: usize = 12;

/// What the file holds to be assumed.
fn caveats(document: &Document, caveats: Vec<String>) -> Result<Vec<String>, LoadError> {
    if caveats.len() > MOST_CAVEATS {
        let found = format!("{} caveats; at most {MOST_CAVEATS} are allowed, join some", caveats.len());
        return Err(document.refuse(&[Step::Key("caveats")], found));
    }
    for (index, caveat) in caveats.iter().enumerate() {
        let length = caveat.chars().count();
        if length == 0 || length > LONGEST_CAVEAT || caveat.chars().any(char::is_control) {
            let found = format!(
                "a caveat has 1 to {LONGEST_CAVEAT} characters on one line, this one has {length}; cut it into several"
            );
            return Err(document.refuse(&[Step::Key("caveats"), Step::Index(index)], found));
        }
    }
    Ok(caveats)
}

/// The sense of the axes.
fn directions(document: &Document, word: &str) -> Result<Directions, LoadError> {
    Directions::named(word).ok_or_else(|| {
        let allowed = "iso841 (a positive command moves the tool in the positive sense relative to the workpiece) or \
                       carried (it moves the carried part right-handed)";
        document.refuse(&[Step::Key("directions")], format!("directions '{word}' are not known; allowed are {allowed}"))
    })
}

/// Further link names, each with the index of the axis that carries it.
fn link_names(
    document: &Document,
    links: &[LinkFile],
    axes: &[String],
) -> Result<Vec<(String, Option<usize>)>, LoadError> {
    if let Some(message) = LINKS.exceeded(links.len()) {
        return Err(document.refuse(&[Step::Key("links")], message));
    }
    let mut found: Vec<(String, Option<usize>)> = Vec::with_capacity(links.len());
    for (index, link) in links.iter().enumerate() {
        let place = [Step::Key("links"), Step::Index(index)];
        let is_taken = ["b", "w", "t"].contains(&link.name.as_str())
            || axes.contains(&link.name)
            || found.iter().any(|(name, _)| *name == link.name);
        if is_taken {
            return Err(document.refuse(
                &place,
                format!("link name '{}' is taken; each link has a name of its own, not b, w, t or an axis", link.name),
            ));
        }
        let carrier = axes.iter().position(|name| *name == link.carried_by);
        if carrier.is_none() && link.carried_by != "b" {
            let allowed = axes.join(" ");
            return Err(document.refuse(
                &place,
                format!("link '{}' is carried_by '{}'; allowed are b and {allowed}", link.name, link.carried_by),
            ));
        }
        found.push((link.name.clone(), carrier));
    }
    Ok(found)
}

/// A code as written: without quotes YAML reads the brackets as a list of one text.
fn code_text(code: &serde_yaml::Value) -> Option<&str> {
    match code.as_sequence().map(Vec::as_slice) {
        Some([only]) => only.as_str(),
        Some(_) => None,
        None => code.as_str(),
    }
}

fn structural_code(document: &Document, raw: &MachineFile) -> Result<StructuralCode, LoadError> {
    match (&raw.code, &raw.chain) {
        (Some(code), None) => {
            let refuse = |message: String| document.refuse(&[Step::Key("code")], message);
            let text = code_text(code)
                .ok_or_else(|| refuse("code is no text; write for example code: \"[wCAYbXZt]\"".to_string()))?;
            StructuralCode::parse(text).map_err(|why| refuse(why.to_string()))
        }
        (None, Some(chain)) => {
            // workpiece, bed and tool are no axes
            if let Some(message) = AXES.exceeded(chain.len().saturating_sub(3)) {
                return Err(document.refuse(&[Step::Key("chain")], message));
            }
            let words: Vec<&str> = chain.iter().map(String::as_str).collect();
            StructuralCode::from_words(&words)
                .map_err(|(index, reason)| document.refuse(&[Step::Key("chain"), Step::Index(index)], reason))
        }
        (Some(_), Some(_)) => {
            Err(document.refuse(&[Step::Key("chain")], "both 'code' and 'chain' are given; keep one"))
        }
        (None, None) => Err(document.refuse(
            &[Step::Key("name")],
            "neither 'code' nor 'chain' is given; write for example code: \"[wCAYbXZt]\"",
        )),
    }
}

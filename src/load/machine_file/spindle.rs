//! The spindle of a machine file. What it may carry is in `bodies`.

use nalgebra::Vector3;
use serde::Deserialize;

use crate::chain::{Branch, Chain, LinkId};
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::quantity::{point, unit_vector};
use crate::load::links::known_link;
use crate::machine::{Machine, SpindleSide};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpindleFile {
    link: Option<String>,
    nose: [f64; 3],
    direction: Option<[f64; 3]>,
}

/// Where tools are clamped; without a gauge length the spindle ball is at R's origin.
pub(crate) fn spindle(document: &Document, machine: &Machine, raw: &SpindleFile) -> Result<SpindleSide, LoadError> {
    let at = |key| [Step::Key("spindle"), Step::Key(key)];
    let link = raw.link.clone().unwrap_or_else(|| "t".into());
    let chain = Chain::of(machine);
    known_link(document, &chain, &at("link"), &link)?;
    let carries_workpiece = |id: LinkId| id.branch == Branch::Workpiece && id != LinkId::BED;
    if link == "w" || chain.link(&link).is_some_and(carries_workpiece) {
        let mut on_tool_side = vec!["t", "b"];
        on_tool_side.extend(chain.branch(Branch::Tool).iter().map(|&axis| machine.axes[axis].name.as_str()));
        let allowed = on_tool_side.join(" ");
        let found = format!("link '{link}' carries the workpiece; the spindle is on the tool side (links: {allowed})");
        return Err(document.refuse(&at("link"), found));
    }
    let nose = point(document, &at("nose"), &raw.nose)?;
    let direction = match raw.direction {
        Some(direction) => unit_vector(document, &at("direction"), "direction", direction)?,
        None => Vector3::z(),
    };
    let gauge_length_mm = machine.gauge_length_mm.unwrap_or_else(|| nose.dot(&direction));
    if !(gauge_length_mm.is_finite() && gauge_length_mm > 0.0) {
        return Err(document.refuse(&at("nose"), "the nose lies behind the spindle ball; gauge_length is above zero"));
    }
    Ok(SpindleSide { link, nose, direction, gauge_length_mm })
}

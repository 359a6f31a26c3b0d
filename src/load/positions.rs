//! Axis positions as typed on a command line, `A=30,C=-45`, for a given machine. Recordings are read in `recording`.

use crate::machine::Machine;

use super::range::outside_range;
use crate::load::checked_text::message::did_you_mean;

/// Why typed positions were refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("positions '{text}': {reason}")]
pub struct PositionsError {
    pub text: String,
    pub reason: String,
}

/// Positions by axis index, mm or rad, from text in mm and degrees; axes that are not named stand at zero.
pub fn positions_from_text(text: &str, machine: &Machine) -> Result<Vec<f64>, PositionsError> {
    let refuse = |reason: String| PositionsError { text: text.to_string(), reason };
    let mut positions = vec![None; machine.axes.len()];
    for part in text.split([',', ';']).map(str::trim).filter(|part| !part.is_empty()) {
        let Some((name, value)) = part.split_once('=') else {
            return Err(refuse(format!(
                "'{part}' is not understood; write AXIS=VALUE, for example A=30,C=-45 (mm, deg)"
            )));
        };
        let (name, value) = (name.trim(), value.trim());
        let names = machine.axis_names();
        let Some(axis) = machine.axis_index(name) else {
            let hint = did_you_mean(name, &names);
            return Err(refuse(format!("the machine has no axis '{name}'{hint} (its axes are {})", names.join(" "))));
        };
        let number = value.parse::<f64>().ok().filter(|number| number.is_finite());
        let Some(number) = number else {
            let unit = machine.axes[axis].kind.position_unit();
            return Err(refuse(format!("'{value}' for axis {name} is not a finite number ({unit})")));
        };
        let position = machine.axes[axis].kind.from_file_unit(number);
        if let Some(reason) = outside_range(machine, axis, position) {
            return Err(refuse(reason));
        }
        if positions[axis].replace(position).is_some() {
            return Err(refuse(format!("axis {name} stands twice; each axis stands once")));
        }
    }
    Ok(positions.into_iter().map(|position| position.unwrap_or(0.0)).collect())
}

//! Names of geometric errors: ISO 230-1 (`EX0C`, `EZX`), the thesis's and the three-character form on input. No values.

use std::fmt;

use crate::units::Measure;

/// One of the six small motions: three translations and three rotations along and about R's axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Component {
    EX,
    EY,
    EZ,
    EA,
    EB,
    EC,
}

impl Component {
    /// All six, translations first; the index is the one used in `[f64; 6]` arrays everywhere.
    pub const ALL: [Component; 6] =
        [Component::EX, Component::EY, Component::EZ, Component::EA, Component::EB, Component::EC];

    /// Place in a `[f64; 6]` array.
    pub fn index(self) -> usize {
        self as usize
    }

    /// True for the rotations EA, EB, EC.
    pub fn is_angle(self) -> bool {
        self.index() >= 3
    }

    /// Length or angle.
    pub fn measure(self) -> Measure {
        if self.is_angle() { Measure::Angle } else { Measure::Length }
    }

    /// Coordinate direction 0, 1, 2 along or about which the motion is.
    pub fn direction_index(self) -> usize {
        self.index() % 3
    }

    /// Letter after the E: X Y Z A B C.
    pub fn letter(self) -> char {
        ['X', 'Y', 'Z', 'A', 'B', 'C'][self.index()]
    }

    fn from_letter(letter: char) -> Option<Component> {
        let index = "XYZABC".find(letter.to_ascii_uppercase())?;
        Some(Component::ALL[index])
    }
}

/// Full name of an error: component, location (`0`) or component error, axis.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ErrorName {
    /// Which small motion.
    pub component: Component,
    /// True for a location error (`EX0C`), false for a component error (`EXC`).
    pub is_location: bool,
    /// Axis name.
    pub axis: String,
}

/// Why an error name was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("'{found}' is no error name: {reason}")]
pub struct ErrorNameError {
    pub found: String,
    pub reason: String,
}

impl ErrorName {
    /// Name of a location error.
    pub fn location(component: Component, axis: &str) -> ErrorName {
        ErrorName { component, is_location: true, axis: axis.to_string() }
    }

    /// Name of a component error.
    pub fn motion(component: Component, axis: &str) -> ErrorName {
        ErrorName { component, is_location: false, axis: axis.to_string() }
    }

    /// Reads ISO 230-1 names, the thesis's (`ex0c`, `θy0a`, `thy0a`) and the three-character form (`X0C`);
    /// `axes` are the machine's axis names.
    pub fn parse(text: &str, axes: &[&str]) -> Result<ErrorName, ErrorNameError> {
        let refuse = |reason: String| ErrorNameError { found: text.to_string(), reason };
        let trimmed = text.trim();
        let angle_rest = ["θ", "th"].iter().find_map(|prefix| trimmed.strip_prefix(prefix));
        let (component, rest) = match angle_rest {
            Some(rest) => {
                let letter = rest.chars().next().unwrap_or(' ');
                let index = "xyz"
                    .find(letter.to_ascii_lowercase())
                    .ok_or_else(|| refuse("after θ comes x, y or z, as in θy0a".into()))?;
                (Component::ALL[index + 3], &rest[letter.len_utf8()..])
            }
            None => {
                let after_e = trimmed
                    .strip_prefix(['E', 'e'])
                    .filter(|rest| !rest.starts_with('0') && rest.chars().count() >= 2)
                    .unwrap_or(trimmed);
                let letter = after_e.chars().next().unwrap_or(' ');
                let component = Component::from_letter(letter)
                    .ok_or_else(|| refuse("it names X Y Z A B or C after the E, as in EX0C or EZX".into()))?;
                (component, &after_e[letter.len_utf8()..])
            }
        };
        let (is_location, axis) = match rest.strip_prefix('0') {
            Some(axis) if !axis.is_empty() => (true, axis),
            _ => (false, rest),
        };
        let known = axes
            .iter()
            .find(|name| **name == axis)
            .or_else(|| axes.iter().find(|name| name.eq_ignore_ascii_case(axis)));
        let Some(known) = known else {
            return Err(refuse(format!("the machine has no axis '{axis}'; its axes are {}", axes.join(" "))));
        };
        if !is_location && angle_rest.is_some() && may_mean_location(component, known) {
            return Err(refuse(format!(
                "the thesis's chapter 5 prints θ{0}{1} for θ{0}0{1}, its Table 2.1 for a component error; write {2} for the \
                 location error or {3} for the component error",
                ['x', 'y', 'z'][component.direction_index()],
                known.to_lowercase(),
                ErrorName::location(component, known),
                ErrorName::motion(component, known)
            )));
        }
        let own_letter = ['X', 'Y', 'Z'][component.direction_index()];
        if is_location && angle_rest.is_some() && known.chars().eq([own_letter]) {
            let (length, angle) = (Component::ALL[component.direction_index()], component);
            return Err(refuse(format!(
                "the thesis's Table 2.1 pairs θ{0}0{0} with {1}, a length; write {1} for the zero point or {2} for the rotation",
                known.to_lowercase(),
                ErrorName::location(length, known),
                ErrorName::location(angle, known)
            )));
        }
        Ok(ErrorName { component, is_location, axis: known.to_string() })
    }
}

/// True where a θ without its 0 can be a location error in the thesis's manner: a tilt of a rotary axis across itself, or
/// of an axis whose name does not tell its kind. Slides, and turns of a rotary axis about itself, have only one meaning.
fn may_mean_location(component: Component, axis: &str) -> bool {
    let linear = ["X", "Y", "Z", "U", "V", "W"].iter().any(|name| axis.eq_ignore_ascii_case(name));
    let about_itself = axis.len() == 1 && axis.to_ascii_uppercase().starts_with(component.letter());
    !linear && !about_itself
}

impl fmt::Display for ErrorName {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let zero = if self.is_location { "0" } else { "" };
        write!(out, "E{}{zero}{}", self.component.letter(), self.axis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_spellings_of_a_name_are_one() {
        let axes = ["X", "Y", "Z", "A", "C", "J1"];
        let name = |text| ErrorName::parse(text, &axes).map(|name| name.to_string());
        for (text, iso) in [
            ("EX0C", "EX0C"),
            ("ex0c", "EX0C"),
            ("X0C", "EX0C"),
            ("θy0a", "EB0A"),
            ("thz0a", "EC0A"),
            ("EZX", "EZX"),
            ("EC0J1", "EC0J1"),
            ("EAC", "EAC"),
        ] {
            assert_eq!(name(text).as_deref(), Ok(iso), "{text}");
        }
        assert!(name("θya").unwrap_err().to_string().contains("write EB0A for the location error or EBA"));
        assert_eq!(name("θxa").as_deref(), Ok("EAA"));
        assert_eq!(name("θyx").as_deref(), Ok("EBX"));
        assert!(name("θx0x").unwrap_err().to_string().contains("write EX0X for the zero point or EA0X"));
        assert!(name("EX0Q").unwrap_err().to_string().contains("no axis 'Q'"));
        assert!(name("0").is_err());
        assert!(name("").is_err());
    }
}

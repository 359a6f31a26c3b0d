//! An effect of machine physics beyond constant location errors, as data: name, place, sizes, parameters. Its formula is in `effects`.

use super::error_name::Component;

/// Where an effect sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Place {
    /// A joint or slide, by axis index.
    Axis(usize),
    /// The pivot cup.
    Pivot,
    /// The ball in the spindle.
    SpindleBall,
    /// The bar between the balls.
    Bar,
    /// Whatever pairs positions with readings.
    Recorder,
    /// The control's own compensation.
    Control,
}

impl Place {
    /// Places that are no axis, with their names in files.
    pub const OTHERS: [(&'static str, Place); 5] = [
        ("pivot", Place::Pivot),
        ("spindle-ball", Place::SpindleBall),
        ("bar", Place::Bar),
        ("recorder", Place::Recorder),
        ("control", Place::Control),
    ];

    /// Axis index, when the place is an axis.
    pub fn axis(self) -> Option<usize> {
        match self {
            Place::Axis(axis) => Some(axis),
            _ => None,
        }
    }
}

/// What an effect moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Outlet {
    /// Component error of a joint, in the carrier's directions, mm or rad.
    Motion { axis: usize, component: Component },
    /// Motion along (mm) or about (rad) an inclined axis.
    Along { axis: usize },
    /// Location error of an axis, mm or rad.
    Location { axis: usize, component: Component },
    /// The axis stands behind its command by speed × size, s.
    Lag { axis: usize },
    /// The axis stands off its command by acceleration × size, s².
    Acceleration { axis: usize },
    /// Every slide stands off its command by its acceleration × size, s²: loops of like gain, of which `axis` is one.
    SlidesAcceleration { axis: usize },
    /// All recorded positions are too old by the size, s.
    Delay,
    /// Displacement of the pivot ball on its link along R's x, y or z (0, 1, 2), mm.
    Pivot(usize),
    /// Displacement of the spindle ball on its link, mm.
    SpindleBall(usize),
    /// Reading minus distance, mm.
    Reading,
}

/// One linear coefficient of an effect: the outlet receives `value × function`.
#[derive(Debug, Clone, PartialEq)]
pub struct Size {
    pub outlet: Outlet,
    /// Name of the function that it multiplies; empty when the effect has a single one.
    pub function: String,
    /// mm, rad, s, s², per K or per mm as the effect says.
    pub value: f64,
}

/// Value of a shape parameter, in library units (mm, rad, s).
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterValue {
    Number(f64),
    List(Vec<f64>),
    Word(String),
}

/// An effect as a machine has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    /// Name in the catalogue, such as `rotary-backlash`.
    pub kind: String,
    pub place: Place,
    pub sizes: Vec<Size>,
    /// Shape parameters that were stated; the others have the catalogue's defaults.
    pub parameters: Vec<(String, ParameterValue)>,
    /// Tests in which it acts, by name; `None`: all.
    pub tests: Option<Vec<String>>,
    /// A cause that is nearly as probable by the recordings that it was found in, in words.
    pub cannot_tell_from: Option<String>,
}

impl Effect {
    /// An effect without sizes and with default parameters.
    pub fn new(kind: &str, place: Place) -> Effect {
        Effect {
            kind: kind.to_string(),
            place,
            sizes: Vec::new(),
            parameters: Vec::new(),
            tests: None,
            cannot_tell_from: None,
        }
    }

    /// The effect with one more size.
    pub fn size(mut self, outlet: Outlet, function: &str, value: f64) -> Effect {
        self.sizes.push(Size { outlet, function: function.to_string(), value });
        self
    }

    /// The effect with a parameter set, in library units.
    pub fn with(mut self, name: &str, value: ParameterValue) -> Effect {
        self.set(name, value);
        self
    }

    /// Sets a parameter, in library units.
    pub fn set(&mut self, name: &str, value: ParameterValue) {
        match self.parameters.iter_mut().find(|(other, _)| other == name) {
            Some((_, old)) => *old = value,
            None => self.parameters.push((name.to_string(), value)),
        }
    }

    /// The value of a shape parameter that was stated as a number, in library units.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.parameter(name) {
            Some(ParameterValue::Number(value)) => Some(*value),
            _ => None,
        }
    }

    /// A stated parameter.
    pub fn parameter(&self, name: &str) -> Option<&ParameterValue> {
        self.parameters.iter().find(|(other, _)| other == name).map(|(_, value)| value)
    }

    /// The effect with every size multiplied.
    pub fn scaled(&self, factor: f64) -> Effect {
        let mut scaled = self.clone();
        scaled.sizes.iter_mut().for_each(|size| size.value *= factor);
        scaled
    }
}

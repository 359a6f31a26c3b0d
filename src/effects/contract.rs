//! The contract of an effect: names, words, parameters and functions. It holds no values; those are in `machine::Effect`.

use super::candidates::{CandidateFamily, Observations};
use super::context::{Context, Profile};
use super::showing_test::ShownBy;
use crate::machine::{AxisKind, Component, Effect, Machine, Outlet, ParameterValue, Place};
use crate::units::Measure;

/// What drives an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Driver {
    Direction,
    Position,
    Gravity,
    Load,
    Temperature,
    Time,
    Speed,
    Event,
    Constant,
}

impl Driver {
    /// All of them.
    pub const ALL: [Driver; 9] = [
        Driver::Direction,
        Driver::Position,
        Driver::Gravity,
        Driver::Load,
        Driver::Temperature,
        Driver::Time,
        Driver::Speed,
        Driver::Event,
        Driver::Constant,
    ];

    /// Name in output.
    pub fn name(self) -> &'static str {
        match self {
            Driver::Direction => "direction",
            Driver::Position => "position",
            Driver::Gravity => "gravity",
            Driver::Load => "load",
            Driver::Temperature => "temperature",
            Driver::Time => "time",
            Driver::Speed => "speed",
            Driver::Event => "event",
            Driver::Constant => "constant",
        }
    }
}

/// Unit of a shape parameter in files; inside the library positions are mm or rad.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterUnit {
    /// Position or travel of the place's axis: mm, or degrees in files.
    Position,
    /// A number without a unit, or in s, Hz, mm as its name and meaning say.
    Plain,
    /// One of these words; any word when empty.
    Word(&'static [&'static str]),
}

/// Smallest and largest value allowed, in file units.
pub type Bounds = (f64, f64);

/// What holds when a parameter is not stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DefaultValue {
    /// This number; positions in file units.
    Number(f64),
    /// An empty list, word or point: the kind says what that means.
    Absent,
    /// The parameter must be stated.
    Required,
}

/// One shape parameter of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    pub name: &'static str,
    pub unit: ParameterUnit,
    /// Number of values: 1 a number, 3 a point, 0 a list of any length.
    pub count: usize,
    pub default: DefaultValue,
    pub bounds: Bounds,
    pub meaning: &'static str,
}

impl Parameter {
    /// A number.
    pub const fn number(
        name: &'static str,
        unit: ParameterUnit,
        default: DefaultValue,
        bounds: Bounds,
        meaning: &'static str,
    ) -> Parameter {
        Parameter { name, unit, count: 1, default, bounds, meaning }
    }

    /// A list.
    pub const fn list(
        name: &'static str,
        unit: ParameterUnit,
        default: DefaultValue,
        bounds: Bounds,
        meaning: &'static str,
    ) -> Parameter {
        Parameter { name, unit, count: 0, default, bounds, meaning }
    }

    /// A word.
    pub const fn word(
        name: &'static str,
        words: &'static [&'static str],
        default: DefaultValue,
        meaning: &'static str,
    ) -> Parameter {
        Parameter { name, unit: ParameterUnit::Word(words), count: 1, default, bounds: (0.0, 0.0), meaning }
    }
}

/// Why an effect cannot be computed in a session.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EffectError {
    #[error("no effect is called '{found}'; the catalogue has {known}")]
    UnknownKind { found: String, known: String },
    #[error("{effect}: the recording of test '{test}' has no column '{channel}'; its further columns are: {found}")]
    NoChannel { effect: String, test: String, channel: String, found: String },
    #[error("{effect}: column '{channel}' has no reading in any test; name another one, or leave the effect out")]
    EmptyChannel { effect: String, channel: String },
    #[error(
        "{effect}: column '{channel}' of test '{test}' has no reading in row {row}; the load must be known at every row, fill it in or leave the row out"
    )]
    NoLoad { effect: String, test: String, channel: String, row: usize },
    #[error(
        "{effect}: test '{test}' has times, so 'pose' does not say when; state 'time' in s since the session began"
    )]
    PoseOfTimes { effect: String, test: String },
    #[error("{effect}: no link is called '{link}'; links are {known}")]
    NoLink { effect: String, link: String, known: String },
    #[error("{effect}: no axis drives it; say 'of: ' with one of {known}")]
    NoAxis { effect: String, known: String },
}

/// Sizes from which a machinist would want to know, in the display units of the effect: µm, arcsec, µm/m, ms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Notable {
    pub length: f64,
    pub angle: f64,
}

/// How an effect is looked for among the causes that a session cannot show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unseen {
    /// Through each of its outlets.
    Listed,
    /// At the moment that shows it least.
    ByMoment,
    /// As motion of any form.
    AnyForm,
    /// Not at all: there are too many shapes, or it only describes.
    Never,
}

/// What kind of trace an effect leaves: by this it is refined, sized and told apart. Effects may share one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Signature {
    /// Along the motion, from one flank to the other.
    Reversal,
    /// Across the motion, from one side to the other.
    Play,
    Spike,
    ErrorMotion,
    /// A period along the axis, with overtones.
    Period,
    /// A period along the axis whose phase runs with time.
    Beat,
    Sag,
    /// With a load that was measured.
    Load,
    /// With the weight of the joints beyond, whose levers are known.
    Weight,
    Growth,
    BarLength,
    Straightness,
    Lift,
    Squareness,
    Scale,
    Lag,
    Arrival,
    Radius,
    Latency,
    /// Once in a session.
    Jump,
    BallForm,
    Stiction,
    /// A line in the spectrum over time.
    Oscillation,
    /// A fixed course, with nothing to refine or to size but its largest value over the readings.
    Course,
    /// Any smooth curve.
    FreeCurve,
    /// Stated in the machine file, not looked for.
    Given,
}

/// Cells of the row that `docs/effects.md` has for a kind, as Markdown.
pub struct Documented {
    pub place: &'static str,
    pub components: &'static str,
    /// Its functions by name, with what they are.
    pub functions: &'static str,
    pub parameters: &'static str,
    pub unit: &'static str,
}

/// One kind of effect. The text fields are in the words of the trade.
pub struct Kind {
    /// Name in files and output.
    pub name: &'static str,
    pub driver: Driver,
    /// Equation with its symbols.
    pub formula: &'static str,
    /// What the stated size is.
    pub size_meaning: &'static str,
    /// What on the machine usually causes it.
    pub cause: &'static str,
    /// What one does about it.
    pub remedy: &'static str,
    /// What is said of it without its size, by place (empty: any): `{place}` and `{moving}` are filled in.
    pub titles: &'static [(&'static str, &'static str)],
    /// What the size measures, said after the number; `None`: its meaning.
    pub measures: Option<&'static str>,
    /// Sizes that matter to a machinist.
    pub notable: Notable,
    /// The test that shows it.
    pub shown_by: ShownBy,
    /// How it is looked for among the causes that a session cannot show.
    pub unseen: Unseen,
    /// Axes that may have it although they never moved.
    pub unmoved: &'static [AxisKind],
    /// How far the real form may be from this one, as a share of the size: a screw's period swells along its travel, a ball that
    /// slipped creeps on, the peak of a spike lies between two readings. Most are set by the sizes of the blind trial (docs/calibration.md).
    pub form_error: f64,
    /// It depends on times or runs, which static poses do not have; artefacts of balls have other seats at every pose.
    pub needs_runs: bool,
    /// What kind of trace it leaves.
    pub signature: Signature,
    /// What of it a search tries in a session: places, outlets, grids of shapes, what is refined, prior odds.
    pub candidates: fn(&Observations) -> Vec<CandidateFamily>,
    /// What it tries of it beside that in static poses.
    pub candidates_of_poses: fn(&Observations) -> Vec<CandidateFamily>,
    /// How the documentation states it.
    pub documented: Documented,
    pub parameters: &'static [Parameter],
    /// What is wrong with its parameters taken together, if anything.
    pub check: fn(&Machine, &Effect) -> Result<(), String>,
    /// Outlets it may have at a place; empty when it cannot sit there.
    pub outlets: fn(&Machine, Place) -> Vec<Outlet>,
    /// What its sizes measure at an outlet.
    pub measure: fn(&Machine, &Outlet, &str) -> Measure,
    /// Names of its functions for the stated parameters; one empty name when there is a single function.
    pub functions: fn(&Effect) -> Vec<String>,
    /// The functions over all rows of a session, in the order of `functions`.
    pub profiles: fn(&Context, &Effect) -> Result<Vec<Profile>, EffectError>,
}

impl Kind {
    /// What is said of it without its size: `Lost motion of Y`.
    pub fn title(&self, place: &str, moving: &str) -> String {
        let fits = |(of, _): &&(&str, &str)| of.is_empty() || *of == place;
        let title = self.titles.iter().find(fits).map_or("", |(_, title)| title);
        title.replace("{place}", place).replace("{moving}", moving)
    }

    /// Places of a machine where the effect can sit.
    pub fn places(&self, machine: &Machine) -> Vec<Place> {
        let axes = (0..machine.axes.len()).map(Place::Axis);
        let others = Place::OTHERS.iter().map(|(_, place)| *place);
        axes.chain(others).filter(|&place| !(self.outlets)(machine, place).is_empty()).collect()
    }

    /// Profiles of the functions, zero in tests where the effect does not act.
    pub fn shape(&self, context: &Context, effect: &Effect) -> Result<Vec<Profile>, EffectError> {
        let mut profiles = (self.profiles)(context, effect)?;
        if let Some(tests) = &effect.tests {
            for profile in &mut profiles {
                for (test, rows) in context.session().tests.iter().zip(profile) {
                    if !tests.contains(&test.name) {
                        rows.fill(0.0);
                    }
                }
            }
        }
        Ok(profiles)
    }

    /// A number of the effect, or its default; positions in mm or rad.
    pub fn number(&self, context: &Context, effect: &Effect, name: &str) -> f64 {
        self.number_of(context.machine(), effect, name)
    }

    /// The same without a session.
    pub fn number_of(&self, machine: &Machine, effect: &Effect, name: &str) -> f64 {
        match effect.parameter(name) {
            Some(ParameterValue::Number(value)) => *value,
            _ => match self.parameters.iter().find(|parameter| parameter.name == name) {
                Some(Parameter { default: DefaultValue::Number(value), unit: ParameterUnit::Position, .. }) => {
                    effect.place.axis().map_or(*value, |axis| machine.axes[axis].kind.from_file_unit(*value))
                }
                Some(Parameter { default: DefaultValue::Number(value), .. }) => *value,
                _ => f64::NAN,
            },
        }
    }
}

/// A list that was stated; empty otherwise.
pub(super) fn list<'a>(effect: &'a Effect, name: &str) -> &'a [f64] {
    match effect.parameter(name) {
        Some(ParameterValue::List(values)) => values,
        _ => &[],
    }
}

/// A word that was stated.
pub(super) fn word<'a>(effect: &'a Effect, name: &str) -> Option<&'a str> {
    match effect.parameter(name) {
        Some(ParameterValue::Word(word)) => Some(word),
        _ => None,
    }
}

/// The measure of the outlet itself, for functions without dimension.
pub(super) fn plain_measure(machine: &Machine, outlet: &Outlet, _function: &str) -> Measure {
    outlet.measure(machine)
}

/// The measure of the outlet per unit of a load, for functions that are the load.
pub(super) fn measure_per_load(machine: &Machine, outlet: &Outlet, _function: &str) -> Measure {
    match outlet.measure(machine) {
        Measure::Angle => Measure::AnglePerLoad,
        _ => Measure::LengthPerLoad,
    }
}

/// Whether a parameter names an axis of the machine, if it is stated.
pub(super) fn names_axis(machine: &Machine, effect: &Effect, key: &str) -> Result<(), String> {
    match word(effect, key) {
        Some(name) if machine.axis_index(name).is_none() => {
            Err(format!("'{key}: {name}' names no axis; axes are {}", machine.axis_names().join(" ")))
        }
        _ => Ok(()),
    }
}

/// Parameters that need no more than their bounds.
pub(super) fn no_check(_machine: &Machine, _effect: &Effect) -> Result<(), String> {
    Ok(())
}

/// The one function without a name.
pub(super) fn single_function(_effect: &Effect) -> Vec<String> {
    vec![String::new()]
}

/// The reading of a bar.
pub(super) fn read_with_a_bar(_: &Machine, place: Place) -> Vec<Outlet> {
    if place == Place::Bar { vec![Outlet::Reading] } else { Vec::new() }
}

/// The bar that an effect names.
pub(super) const NAMED_BAR: Parameter = Parameter::number(
    "bar",
    ParameterUnit::Plain,
    DefaultValue::Absent,
    (0.0, 1e5),
    "calibrated length of the bar concerned, mm (to 0.5 mm); every bar when not stated",
);

/// Every component of an axis, for effects that any axis may have.
pub(super) fn of_any_axis(machine: &Machine, place: Place) -> Vec<Outlet> {
    match place {
        Place::Axis(axis) => every_component(machine, axis),
        _ => Vec::new(),
    }
}

/// Every component of an axis, and its own motion when it is inclined.
pub(super) fn every_component(machine: &Machine, axis: usize) -> Vec<Outlet> {
    let mut all: Vec<Outlet> = Component::ALL.into_iter().map(|component| Outlet::Motion { axis, component }).collect();
    let own = Outlet::own(machine, axis);
    if !all.contains(&own) {
        all.push(own);
    }
    all
}

//! The `effects:` list of a machine file; what keys an effect has stands in the catalogue, not here.

use serde_yaml::{Mapping, Value};

use crate::effects::{self, DefaultValue, Kind, Parameter, ParameterUnit};
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::limits::{EFFECT_LIST, EFFECTS, TESTS};
use crate::load::checked_text::message::{LoadError, did_you_mean};
use crate::load::checked_text::quantity::{finite, quantity};
use crate::machine::{AxisKind, Effect, ErrorName, Machine, Outlet, ParameterValue, Place, Size};
use crate::units::shown;

/// Keys that every effect has beside its parameters.
const COMMON_KEYS: [&str; 5] = ["effect", "place", "sizes", "tests", "cannot_tell_from"];

/// Reads all effects of a machine whose axes are known.
pub(crate) fn effects(document: &Document, machine: &Machine, raw: &[Mapping]) -> Result<Vec<Effect>, LoadError> {
    if let Some(message) = EFFECTS.exceeded(raw.len()) {
        return Err(document.refuse(&[Step::Key("effects")], message));
    }
    raw.iter().enumerate().map(|(index, raw)| Entry { document, machine, index, raw }.effect()).collect()
}

/// One entry of the list.
struct Entry<'a> {
    document: &'a Document,
    machine: &'a Machine,
    index: usize,
    raw: &'a Mapping,
}

impl Entry<'_> {
    fn effect(&self) -> Result<Effect, LoadError> {
        let kind = self.kind()?;
        let place = self.place(kind)?;
        let mut effect = Effect::new(kind.name, place);
        for (key, value) in self.raw {
            let Some(key) = key.as_str() else {
                return Err(self.refuse("effect", "has a key that is no word; keys are words such as place"));
            };
            if COMMON_KEYS.contains(&key) {
                continue;
            }
            let parameter = self.known_parameter(kind, key)?;
            effect.parameters.push((key.to_string(), self.parameter(parameter, place, value)?));
        }
        let missing =
            kind.parameters.iter().find(|p| p.default == DefaultValue::Required && effect.parameter(p.name).is_none());
        if let Some(missing) = missing {
            return Err(
                self.refuse("effect", format!("{} needs the key '{}': {}", kind.name, missing.name, missing.meaning))
            );
        }
        (kind.check)(self.machine, &effect).map_err(|why| self.refuse("effect", format!("{}: {why}", kind.name)))?;
        effect.tests = self.tests()?;
        if self.raw.contains_key("cannot_tell_from") {
            effect.cannot_tell_from = Some(self.word("cannot_tell_from", "\"straightness of Y, 48 %\"")?.to_string());
        }
        effect.sizes = self.sizes(kind, &effect)?;
        Ok(effect)
    }

    fn refuse(&self, key: &str, message: impl Into<String>) -> LoadError {
        self.document.refuse(&[Step::Key("effects"), Step::Index(self.index), Step::Key(key)], message)
    }

    fn word(&self, key: &str, example: &str) -> Result<&str, LoadError> {
        match self.raw.get(key) {
            Some(Value::String(word)) => Ok(word),
            Some(_) => Err(self.refuse(key, format!("'{key}' is a word, e.g. {key}: {example}"))),
            None => Err(self.refuse(key, format!("an effect needs the key '{key}', e.g. {key}: {example}"))),
        }
    }

    fn kind(&self) -> Result<&'static Kind, LoadError> {
        let name = self.word("effect", effects::ROTARY_BACKLASH.name)?;
        effects::kind(name).ok_or_else(|| {
            let known = effects::kind_names();
            let message =
                format!("no effect is called '{name}'{} (allowed: {})", did_you_mean(name, &known), known.join(", "));
            self.refuse("effect", message)
        })
    }

    fn place(&self, kind: &Kind) -> Result<Place, LoadError> {
        let name = self.word("place", "C")?;
        let other = Place::OTHERS.iter().find(|(other, _)| *other == name).map(|(_, place)| *place);
        let place = self.machine.axis_index(name).map(Place::Axis).or(other);
        let places = kind.places(self.machine);
        place.filter(|place| places.contains(place)).ok_or_else(|| {
            let known: Vec<&str> = places.iter().map(|place| place.name(self.machine)).collect();
            let allowed = if known.is_empty() { "no place of this machine".into() } else { known.join(" ") };
            let message =
                format!("{} cannot sit at '{name}'{} (allowed: {allowed})", kind.name, did_you_mean(name, &known));
            self.refuse("place", message)
        })
    }

    fn known_parameter(&self, kind: &'static Kind, key: &str) -> Result<&'static Parameter, LoadError> {
        kind.parameters.iter().find(|parameter| parameter.name == key).ok_or_else(|| {
            let known: Vec<&str> =
                COMMON_KEYS.into_iter().chain(kind.parameters.iter().map(|parameter| parameter.name)).collect();
            let message = format!(
                "unknown key '{key}' of {}{} (allowed: {})",
                kind.name,
                did_you_mean(key, &known),
                known.join(", ")
            );
            self.refuse(key, message)
        })
    }

    fn parameter(&self, parameter: &Parameter, place: Place, value: &Value) -> Result<ParameterValue, LoadError> {
        let name = parameter.name;
        if let ParameterUnit::Word(words) = parameter.unit {
            return match value.as_str() {
                Some(word) if words.is_empty() || words.contains(&word) => Ok(ParameterValue::Word(word.to_string())),
                Some(word) => Err(self.refuse(
                    name,
                    format!(
                        "{name}: '{word}' is not allowed{} (allowed: {})",
                        did_you_mean(word, words),
                        words.join(", ")
                    ),
                )),
                None => Err(self.refuse(name, format!("{name} is a word: {}", parameter.meaning))),
            };
        }
        let number = |value: &Value| self.number(parameter, place, value);
        match (parameter.count, value) {
            (1, value) => number(value).map(ParameterValue::Number),
            (count, Value::Sequence(list)) if (count == 0 && list.len() <= EFFECT_LIST.most) || list.len() == count => {
                list.iter().map(number).collect::<Result<_, _>>().map(ParameterValue::List)
            }
            (0, _) => Err(self.refuse(
                name,
                format!("{name} is a list of at most {} numbers, e.g. [2, 3]: {}", EFFECT_LIST.most, parameter.meaning),
            )),
            (count, _) => Err(self.refuse(name, format!("{name} is a list of {count} numbers: {}", parameter.meaning))),
        }
    }

    fn number(&self, parameter: &Parameter, place: Place, value: &Value) -> Result<f64, LoadError> {
        let name = parameter.name;
        let step = [Step::Key("effects"), Step::Index(self.index), Step::Key(name)];
        let Some(value) = value.as_f64() else {
            return Err(self.refuse(name, format!("{name} is a number without a unit: {}", parameter.meaning)));
        };
        let value = finite(self.document, &step, value)?;
        let (from, to) = parameter.bounds;
        if value < from || value > to {
            return Err(
                self.refuse(name, format!("{name} = {} is outside {from} … {to}: {}", shown(value), parameter.meaning))
            );
        }
        Ok(match parameter.unit {
            ParameterUnit::Position => self.axis_kind(place).map_or(value, |kind| kind.from_file_unit(value)),
            _ => value,
        })
    }

    fn axis_kind(&self, place: Place) -> Option<AxisKind> {
        place.axis().map(|axis| self.machine.axes[axis].kind)
    }

    fn tests(&self) -> Result<Option<Vec<String>>, LoadError> {
        let Some(value) = self.raw.get("tests") else { return Ok(None) };
        let refuse = || self.refuse("tests", "tests is a list of test names, e.g. [c-short-cw, c-short-ccw]");
        let list = value.as_sequence().filter(|list| list.len() <= TESTS.most).ok_or_else(refuse)?;
        list.iter().map(|name| name.as_str().map(String::from).ok_or_else(refuse)).collect::<Result<_, _>>().map(Some)
    }

    fn sizes(&self, kind: &Kind, effect: &Effect) -> Result<Vec<Size>, LoadError> {
        let outlets = (kind.outlets)(self.machine, effect.place);
        let functions = (kind.functions)(effect);
        let example = outlets.first().map(|outlet| {
            let unit = (kind.measure)(self.machine, outlet, functions.first().map_or("", String::as_str)).output_unit();
            format!("sizes: {{{}: 1.5 {unit}}}", outlet.name(self.machine))
        });
        let example = example.unwrap_or_default();
        let Some(Value::Mapping(raw)) = self.raw.get("sizes") else {
            return Err(self.refuse("sizes", format!("an effect needs its sizes, e.g. {example}")));
        };
        let mut sizes = Vec::new();
        for (key, value) in raw {
            let key = key.as_str().unwrap_or_default();
            let outlet = self.outlet(key, &outlets)?;
            match value {
                Value::Mapping(by_function) => {
                    for (function, value) in by_function {
                        let function = function.as_str().unwrap_or_default();
                        sizes.push(self.size(kind, key, outlet, function, &functions, value)?);
                    }
                }
                value => sizes.push(self.size(kind, key, outlet, "", &functions, value)?),
            }
        }
        Ok(sizes)
    }

    fn outlet(&self, key: &str, outlets: &[Outlet]) -> Result<Outlet, LoadError> {
        let names: Vec<String> = outlets.iter().map(|outlet| outlet.name(self.machine)).collect();
        // the thesis's and the short spellings are taken as well
        let iso = ErrorName::parse(key, &self.machine.axis_names()).map(|name| name.to_string()).ok();
        let found = names.iter().position(|name| name == key || Some(name) == iso.as_ref());
        found.map(|index| outlets[index]).ok_or_else(|| {
            let known: Vec<&str> = names.iter().map(String::as_str).collect();
            let message =
                format!("no size is called '{key}' here{} (allowed: {})", did_you_mean(key, &known), known.join(", "));
            self.document.refuse(&self.size_steps(key), message)
        })
    }

    fn size_steps<'a>(&self, key: &'a str) -> [Step<'a>; 4] {
        [Step::Key("effects"), Step::Index(self.index), Step::Key("sizes"), Step::Key(key)]
    }

    fn size(
        &self,
        kind: &Kind,
        key: &str,
        outlet: Outlet,
        function: &str,
        functions: &[String],
        value: &Value,
    ) -> Result<Size, LoadError> {
        if !functions.iter().any(|name| name == function) {
            let known: Vec<&str> = functions.iter().map(String::as_str).collect();
            let found = if function.is_empty() { "a bare quantity".into() } else { format!("'{function}'") };
            let allowed = match known.as_slice() {
                [] => "none before its parameters name one".into(),
                [""] => format!("a bare quantity, {key}: 1.5 …"),
                _ => format!("{key}: {{{}: …}}", known.join(": …, ")),
            };
            let message = format!(
                "{} has no function for {found}{} (allowed: {allowed})",
                kind.name,
                did_you_mean(function, &known)
            );
            return Err(self.document.refuse(&self.size_steps(key), message));
        }
        let measure = (kind.measure)(self.machine, &outlet, function);
        let value = quantity(self.document, &self.size_steps(key), value, measure)?;
        Ok(Size { outlet, function: function.to_string(), value })
    }
}

//! A family of candidates: one kind of effect at one place, with its shapes. Which families there are stands in `catalogue`.

use super::motions::last_before_spindle;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::effects::{Signature, kind, signature};
use crate::machine::{AxisKind, Component, Effect, Machine, Outlet, ParameterValue, Place};

/// A family of candidates that differ only in shape.
#[derive(Debug, Clone)]
pub struct CandidateFamily {
    pub kind: &'static str,
    pub place: Place,
    pub outlets: Vec<Outlet>,
    /// Shapes on the grid; at least one.
    pub grid: Vec<Effect>,
    /// Shape parameters that are refined: name, smallest, largest, first step (library units); index into a list.
    pub refined: Vec<Refined>,
    /// Amplitudes up to this are plausible, display units: the widest amplitude prior that is tried.
    pub plausible: f64,
    /// Every test has amplitudes of its own: the phase of a free-running source is not kept from test to test.
    pub by_test: bool,
    /// Names of the effect's functions that take part; empty: all.
    pub functions: &'static [&'static str],
    /// Outlets through which a function acts, where not every one acts through all.
    pub pairs: Vec<(Outlet, &'static str)>,
    /// It changes from row to row: it is judged on all rows, the others on averaged ones.
    pub fast: bool,
    /// Log odds against it before the readings speak, beside causes that are common.
    pub rarity: f64,
}

/// A shape parameter to refine.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    pub name: &'static str,
    pub least: f64,
    pub most: f64,
    pub step: f64,
    /// Element of a list parameter; `None` for a number.
    pub element: Option<usize>,
}

impl CandidateFamily {
    /// Rank among names for the same signature: lower is the customary one (gauge squareness, growth at the spindle's slide).
    pub fn customary_rank(&self, model: &LinearModel) -> usize {
        let machine = model.context.machine();
        match (signature(self.kind), self.outlets.first()) {
            (Some(Signature::Squareness), Some(Outlet::Location { axis, component })) => {
                let gauge = [(Component::EC, 1), (Component::EB, 2), (Component::EA, 2)];
                let along = machine.axes[*axis].coordinate_direction();
                usize::from(!gauge.iter().any(|(c, k)| c == component && along == Some(*k)))
            }
            (Some(Signature::Growth), _) => match self.place.axis() {
                Some(axis) if last_before_spindle(model, axis) => self.outlets.len(),
                _ => 10,
            },
            // the axis under test is a rotary one as a rule, slides follow it
            (Some(Signature::FreeCurve), _) => match self.place.axis() {
                Some(axis) if machine.axes[axis].kind == AxisKind::Rotary => 0,
                _ => 1,
            },
            // without a second feed lost motion is the likelier one
            (Some(Signature::Lag), _) => 1,
            // an axis that moves is the likelier source than a ball that moves just along it, or than an axis at rest
            (Some(Signature::Oscillation), _) => match self.place.axis() {
                Some(axis) if (0..model.tests()).any(|test| model.context.motion(test).moving.contains(&axis)) => 0,
                Some(_) => 2,
                None => 1,
            },
            // in an arm the weight of its links is the likelier cause of what turns once with a joint
            (Some(Signature::Period), _) if !model.has_sweeps() => 1,
            _ => 0,
        }
    }

    pub(crate) fn new(kind: &'static str, place: Place, outlets: Vec<Outlet>, plausible: f64) -> CandidateFamily {
        CandidateFamily {
            kind,
            place,
            outlets,
            grid: vec![Effect::new(kind, place)],
            refined: Vec::new(),
            plausible,
            by_test: false,
            functions: &[],
            pairs: Vec::new(),
            fast: false,
            rarity: 0.0,
        }
    }

    pub(crate) fn over(mut self, grid: Vec<Effect>) -> CandidateFamily {
        self.grid = grid;
        self
    }

    pub(crate) fn fast(mut self) -> CandidateFamily {
        self.fast = true;
        self
    }

    pub(crate) fn refine(mut self, refined: Vec<Refined>) -> CandidateFamily {
        self.refined = refined;
        self
    }
}

/// Terms of an effect: every function through every outlet.
pub fn terms(machine: &Machine, effect: &Effect, outlets: &[Outlet]) -> Vec<Term> {
    let Some(kind) = kind(&effect.kind) else { return Vec::new() };
    let functions = (kind.functions)(effect);
    outlets
        .iter()
        .flat_map(|outlet| {
            functions.iter().enumerate().map(|(function, name)| Term {
                outlet: *outlet,
                function,
                measure: (kind.measure)(machine, outlet, name),
                test: None,
                along: None,
            })
        })
        .collect()
}

/// Parameter of a candidate alone: the direction along which the spindle ball moves. In a machine file its x, y and z have
/// sizes in that ratio.
pub const ALONG: &str = "along";

/// Terms of a family's effect in a session of so many tests.
pub fn family_terms(machine: &Machine, family: &CandidateFamily, effect: &Effect, tests: usize) -> Vec<Term> {
    let mut plain = terms(machine, effect, &family.outlets);
    if let Some(kind) = kind(&effect.kind) {
        let names = (kind.functions)(effect);
        let name = |term: &Term| names[term.function].as_str();
        plain.retain(|term| family.functions.is_empty() || family.functions.contains(&name(term)));
        plain.retain(|term| family.pairs.is_empty() || family.pairs.contains(&(term.outlet, name(term))));
    }
    if let Some(ParameterValue::List(along)) = effect.parameter(ALONG)
        && let Ok(along) = <[f64; 3]>::try_from(along.as_slice())
    {
        plain.retain(|term| term.outlet == Outlet::SpindleBall(0));
        plain.iter_mut().for_each(|term| term.along = Some(along));
    }
    if !family.by_test {
        return plain;
    }
    (0..tests).flat_map(|test| plain.iter().map(move |term| Term { test: Some(test), ..*term })).collect()
}

pub(crate) fn number(kind: &str, place: Place, name: &str, value: f64) -> Effect {
    Effect::new(kind, place).with(name, ParameterValue::Number(value))
}

pub(crate) fn list_of(values: Vec<f64>) -> ParameterValue {
    ParameterValue::List(values)
}

pub(crate) fn refined(name: &'static str, least: f64, most: f64, relative_step: f64) -> Refined {
    Refined { name, least, most, step: relative_step, element: None }
}

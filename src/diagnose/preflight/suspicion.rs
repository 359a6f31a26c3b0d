//! A mistake that may have been made, with the session as it would be without. Which one was made is for others to judge.

use super::data_fault::{DataFault, Rival};
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::selection::shapes::judged_shape::PARAMETER_COST;
use crate::session::Session;
use std::collections::{BTreeMap, HashSet};

/// A way in which the files may be wrong.
#[derive(Clone)]
pub(crate) struct Suspicion {
    pub(crate) kind: FaultKind,
    pub(crate) place: String,
    pub(crate) components: Vec<String>,
    pub(crate) tests: Vec<String>,
    pub(crate) says: String,
    pub(crate) detail: Detail,
    pub(crate) shift_ms: Option<f64>,
    /// Readings undone are so many times smaller than recorded, in the geometric mean: what is left of them counts as recorded.
    pub(crate) diminished: f64,
    /// Logarithm of what its figures cost that were fitted, and of how much likelier readings that agree by it are with it.
    pub(crate) log_figures: f64,
    /// One figure of it, which is not counted there, was found by the readings: where an axis stood, how late a clock is.
    pub(crate) is_found: bool,
    /// How usual the mistake is beside the others.
    pub(crate) weight: f64,
    pub(crate) undone: Session,
}

/// What tells a guess from others of the same kind, place, columns and tests.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum Detail {
    /// There are no others.
    OnlyOne,
    /// One way of several in which the same may be wrong.
    Way(&'static str),
    /// The link that it names.
    Link(String),
    /// Its sizes, each in whole steps of the last digit that is told.
    Sizes(Vec<i64>),
}

impl Detail {
    /// Sizes that are told to a step of their own unit.
    pub(crate) fn sizes(values: &[f64], step: f64) -> Detail {
        Detail::Sizes(values.iter().map(|value| (value / step).round() as i64).collect())
    }

    /// The same with one more size, told to another step.
    pub(crate) fn and_size(self, value: f64, step: f64) -> Detail {
        match (self, Detail::sizes(&[value], step)) {
            (Detail::Sizes(sizes), Detail::Sizes(more)) => Detail::Sizes([sizes, more].concat()),
            (_, more) => more,
        }
    }
}

/// What a mistake guesses: two that guess the same are one.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Guess {
    kind: FaultKind,
    place: String,
    components: Vec<String>,
    tests: Vec<String>,
    detail: Detail,
}

/// A mistake with what undoing it leaves.
pub(crate) struct Judged {
    /// Misfit, µm.
    pub(crate) left_um: f64,
    pub(crate) suspicion: Suspicion,
}

impl Judged {
    /// What it leaves of so many rows, µm, with what its figures cost: n·ln(misfit) is less the log likelihood.
    pub(crate) fn weighed_um(&self, rows: f64) -> f64 {
        self.left_um * (-self.suspicion.log_cost() / rows).exp()
    }
}

impl Suspicion {
    /// A mistake in what the session says of some tests, of no special weight.
    pub(crate) fn new(kind: FaultKind, place: &str, tests: Vec<String>, says: String, undone: Session) -> Suspicion {
        let (place, components) = (place.to_string(), Vec::new());
        Suspicion {
            kind,
            place,
            components,
            tests,
            says,
            detail: Detail::OnlyOne,
            shift_ms: None,
            diminished: 1.0,
            log_figures: 0.0,
            is_found: false,
            weight: SOMETIMES,
            undone,
        }
    }

    /// What it guesses. Recordings of an axis that are written from the wrong end are one guess, whichever they are: others are found
    /// one by one from the best of them.
    pub(crate) fn guess(&self) -> Guess {
        let is_found_one_by_one = self.kind == FaultKind::AngleReversed;
        Guess {
            kind: self.kind,
            place: self.place.clone(),
            components: self.components.clone(),
            tests: if is_found_one_by_one { Vec::new() } else { self.tests.clone() },
            detail: self.detail.clone(),
        }
    }

    /// Logarithm of what all its figures cost.
    pub(crate) fn log_cost(&self) -> f64 {
        self.log_figures - if self.is_found { PARAMETER_COST } else { 0.0 }
    }

    /// As what may be the mistake instead of another one.
    pub(crate) fn rival(self, probability: f64) -> Rival {
        let Suspicion { kind, place, components, says, .. } = self;
        Rival { kind, place, components, says, probability }
    }

    /// As the mistake, with the misfits before and after it is undone, µm.
    pub(crate) fn fault(self, before_um: f64, after_um: f64) -> DataFault {
        DataFault {
            components: self.components,
            before_um,
            after_um,
            shift_ms: self.shift_ms,
            ..DataFault::seen(self.kind, &self.place, self.tests, self.says)
        }
    }
}

/// Weights of mistakes: those that a person makes at once in a whole file, others, and those that need an odd tool.
pub(crate) const OFTEN: f64 = 1.0;
pub(crate) const SOMETIMES: f64 = 0.5;
pub(crate) const RARELY: f64 = 0.3;

/// How many mistakes were tried of each kind: places of one kind share what it is worth, figures cost for themselves.
pub(crate) struct Tried {
    kinds: BTreeMap<FaultKind, Kind>,
}

/// A kind of mistake: how usual it is, and the columns and tests that it was tried on.
#[derive(Default)]
struct Kind {
    weight: f64,
    places: HashSet<ColumnsAndTests>,
}

/// Columns and tests that a mistake concerns.
type ColumnsAndTests = (Vec<String>, Vec<String>);

impl Tried {
    /// Of all that are tried.
    pub(crate) fn of(suspicions: &[Suspicion]) -> Tried {
        let mut kinds: BTreeMap<FaultKind, Kind> = BTreeMap::new();
        for one in suspicions {
            let kind = kinds.entry(one.kind).or_default();
            kind.weight = kind.weight.max(one.weight);
            kind.places.insert((one.components.clone(), one.tests.clone()));
        }
        Tried { kinds }
    }

    /// Logarithm of the probability of a mistake among all that were tried, before any reading.
    pub(crate) fn log_prior(&self, of: &Suspicion) -> f64 {
        let all: f64 = self.kinds.values().map(|kind| kind.weight).sum();
        let alike = self.kinds.get(&of.kind).map_or(1, |kind| kind.places.len().max(1));
        (of.weight / (all.max(of.weight) * alike as f64)).ln()
    }
}

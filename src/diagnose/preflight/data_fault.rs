//! A mistake in the files or in what they say of the set-up, with others that leave the same. How it is found stands elsewhere.

use crate::diagnose::cause::{Cause, LEAST_PROBABILITY, MOST_RIVALS};
use crate::diagnose::fault_kind::FaultKind;

/// A mistake in the files.
#[derive(Debug, Clone, PartialEq)]
pub struct DataFault {
    /// What went wrong.
    pub kind: FaultKind,
    /// Where it was made: `recorder` for recordings, `pivot`, `spindle-ball`, `bar`, `session`, or an axis.
    pub place: String,
    /// Axes or columns concerned.
    pub components: Vec<String>,
    /// Tests concerned; empty: all.
    pub tests: Vec<String>,
    /// In words, with what to do.
    pub says: String,
    /// Robust residual as recorded and with the mistake undone, µm; NaN where the files show it without a fit.
    pub before_um: f64,
    pub after_um: f64,
    /// Shift in ms for `time-shift`.
    pub shift_ms: Option<f64>,
    /// Probability among the mistakes that are known.
    pub probability: f64,
    /// Other mistakes that leave the same: kind, axes or columns, and in words.
    pub rivals: Vec<Rival>,
    /// Effects of the machine that may be the cause instead, with their probabilities.
    pub causes: Vec<(Cause, f64)>,
}

/// A mistake that the recordings cannot tell from the one named.
#[derive(Debug, Clone, PartialEq)]
pub struct Rival {
    pub kind: FaultKind,
    pub place: String,
    pub components: Vec<String>,
    pub says: String,
    pub probability: f64,
}

/// Where recordings are made.
pub(crate) const RECORDER: &str = "recorder";

/// Where a test is described.
pub(crate) const SESSION: &str = "session";

/// What is claimed of a mistake in the files, with those that leave the same numbers.
pub(crate) const SURE_OF_FAULT: f64 = 0.99;

impl DataFault {
    /// A mistake that the files show by themselves.
    pub(crate) fn seen(kind: FaultKind, place: &str, tests: Vec<String>, says: String) -> DataFault {
        DataFault {
            kind,
            place: place.to_string(),
            components: Vec::new(),
            tests,
            says,
            before_um: f64::NAN,
            after_um: f64::NAN,
            shift_ms: None,
            probability: SURE_OF_FAULT,
            rivals: Vec::new(),
            causes: Vec::new(),
        }
    }

    /// As what may be the mistake instead of another one.
    pub(crate) fn into_rival(self) -> Rival {
        let DataFault { kind, place, components, says, probability, .. } = self;
        Rival { kind, place, components, says, probability }
    }

    /// The same with its rivals as likely as itself.
    pub(crate) fn shared_evenly(mut self) -> DataFault {
        let others = self.rivals.len().min(MOST_RIVALS);
        self.probability = SURE_OF_FAULT / (1 + others) as f64;
        self.rivals.iter_mut().for_each(|rival| rival.probability = self.probability);
        self
    }

    /// The same with a share of its probability, the rest of it being that of another mistake.
    pub(crate) fn or_other(mut self, share: f64, other: DataFault) -> DataFault {
        let other = DataFault { probability: self.probability * (1.0 - share), ..other };
        self.probability *= share;
        self.rivals.extend(Some(other.into_rival()).filter(|rival| rival.probability > LEAST_PROBABILITY));
        self
    }

    /// The same with an effect that may be the cause instead: a share of what is left of `probability`.
    pub(crate) fn or_effect(mut self, probability: f64, effect: Option<(Cause, f64)>) -> DataFault {
        self.probability *= probability;
        self.rivals.iter_mut().for_each(|rival| rival.probability *= probability);
        let left = SURE_OF_FAULT * (1.0 - probability);
        let effect = effect.map(|(effect, share)| (effect, share * left));
        self.causes.extend(effect.filter(|(_, probability)| *probability > LEAST_PROBABILITY));
        self
    }
}

/// Names of tests in words: three, and how many more.
pub(crate) fn listed(tests: &[String]) -> String {
    const NAMED: usize = 3;
    match tests.len() {
        0 => "all tests".to_string(),
        count if count <= NAMED => tests.join(", "),
        count => format!("{} and {} more", tests[..NAMED].join(", "), count - NAMED),
    }
}

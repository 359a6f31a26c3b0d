//! A mistake that may have been made, with the session as it would be without. Which one was made is for others to judge.

use super::data_fault::{DataFault, Rival};
use crate::session::Session;

/// A way in which the files may be wrong.
pub(crate) struct Suspicion {
    pub(crate) effect: &'static str,
    pub(crate) place: String,
    pub(crate) components: Vec<String>,
    pub(crate) tests: Vec<String>,
    pub(crate) says: String,
    pub(crate) shift_ms: Option<f64>,
    /// Readings undone are so many times smaller than recorded, in the geometric mean: what is left of them counts as recorded.
    pub(crate) diminished: f64,
    /// How usual the mistake is beside the others.
    pub(crate) weight: f64,
    pub(crate) undone: Session,
}

impl Suspicion {
    /// A mistake in what the session says of some tests, of no special weight.
    pub(crate) fn new(
        effect: &'static str,
        place: &str,
        tests: Vec<String>,
        says: String,
        undone: Session,
    ) -> Suspicion {
        let (place, components) = (place.to_string(), Vec::new());
        Suspicion { effect, place, components, tests, says, shift_ms: None, diminished: 1.0, weight: SOMETIMES, undone }
    }

    /// As what may be the mistake instead of another one.
    pub(crate) fn rival(self, probability: f64) -> Rival {
        let Suspicion { effect, place, components, says, .. } = self;
        Rival { effect, place, components, says, probability }
    }

    /// As the mistake, with the misfits before and after it is undone, µm.
    pub(crate) fn fault(self, before_um: f64, after_um: f64) -> DataFault {
        DataFault {
            components: self.components,
            before_um,
            after_um,
            shift_ms: self.shift_ms,
            ..DataFault::seen(self.effect, &self.place, self.tests, self.says)
        }
    }
}

/// Weights of mistakes: those that a person makes at once in a whole file, others, and those that need an odd tool.
pub(crate) const OFTEN: f64 = 1.0;
pub(crate) const SOMETIMES: f64 = 0.5;
pub(crate) const RARELY: f64 = 0.3;

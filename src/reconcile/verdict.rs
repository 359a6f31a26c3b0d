//! What a comparison says: differences of two claims, circles that would have to be off, what became of a cause. It compares nothing.

use crate::machine::ErrorName;
use crate::statistics::Fitted;

/// One error stated by two claims.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    pub name: ErrorName,
    pub claims: [usize; 2],
    /// Second minus first, µm or arcsec.
    pub value: f64,
    /// By the stated scatter alone.
    pub repeatability: f64,
    /// By the budgets.
    pub sigma: f64,
    /// Beyond what chance gives in the differences compared together.
    pub is_beyond: bool,
}

/// One disagreement: a circle that would have to be off.
#[derive(Debug, Clone)]
pub struct Disagreement {
    /// Index among the causes: the bar's reading of this circle.
    pub circle: usize,
    /// µm.
    pub size: Fitted,
    /// What it moves in its claim, µm and arcsec: these values are one disagreement.
    pub moves: Vec<(ErrorName, f64)>,
    /// Other circles that would do as well, as causes.
    pub alike: Vec<usize>,
}

/// What became of a cause.
#[derive(Debug, Clone)]
pub struct Verdict {
    pub cause: usize,
    /// Fitted size, in the cause's unit; `None` for an assumption.
    pub size: Option<Fitted>,
    /// Disagreements, by index, that it does away with.
    pub explains: Vec<usize>,
    /// How many circles still stand out.
    pub leaves: usize,
    pub chi2: f64,
    /// Needs no size beyond its limit.
    pub is_plausible: bool,
}

impl Verdict {
    /// It does away with a disagreement at a plausible size.
    pub fn is_named(&self) -> bool {
        self.is_plausible && !self.explains.is_empty()
    }
}

//! What a test tells: rows of derivatives with its setup quantities. How they follow from a setup is in `unknowns`.

use std::hash::{Hash, Hasher};

use nalgebra::DMatrix;

use super::hashing::Mix;

/// A setup quantity that tests may share.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Nuisance {
    /// Ball on a link: place in nm.
    Pivot(String, [i64; 3]),
    SpindleBall([i64; 3]),
    Bar(i64),
    /// Where the linear axes stand, or the middle of their motion: positions in nm.
    Stand(Vec<i64>),
    /// What the linear axes go too far or too short about that middle.
    Scale(Vec<i64>),
}

impl Nuisance {
    /// A fit takes it as an unknown of its own: pivots and bars.
    pub(crate) fn is_fitted(&self) -> bool {
        matches!(self, Nuisance::Pivot(..) | Nuisance::Bar(_))
    }
}

/// Rows of one test over a handful of poses.
#[derive(Debug, Clone)]
pub struct Block {
    /// Rows × errors (wanted first).
    pub(crate) errors: DMatrix<f64>,
    pub(crate) nuisances: Vec<Part>,
    /// Variance of a row, mm².
    pub(crate) row_variance: f64,
}

/// A setup quantity in the rows of a test.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub of: Nuisance,
    /// Hash of the quantity: it is looked up for every candidate of every round.
    pub hash: u64,
    /// One column or three.
    pub columns: DMatrix<f64>,
    /// Prior variance, mm².
    pub variance: f64,
}

impl Part {
    pub(crate) fn new(of: Nuisance, columns: DMatrix<f64>, variance: f64) -> Part {
        let mut mix = Mix::default();
        of.hash(&mut mix);
        Part { hash: mix.finish(), of, columns, variance }
    }
}

/// Poses of a block: enough for the three numbers that a sweep carries, with the ends weighted like the middle.
pub const BLOCK_ROWS: usize = 8;

/// The angle in the middle of the `row`-th of equal parts of an arc, rad: no angle counts twice in a full turn.
pub(crate) fn place_in_arc(from: f64, to: f64, row: usize) -> f64 {
    from + (to - from) * (row as f64 + 0.5) / BLOCK_ROWS as f64
}

/// Factor on a prior variance that makes a placement count as unknown: 20 µm become 20 mm.
pub(crate) const LOOSE: f64 = 1e6;
/// Factor on a prior variance that makes a quantity count as known; above zero, which keeps the arithmetic sound.
pub(crate) const HELD: f64 = 1e-6;

impl Block {
    /// Combinations of the rows in place of the rows.
    pub(crate) fn with_rows(&self, turned: &DMatrix<f64>) -> Block {
        let nuisances = self.nuisances.iter().map(|part| Part { columns: turned * &part.columns, ..part.clone() });
        Block { errors: turned * &self.errors, nuisances: nuisances.collect(), row_variance: self.row_variance }
    }

    /// Setup quantities that the test uses.
    pub fn uses(&self) -> impl Iterator<Item = &Nuisance> {
        self.nuisances.iter().map(|part| &part.of)
    }

    /// The same test with the spindle indexed by 180° about a direction of R (0, 1, 2).
    pub fn indexed(&self, about: usize) -> Block {
        let mut block = self.clone();
        for part in block.nuisances.iter_mut().filter(|part| matches!(part.of, Nuisance::SpindleBall(_))) {
            (0..3).filter(|&k| k != about).for_each(|k| part.columns.column_mut(k).neg_mut());
        }
        block
    }

    /// The same test with the prior variance of some setup quantities multiplied.
    pub fn with_prior_scaled(&self, scaled: impl Fn(&Nuisance) -> bool, factor: f64) -> Block {
        let mut block = self.clone();
        for part in block.nuisances.iter_mut().filter(|part| scaled(&part.of)) {
            part.variance *= factor;
        }
        block
    }
}

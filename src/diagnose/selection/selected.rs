//! What a search works on and what it finds. It decides nothing.

use crate::effects::{Signature, is_a};
use crate::statistics::BlockEvidence;
use crate::statistics::{NoiseModel, probability_of};
use std::cell::{Cell, OnceCell, RefCell};
use std::sync::Arc;

use super::limits::Limits;
use super::screening::screening_grid::ScreeningGrid;
use crate::diagnose::model::linear_model::{Column, LinearModel, Term};
use crate::diagnose::model::prior_penalty::PriorPenalty;
use crate::diagnose::model::regression::Accepted;
use crate::diagnose::model::whitened::WhitenedData;
use crate::effects::CandidateFamily;
use crate::machine::Effect;

/// A candidate with its best shape.
#[derive(Debug, Clone)]
pub struct Candidate {
    pub family: usize,
    pub effect: Effect,
    pub terms: Vec<Term>,
    pub columns: Vec<Column>,
    pub judgement: BlockEvidence,
    /// Log evidence with the cost of the shape grid taken off.
    pub log_odds: f64,
}

impl Candidate {
    /// A free curve: something is there, but no form of the catalogue.
    pub fn is_free(&self) -> bool {
        is_a(&self.effect.kind, Signature::FreeCurve)
    }

    /// Has a size of its own in every test, and is no vibration, whose phase is chance.
    pub fn differs_by_test(&self) -> bool {
        self.terms.iter().all(|term| term.test.is_some()) && !is_a(&self.effect.kind, Signature::Oscillation)
    }

    /// Acts once in a session.
    pub fn is_event(&self) -> bool {
        is_a(&self.effect.kind, Signature::Jump)
    }

    /// Positions and lengths of one test that do not belong together.
    pub fn is_shift_of_one_test(&self) -> bool {
        is_a(&self.effect.kind, Signature::Latency) && self.effect.tests.is_some()
    }

    /// Its columns as they join the model.
    pub fn accepted(&self) -> impl Iterator<Item = Accepted> + '_ {
        self.columns.iter().map(|column| Accepted { column: column.clone(), prior: self.judgement.tau.max(1.0) })
    }
}

/// An accepted effect with its rivals.
#[derive(Debug, Clone)]
pub struct SelectedEffect {
    pub chosen: Candidate,
    /// Other candidates at the same stage, best first, with their log odds relative to the chosen one (below zero).
    pub rivals: Vec<(Candidate, f64)>,
    /// Gain in log likelihood with the noise fitted before and after, less the cost of shapes and amplitudes.
    pub log_odds: f64,
    /// The gain alone.
    pub gain: f64,
    /// Log odds of the chosen candidate at the step that ranked the rivals, on the scale of theirs.
    pub ranked_odds: f64,
    /// The gain beside all other effects of the model: how far they can stand for it.
    pub beside_gain: f64,
    /// Fall of the mean square residual, mm².
    pub fall_mm2: f64,
    /// The place stands, its form does not: readings held out, or those that scatter on, speak against it.
    pub form_withdrawn: bool,
}

/// A set of effects that explains a session instead of the one that was taken.
#[derive(Debug, Clone)]
pub struct OtherSet {
    pub columns: Vec<Accepted>,
    /// Log odds beside the set that was taken, softened by what forms of the catalogue lack.
    pub log_odds: f64,
}

impl OtherSet {
    /// Probability of this set and not the other.
    pub fn probability(&self) -> f64 {
        probability_of(self.log_odds)
    }
}

/// Result of a search.
pub struct Search {
    pub floor: Vec<NoiseModel>,
    pub noise_after: Vec<NoiseModel>,
    pub found: Vec<SelectedEffect>,
    /// Columns of linear axes within their class, where they stand for something that was found.
    pub beside: Vec<Accepted>,
    /// Residuals with what was found in the fit, mm.
    pub residual_mm: Vec<Vec<f64>>,
    /// Mean square of the residual before anything was found, mm².
    pub residual_before_mm2: f64,
    /// Families that came near the best one at any step, by number. Empty: none is left out.
    pub contenders: Vec<bool>,
    /// The set that was not taken: free curves alone, or names where free curves stand better.
    pub other: Option<OtherSet>,
    /// Twice the negative log likelihood of what was stated of balls, bars and location errors, with what was found in the fit.
    pub stated_misfit: f64,
}

/// The same session at two resolutions: all rows for what is fast, averaged rows for what is slow.
pub struct Resolutions<'g, 'a> {
    pub fine: &'g LinearModel<'a>,
    pub coarse: &'g LinearModel<'a>,
    /// Shapes over the averaged rows.
    pub cells: &'g ScreeningGrid<'g>,
}

/// Noise by test, on all rows and on averaged ones.
pub type Floors = [Vec<NoiseModel>; 2];

/// A session with all that may be in it.
pub(crate) struct SelectionContext<'w, 'g, 'a> {
    pub(crate) resolutions: &'w Resolutions<'g, 'a>,
    pub(crate) families: &'w [CandidateFamily],
    pub(crate) floors: &'w Floors,
    pub(crate) limits: Limits,
    /// All rows and averaged ones under their noise floors.
    pub(crate) whitened: [Arc<WhitenedData<'g, 'a>>; 2],
    /// Steps made so far.
    pub(crate) steps: Cell<usize>,
    /// Balls out of round are not looked at: what the machine does says as much.
    pub(crate) balls_are_round: Cell<bool>,
    /// Free curves alone are looked at, whatever the names of the catalogue explain.
    pub(crate) only_free: Cell<bool>,
    /// Families that came near the best one at a step so far alone are looked at: other sets are tried of what explains much.
    pub(crate) only_contenders: Cell<bool>,
    /// The set of no effects, once asked for.
    pub(crate) empty: OnceCell<JointFit>,
    /// Families that came near the best one at any step so far, by number.
    pub(crate) contenders: RefCell<Vec<bool>>,
}

/// One step of a search: what it finds and what is left then.
pub(crate) struct Step {
    pub(crate) found: SelectedEffect,
    pub(crate) residual_mm: Vec<Vec<f64>>,
    pub(crate) pulls: PriorPenalty,
    pub(crate) noise: Vec<NoiseModel>,
}

/// What a search has found so far.
#[derive(Clone)]
pub(crate) struct JointFit {
    /// Accepted columns on all rows and on averaged ones.
    pub(crate) columns: [Vec<Accepted>; 2],
    pub(crate) found: Vec<SelectedEffect>,
    pub(crate) residual_mm: Vec<Vec<f64>>,
    /// How far balls, bars and location errors are then from what was stated of them.
    pub(crate) pulls: PriorPenalty,
    pub(crate) noise: Vec<NoiseModel>,
    /// The set that was not taken; none where one place explains all.
    pub(crate) other: Option<OtherSet>,
}

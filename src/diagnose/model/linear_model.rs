//! A fitted session laid out for the search: residuals, sensitivities and the columns of what has been fitted already.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use nalgebra::DMatrix;

use super::shapes::Shapes;
use crate::diagnose::thresholds::Thresholds;

use crate::chain::Sensitivity;
use crate::disturbances::gain;
use crate::effects::{Context, EffectError, Profile};
use crate::identify::{Problem, Quantity};
use crate::machine::{Effect, Outlet};
use crate::units::Measure;

/// Change of the readings per unit of what moves, by test.
pub type Gains<'g> = Cow<'g, [Vec<f64>]>;

/// The session around its fit: everything the search needs is linear from here.
#[derive(Clone)]
pub struct LinearModel<'a> {
    pub context: &'a Context<'a>,
    pub problem: &'a Problem<'a>,
    /// Reading minus model at the fit, mm, by test.
    pub residual_mm: Vec<Vec<f64>>,
    /// Rows that take part.
    pub kept: Vec<Vec<bool>>,
    /// Columns of the unknowns already in the fit, in units of their priors, by test; zero where a test does not see one.
    pub nuisance: Arc<Vec<DMatrix<f64>>>,
    /// How far the fit has put the unknowns from their prior means, in units of their priors: effects may bring them back.
    pub beyond: Vec<f64>,
    sensitivities: Arc<Vec<Vec<Sensitivity>>>,
    gains: HashMap<Outlet, Arc<Vec<Vec<f64>>>>,
    /// Functions of effects over the rows of the context, whichever of them take part.
    shapes: Arc<Shapes>,
    /// By the name of a shape: the terms of all families that have it.
    together: Arc<HashMap<String, Vec<Term>>>,
    /// What decides in a search of it.
    pub thresholds: Thresholds,
}

impl<'a> LinearModel<'a> {
    /// Lays out a problem at the values of a fit.
    pub fn new(
        context: &'a Context<'a>,
        problem: &'a Problem<'a>,
        values: &[f64],
        kept: Vec<Vec<bool>>,
    ) -> LinearModel<'a> {
        let geometry = problem.geometry(values);
        let mut residual_mm = Vec::new();
        let mut nuisance = Vec::new();
        let mut sensitivities = Vec::new();
        for (index, test) in problem.tests.iter().enumerate() {
            let rows = test.motion.rows();
            let mut residual = Vec::with_capacity(rows);
            let mut columns = DMatrix::zeros(rows, problem.unknowns.len());
            let mut all = Vec::with_capacity(rows);
            problem.visit(index, &geometry, values, |row, s, bar| {
                residual.push(test.reading_mm[row] - s.length_mm - bar);
                for &k in &test.columns {
                    columns[(row, k)] = derivative(problem, index, k, s) * problem.unknowns[k].prior_sigma;
                }
                all.push(s.clone());
            });
            residual_mm.push(residual);
            nuisance.push(columns);
            sensitivities.push(all);
        }
        let (gains, shapes, together) = (HashMap::new(), Arc::default(), Arc::default());
        let thresholds = Thresholds::default();
        let unknowns = problem.unknowns.iter().zip(values);
        let beyond = unknowns.map(|(unknown, value)| (value - unknown.prior_mean) / unknown.prior_sigma).collect();
        LinearModel {
            context,
            problem,
            residual_mm,
            kept,
            nuisance: Arc::new(nuisance),
            beyond,
            sensitivities: Arc::new(sensitivities),
            gains,
            shapes,
            together,
            thresholds,
        }
    }

    /// The same model with neighbouring rows averaged: what slow effects need, at a fraction of the rows.
    ///
    /// `context` belongs to the thinned session; `groups` are its rows as ranges of the rows here.
    pub fn thinned(&self, context: &'a Context<'a>, groups: &[Vec<std::ops::Range<usize>>]) -> LinearModel<'a> {
        let (mut all_kept, mut residual_mm) = (Vec::new(), Vec::new());
        let (mut nuisance, mut sensitivities) = (Vec::new(), Vec::new());
        for (test, groups) in groups.iter().enumerate() {
            let kept = &self.kept[test];
            let rows = |group: &std::ops::Range<usize>| -> Vec<usize> {
                let present: Vec<usize> = group.clone().filter(|&row| kept[row]).collect();
                if present.is_empty() { group.clone().collect() } else { present }
            };
            let columns = self.problem.unknowns.len();
            let mut averaged = DMatrix::zeros(groups.len(), columns);
            let mut residual = Vec::with_capacity(groups.len());
            for (index, group) in groups.iter().enumerate() {
                let rows = rows(group);
                let share = 1.0 / rows.len() as f64;
                residual.push(rows.iter().map(|&row| self.residual_mm[test][row]).sum::<f64>() * share);
                for k in 0..columns {
                    averaged[(index, k)] = rows.iter().map(|&row| self.nuisance[test][(row, k)]).sum::<f64>() * share;
                }
            }
            // a group with fewer than half of its readings would be noisier than the others
            all_kept.push(
                groups.iter().map(|group| 2 * group.clone().filter(|&row| kept[row]).count() >= group.len()).collect(),
            );
            residual_mm.push(residual);
            nuisance.push(averaged);
            let middle =
                |group: &std::ops::Range<usize>| self.sensitivities[test][(group.start + group.end - 1) / 2].clone();
            sensitivities.push(groups.iter().map(middle).collect());
        }
        LinearModel {
            context,
            problem: self.problem,
            residual_mm,
            kept: all_kept,
            nuisance: Arc::new(nuisance),
            beyond: self.beyond.clone(),
            sensitivities: Arc::new(sensitivities),
            gains: HashMap::new(),
            shapes: Arc::default(),
            together: self.together.clone(),
            thresholds: self.thresholds,
        }
    }

    /// The same model with other rows taking part.
    pub fn with_rows(&self, kept: Vec<Vec<bool>>) -> LinearModel<'a> {
        LinearModel { kept, ..self.clone() }
    }

    /// Works out the gains of these outlets once, so that columns need not.
    pub fn prepare<'o>(&mut self, outlets: impl Iterator<Item = &'o Outlet>) {
        for outlet in outlets {
            if !self.gains.contains_key(outlet) {
                let gains = self.gain_of(outlet);
                self.gains.insert(*outlet, Arc::new(gains));
            }
        }
    }

    /// States the terms of all families that have a shape, by its name: their products are worked out together.
    pub fn set_together(&mut self, together: HashMap<String, Vec<Term>>) {
        self.together = Arc::new(together);
    }

    /// Terms of all families that have the shape of this name.
    pub(super) fn together(&self, name: &str) -> Option<&[Term]> {
        self.together.get(name).map(Vec::as_slice)
    }

    /// Whether any test was recorded in time: static poses have no noise floor but the residual itself.
    pub fn has_sweeps(&self) -> bool {
        self.context.has_sweeps()
    }

    /// Change of the readings by one standard deviation of an unknown of a problem over the same rows, mm.
    pub fn unknown(&self, problem: &Problem, k: usize) -> Column {
        let sigma = problem.unknowns[k].prior_sigma;
        let in_test = |test: usize| -> Vec<f64> {
            if !problem.tests[test].columns.contains(&k) {
                return Vec::new();
            }
            let of_row = |(row, s): (usize, &Sensitivity)| {
                let shape = match problem.unknowns[k].quantity {
                    Quantity::Slide { axis, shape, .. } => {
                        problem.slides.at(axis, shape, self.context.motion(test).row(row)[axis])
                    }
                    _ => 1.0,
                };
                sigma * shape * problem.derivative(test, k, s)
            };
            self.sensitivities[test].iter().enumerate().map(of_row).collect()
        };
        Column::new((0..self.tests()).map(in_test).collect())
    }

    /// Number of tests.
    pub fn tests(&self) -> usize {
        self.residual_mm.len()
    }

    fn gain_of(&self, outlet: &Outlet) -> Vec<Vec<f64>> {
        self.sensitivities
            .iter()
            .enumerate()
            .map(|(test, rows)| {
                let all: Vec<f64> =
                    rows.iter().enumerate().map(|(row, s)| gain(self.context, (test, row), outlet, s)).collect();
                // a test that an outlet does not reach is left out of every sum
                if all.iter().all(|value| value.abs() < 1e-9) { Vec::new() } else { all }
            })
            .collect()
    }

    /// Change of the reading per unit of an outlet, by test; empty where the outlet has none.
    pub fn gains(&self, outlet: &Outlet) -> Gains<'_> {
        match self.gains.get(outlet) {
            Some(gains) => Cow::Borrowed(gains.as_slice()),
            None => Cow::Owned(self.gain_of(outlet)),
        }
    }

    /// First-order columns of an effect's terms, mm per display unit (µm, arcsec, ms, …).
    pub fn columns(&self, effect: &Effect, terms: &[Term]) -> Result<Vec<Column>, EffectError> {
        Ok(self.columns_of(&self.profiles(effect)?, terms))
    }

    /// Functions of an effect over all rows; tests in which they are zero hold none.
    pub fn profiles(&self, effect: &Effect) -> Result<Arc<Vec<Profile>>, EffectError> {
        self.shapes.of(self.context, effect)
    }

    /// Columns of terms whose functions are known.
    pub fn columns_of(&self, profiles: &[Profile], terms: &[Term]) -> Vec<Column> {
        let (gains, of_term) = self.gains_of(terms);
        let with_gains = terms.iter().zip(of_term);
        with_gains.map(|(term, own)| column(&gains[own], &profiles[term.function], term)).collect()
    }

    /// Gains of terms, each once, and which of them is a term's.
    fn gains_of(&self, terms: &[Term]) -> (Vec<Gains<'_>>, Vec<usize>) {
        let mut known: Vec<(Outlet, Option<[f64; 3]>)> = Vec::new();
        let mut gains = Vec::new();
        let of_term = terms.iter().map(|term| {
            let own = (term.outlet, term.along);
            known.iter().position(|other| *other == own).unwrap_or_else(|| {
                known.push(own);
                gains.push(self.gains_of_term(term));
                known.len() - 1
            })
        });
        let of_term = of_term.collect();
        (gains, of_term)
    }

    /// Change of the reading per unit of what a term moves, by test.
    pub fn gains_of_term(&self, term: &Term) -> Gains<'_> {
        match term.along {
            None => self.gains(&term.outlet),
            Some(direction) => Cow::Owned(self.gains_along(direction)),
        }
    }

    /// Change of the reading as the spindle ball moves along a direction of its link, by test.
    fn gains_along(&self, direction: [f64; 3]) -> Vec<Vec<f64>> {
        let gains = [0, 1, 2].map(|k| self.gains(&Outlet::SpindleBall(k)));
        let in_test = |test: usize| {
            let mut sum = vec![0.0; self.residual_mm[test].len()];
            for (gains, share) in gains.iter().zip(direction) {
                sum.iter_mut().zip(&gains[test]).for_each(|(sum, gain)| *sum += share * gain);
            }
            sum
        };
        (0..self.tests()).map(in_test).collect()
    }

    /// Columns of terms whose functions are known, to be written test by test.
    pub fn shape<'s>(&'s self, profiles: &'s [Profile], terms: &'s [Term]) -> Shape<'s> {
        let (gains, of_term) = self.gains_of(terms);
        Shape { profiles, terms, gains, of_term }
    }
}

/// Columns of terms, written test by test.
pub struct Shape<'s> {
    profiles: &'s [Profile],
    terms: &'s [Term],
    gains: Vec<Gains<'s>>,
    /// By term: which of the gains is its own.
    of_term: Vec<usize>,
}

impl Shape<'_> {
    /// Number of its columns.
    pub fn columns(&self) -> usize {
        self.terms.len()
    }

    /// Writes the columns that act in a test one after the other into `block`, and which they are into `present`.
    pub fn fill(&self, test: usize, block: &mut Vec<f64>, present: &mut Vec<usize>) {
        block.clear();
        present.clear();
        for (j, term) in self.terms.iter().enumerate() {
            let before = block.len();
            column_in(&self.gains[self.of_term[j]][test], &self.profiles[term.function][test], (term, test), block);
            if block.len() > before {
                present.push(j);
            }
        }
    }
}

fn column(gains: &[Vec<f64>], profile: &Profile, term: &Term) -> Column {
    let in_test = |test: usize| {
        let mut column = Vec::new();
        column_in(&gains[test], &profile[test], (term, test), &mut column);
        column
    };
    Column::new((0..gains.len()).map(in_test).collect())
}

/// Adds the column of a term in one test to what stands before it; nothing where it does nothing.
fn column_in(gain: &[f64], profile: &[f64], (term, test): (&Term, usize), column: &mut Vec<f64>) {
    if term.test.is_some_and(|only| only != test) {
        return;
    }
    let before = column.len();
    let unit = 1.0 / display(term.measure);
    column.resize(before + gain.len().min(profile.len()), 0.0);
    let own = &mut column[before..];
    pulp::Arch::new().dispatch(|| {
        own.iter_mut().zip(gain).zip(profile).for_each(|((own, gain), value)| *own = gain * value * unit);
    });
    if column[before..].iter().all(|value| value.abs() < 1e-12) {
        column.truncate(before);
    }
}

/// Display units per library unit: µm, arcsec, ms, µm/m.
pub fn display(measure: Measure) -> f64 {
    match measure {
        Measure::Length | Measure::LengthPerKelvin | Measure::LengthPerLoad => 1e3,
        Measure::Angle | Measure::AnglePerKelvin | Measure::AnglePerLoad => crate::units::ARCSEC_PER_RAD,
        Measure::Strain => 1e6,
        Measure::Time => 1e3,
        Measure::TimeSquared => 1e6,
    }
}

/// One linear coefficient of a candidate: a function of the effect acting at an outlet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Term {
    pub outlet: Outlet,
    /// Index of the function.
    pub function: usize,
    pub measure: Measure,
    /// The one test in which it acts; `None`: all.
    pub test: Option<usize>,
    /// Direction of the link along which the spindle ball moves, a unit vector: one coefficient for what its x, y and z
    /// do together, `outlet` being x.
    pub along: Option<[f64; 3]>,
}

impl Term {
    /// Outlets that it moves, the ones that move most first.
    pub fn outlets(&self) -> Vec<Outlet> {
        self.shares().into_iter().map(|(outlet, _)| outlet).collect()
    }

    /// What outlets get of its size, the largest share first.
    pub fn shares(&self) -> Vec<(Outlet, f64)> {
        let Some(along) = self.along else { return vec![(self.outlet, 1.0)] };
        let mut shares: Vec<(Outlet, f64)> =
            along.into_iter().enumerate().map(|(k, share)| (Outlet::SpindleBall(k), share)).collect();
        shares.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        shares
    }
}

/// Change of the readings per display unit of a term, mm, by test; empty where it has none.
#[derive(Debug, Clone)]
pub struct Column {
    pub by_test: Arc<Vec<Vec<f64>>>,
    /// Of the column and its clones alone.
    pub(super) id: u64,
}

impl PartialEq for Column {
    fn eq(&self, other: &Column) -> bool {
        self.by_test == other.by_test
    }
}

impl Column {
    /// Values by test.
    pub fn new(by_test: Vec<Vec<f64>>) -> Column {
        static COLUMNS: AtomicU64 = AtomicU64::new(0);
        Column { by_test: Arc::new(by_test), id: COLUMNS.fetch_add(1, Ordering::Relaxed) }
    }

    /// The one test in which it acts, if it is one.
    pub fn home(&self) -> Option<usize> {
        let mut present = (0..self.by_test.len()).filter(|&test| !self.by_test[test].is_empty());
        present.next().filter(|_| present.next().is_none())
    }
}

fn derivative(problem: &Problem, test: usize, k: usize, s: &Sensitivity) -> f64 {
    debug_assert!(problem.tests[test].columns.contains(&k));
    match problem.unknowns[k].quantity {
        // a diagnosis takes linear axes as exact but for what it finds
        Quantity::Slide { .. } => 0.0,
        _ => problem.derivative(test, k, s),
    }
}

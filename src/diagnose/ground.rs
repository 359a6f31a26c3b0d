//! A fitted session laid out for the search: residuals, sensitivities and the columns of what has been fitted already.

use std::collections::HashMap;

use nalgebra::DMatrix;

use crate::chain::Sensitivity;
use crate::effects::{Context, EffectError, Profile, gain, kind};
use crate::identify::{Problem, Quantity};
use crate::machine::{Effect, Outlet};
use crate::units::Measure;

/// The session around its fit: everything the search needs is linear from here.
pub struct Ground<'a> {
    pub context: &'a Context<'a>,
    pub problem: &'a Problem<'a>,
    /// Reading minus model at the fit, mm, by test.
    pub residual_mm: Vec<Vec<f64>>,
    /// Rows that take part.
    pub kept: Vec<Vec<bool>>,
    /// Columns of the unknowns already in the fit, in units of their priors, by test; zero where a test does not see one.
    pub nuisance: Vec<DMatrix<f64>>,
    sensitivities: Vec<Vec<Sensitivity>>,
    gains: HashMap<Outlet, Vec<Vec<f64>>>,
}

impl<'a> Ground<'a> {
    /// Lays out a problem at the values of a fit.
    pub fn new(context: &'a Context<'a>, problem: &'a Problem<'a>, values: &[f64], kept: Vec<Vec<bool>>) -> Ground<'a> {
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
        Ground { context, problem, residual_mm, kept, nuisance, sensitivities, gains: HashMap::new() }
    }

    /// The same ground with neighbouring rows averaged: what slow effects need, at a fraction of the rows.
    ///
    /// `context` belongs to the thinned session; `groups` are its rows as ranges of the rows here.
    pub fn thinned(&self, context: &'a Context<'a>, groups: &[Vec<std::ops::Range<usize>>]) -> Ground<'a> {
        let mut thin = Ground {
            context,
            problem: self.problem,
            residual_mm: Vec::new(),
            kept: Vec::new(),
            nuisance: Vec::new(),
            sensitivities: Vec::new(),
            gains: HashMap::new(),
        };
        for (test, groups) in groups.iter().enumerate() {
            let kept = &self.kept[test];
            let rows = |group: &std::ops::Range<usize>| -> Vec<usize> {
                let present: Vec<usize> = group.clone().filter(|&row| kept[row]).collect();
                if present.is_empty() { group.clone().collect() } else { present }
            };
            let columns = self.problem.unknowns.len();
            let mut nuisance = DMatrix::zeros(groups.len(), columns);
            let mut residual = Vec::with_capacity(groups.len());
            for (index, group) in groups.iter().enumerate() {
                let rows = rows(group);
                let share = 1.0 / rows.len() as f64;
                residual.push(rows.iter().map(|&row| self.residual_mm[test][row]).sum::<f64>() * share);
                for k in 0..columns {
                    nuisance[(index, k)] = rows.iter().map(|&row| self.nuisance[test][(row, k)]).sum::<f64>() * share;
                }
            }
            // a group with fewer than half of its readings would be noisier than the others
            thin.kept.push(
                groups.iter().map(|group| 2 * group.clone().filter(|&row| kept[row]).count() >= group.len()).collect(),
            );
            thin.residual_mm.push(residual);
            thin.nuisance.push(nuisance);
            let middle =
                |group: &std::ops::Range<usize>| self.sensitivities[test][(group.start + group.end - 1) / 2].clone();
            thin.sensitivities.push(groups.iter().map(middle).collect());
        }
        thin
    }

    /// The same ground with other rows taking part.
    pub fn with_rows(&self, kept: Vec<Vec<bool>>) -> Ground<'a> {
        Ground {
            context: self.context,
            problem: self.problem,
            residual_mm: self.residual_mm.clone(),
            kept,
            nuisance: self.nuisance.clone(),
            sensitivities: self.sensitivities.clone(),
            gains: self.gains.clone(),
        }
    }

    /// Works out the gains of these outlets once, so that columns need not.
    pub fn prepare<'o>(&mut self, outlets: impl Iterator<Item = &'o Outlet>) {
        for outlet in outlets {
            if !self.gains.contains_key(outlet) {
                let gains = self.gain_of(outlet);
                self.gains.insert(*outlet, gains);
            }
        }
    }

    /// Whether any test was recorded in time: static poses have no noise floor but the residual itself.
    pub fn has_sweeps(&self) -> bool {
        (0..self.tests()).any(|test| self.context.motion(test).time_s.is_some())
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
    pub fn gains(&self, outlet: &Outlet) -> std::borrow::Cow<'_, [Vec<f64>]> {
        match self.gains.get(outlet) {
            Some(gains) => std::borrow::Cow::Borrowed(gains),
            None => std::borrow::Cow::Owned(self.gain_of(outlet)),
        }
    }

    /// First-order columns of an effect's terms, mm per display unit (µm, arcsec, ms, …).
    pub fn columns(&self, effect: &Effect, terms: &[Term]) -> Result<Vec<Column>, EffectError> {
        let Some(kind) = kind(&effect.kind) else {
            return Err(EffectError::UnknownKind { found: effect.kind.clone(), known: String::new() });
        };
        Ok(self.columns_of(&kind.shape(self.context, effect)?, terms))
    }

    /// Columns of terms whose functions are known.
    pub fn columns_of(&self, profiles: &[Profile], terms: &[Term]) -> Vec<Column> {
        terms.iter().map(|term| self.column(&profiles[term.function], term)).collect()
    }

    fn column(&self, profile: &Profile, term: &Term) -> Column {
        let gains = self.gains(&term.outlet);
        let unit = 1.0 / display(term.measure);
        let by_test = gains
            .iter()
            .zip(profile)
            .enumerate()
            .map(|(test, (gain, profile))| {
                if gain.is_empty() || term.test.is_some_and(|only| only != test) {
                    return Vec::new();
                }
                let column: Vec<f64> = gain.iter().zip(profile).map(|(gain, value)| gain * value * unit).collect();
                if column.iter().all(|value| value.abs() < 1e-12) { Vec::new() } else { column }
            })
            .collect();
        Column { by_test }
    }
}

/// Display units per library unit: µm, arcsec, ms, µm/m.
pub fn display(measure: Measure) -> f64 {
    match measure {
        Measure::Length | Measure::LengthPerKelvin => 1e3,
        Measure::Angle | Measure::AnglePerKelvin => crate::units::ARCSEC_PER_RAD,
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
}

/// Change of the readings per display unit of a term, mm, by test; empty where it has none.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    pub by_test: Vec<Vec<f64>>,
}

fn derivative(problem: &Problem, test: usize, k: usize, s: &Sensitivity) -> f64 {
    debug_assert!(problem.tests[test].columns.contains(&k));
    match problem.unknowns[k].quantity {
        Quantity::Location { axis, component } => s.location[axis][component.index()],
        Quantity::Pivot { coordinate, .. } => s.pivot[coordinate],
        Quantity::SpindleBall { coordinate, .. } => {
            problem.session.tests[test].spindle_ball.sign(coordinate) * s.spindle[coordinate]
        }
        Quantity::Bar { .. } => 1.0,
    }
}

//! A set of effects with what it leaves of the readings. Which effects belong in it is for the search to say.

use super::selected::{Candidate, Found, Search, Step, Ways};
use crate::diagnose::model::linear_model::Ground;
use crate::diagnose::model::prior_penalty::Pulls;
use crate::diagnose::model::regression::{Accepted, Stage};
use crate::diagnose::noise::noise_floor::{likely_noise, masked};
use crate::statistics::{NoiseModel, misfit};

/// How a session stood before the search.
pub(crate) struct Start {
    pub(crate) noise: Vec<NoiseModel>,
    residual_mm2: f64,
}

impl Start {
    pub(crate) fn of(ways: &Ways, model: &Model) -> Start {
        Start { noise: model.noise.clone(), residual_mm2: mean_square(ways.grounds.fine, &model.residual_mm) }
    }
}

/// What a search has found so far.
#[derive(Clone)]
pub(crate) struct Model {
    /// Accepted columns on all rows and on averaged ones.
    pub(crate) columns: [Vec<Accepted>; 2],
    pub(crate) found: Vec<Found>,
    pub(crate) residual_mm: Vec<Vec<f64>>,
    /// How far balls, bars and location errors are then from what was stated of them.
    pub(crate) pulls: Pulls,
    pub(crate) noise: Vec<NoiseModel>,
    pub(crate) best_left: f64,
}

impl Model {
    pub(crate) fn empty(ways: &Ways) -> Model {
        let fine = ways.grounds.fine;
        let stage = Stage::on(ways.whitened[0].clone(), &[]);
        let (residual_mm, pulls) = (stage.residual_mm(&[]), stage.pulls());
        let noise = likely_noise(fine, &residual_mm, &ways.floors[0], &ways.floors[0]);
        let (columns, found) = ([Vec::new(), Vec::new()], Vec::new());
        Model { columns, found, residual_mm, pulls, noise, best_left: f64::NEG_INFINITY }
    }

    /// The same without one of its effects, fitted anew.
    pub(crate) fn without(&self, ways: &Ways, left_out: usize) -> Model {
        let mut model = Model::empty(ways);
        let others = self.found.iter().enumerate().filter(|(index, _)| *index != left_out);
        others.for_each(|(_, found)| model.take(ways, found.clone()));
        let fine = ways.grounds.fine;
        let stage = Stage::new(fine, &self.noise, &model.columns[0], &fine.kept);
        (model.residual_mm, model.pulls) = (stage.residual_mm(&model.columns[0]), stage.pulls());
        model.noise = likely_noise(fine, &model.residual_mm, &self.noise, &ways.floors[0]);
        model
    }

    /// Works out what each effect adds beside all others.
    pub(crate) fn weigh(&mut self, ways: &Ways) {
        if self.found.len() < 2 {
            return;
        }
        let whole = self.misfit(ways);
        for index in 0..self.found.len() {
            let gain = 0.5 * (self.without(ways, index).misfit(ways) - whole);
            self.found[index].beside_gain = gain;
        }
    }

    /// The result of a search that ends with this model.
    pub(crate) fn finished(self, ways: &Ways, start: Start) -> Search {
        Search {
            residual_before_mm2: start.residual_mm2,
            noise_before: start.noise,
            noise_after: self.noise,
            found: self.found,
            residual_mm: self.residual_mm,
            best_left: self.best_left,
            floor: ways.floors[0].clone(),
        }
    }

    /// Adds what a step found, with what it leaves.
    pub(crate) fn add(&mut self, ways: &Ways, step: Step) {
        self.take(ways, step.found);
        self.residual_mm = step.residual_mm;
        self.pulls = step.pulls;
        self.noise = step.noise;
    }

    /// Adds the columns of an effect.
    pub(crate) fn take(&mut self, ways: &Ways, found: Found) {
        let chosen = &found.chosen;
        let coarse = ways.grounds.coarse.columns(&chosen.effect, &chosen.terms).unwrap_or_default();
        let prior = chosen.judgement.tau.max(1.0);
        self.columns[1].extend(coarse.into_iter().map(|column| Accepted { column, prior }));
        self.columns[0].extend(chosen.accepted());
        self.found.push(found);
    }

    /// Twice the negative log likelihood of what it leaves, of readings and of what was stated of balls and bars.
    pub(crate) fn misfit(&self, ways: &Ways) -> f64 {
        pooled_misfit(ways.grounds.fine, &self.noise, &self.residual_mm) + self.pulls.misfit()
    }

    /// Log likelihood with its own noise, less what shapes and amplitudes cost.
    pub(crate) fn standing(&self, ways: &Ways) -> f64 {
        let cost: f64 = self.found.iter().map(|found| found.gain - found.log_odds).sum();
        -0.5 * self.misfit(ways) - cost
    }
}

/// The effect of whose form a free curve is the rest: one found before it at its place.
pub(crate) fn rest_of(found: &[Found], index: usize) -> Option<usize> {
    let own = &found.get(index)?.chosen;
    let is_lead = |other: &Found| other.chosen.effect.place == own.effect.place;
    own.is_free().then(|| found[..index].iter().position(is_lead)).flatten()
}

/// Mean square of the rows that take part, mm².
pub(crate) fn mean_square(ground: &Ground, residual_mm: &[Vec<f64>]) -> f64 {
    let kept = residual_mm
        .iter()
        .zip(&ground.kept)
        .flat_map(|(residual, kept)| residual.iter().zip(kept).filter(|(_, kept)| **kept));
    crate::statistics::rms(kept.map(|(value, _)| *value)).powi(2)
}

/// Residuals of each sweep without mean and trend over its rows.
pub(crate) fn without_trends(ground: &Ground, residual_mm: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let flattened = |(residual, kept): (&Vec<f64>, &Vec<bool>)| -> Vec<f64> {
        let rows = || (0..residual.len()).filter(|&row| kept[row]);
        let count = rows().count().max(1) as f64;
        let middle = rows().sum::<usize>() as f64 / count;
        let mean = rows().map(|row| residual[row]).sum::<f64>() / count;
        let squares: f64 = rows().map(|row| (row as f64 - middle).powi(2)).sum();
        let slope = rows().map(|row| (row as f64 - middle) * residual[row]).sum::<f64>() / squares.max(1.0);
        residual.iter().enumerate().map(|(row, value)| value - mean - slope * (row as f64 - middle)).collect()
    };
    residual_mm.iter().zip(&ground.kept).map(flattened).collect()
}

/// Twice the negative log likelihood of residuals under the noise of their tests, less a constant.
pub(crate) fn pooled_misfit(ground: &Ground, noise: &[NoiseModel], residual_mm: &[Vec<f64>]) -> f64 {
    let mut alike: Vec<(NoiseModel, Vec<Vec<f64>>)> = Vec::new();
    for (test, noise) in noise.iter().enumerate() {
        let masked = masked(ground, residual_mm, test);
        match alike.iter_mut().find(|(model, _)| model == noise) {
            Some((_, traces)) => traces.push(masked),
            None => alike.push((*noise, vec![masked])),
        }
    }
    alike.iter().map(|(noise, traces)| misfit(noise, traces)).sum()
}

/// The columns of a model with those of a candidate.
pub(crate) fn joined(model: &[Accepted], candidate: &Candidate) -> Vec<Accepted> {
    model.iter().cloned().chain(candidate.accepted()).collect()
}

//! A set of effects with what it leaves of the readings. Which effects belong in it is for the search to say.

pub(crate) use super::selected::JointFit;
use super::selected::{Candidate, Search, SelectedEffect, SelectionContext, Step};
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::regression::{Accepted, Regression};
use crate::diagnose::noise::noise_floor::{likely_noise, masked, only_kept};
use crate::identify;
use crate::statistics::{NoiseModel, misfit};

impl JointFit {
    /// Nothing: the same for every set that is begun.
    pub(crate) fn empty(selection: &SelectionContext) -> JointFit {
        selection.empty.get_or_init(|| JointFit::of_nothing(selection)).clone()
    }

    fn of_nothing(selection: &SelectionContext) -> JointFit {
        let fine = selection.resolutions.fine;
        let regression = Regression::on(selection.whitened[0].clone(), &[]);
        let (residual_mm, pulls) = (regression.residual_mm(&[]), regression.pulls());
        let noise = likely_noise(fine, &residual_mm, &selection.floors[0], &selection.floors[0]);
        let (columns, found) = ([Vec::new(), Vec::new()], Vec::new());
        JointFit { columns, found, residual_mm, pulls, noise, other: None }
    }

    /// The same without one of its effects, fitted anew.
    pub(crate) fn without(&self, selection: &SelectionContext, left_out: usize) -> JointFit {
        let others = self.found.iter().enumerate().filter(|(index, _)| *index != left_out);
        JointFit::of(selection, others.map(|(_, found)| found.clone()), &self.noise)
    }

    /// A set of effects, fitted under a noise.
    pub(crate) fn of(
        selection: &SelectionContext,
        found: impl Iterator<Item = SelectedEffect>,
        noise: &[NoiseModel],
    ) -> JointFit {
        let mut joint = JointFit::empty(selection);
        found.for_each(|found| joint.take(selection, found));
        let fine = selection.resolutions.fine;
        let regression = Regression::new(fine, noise, &joint.columns[0], &fine.kept);
        (joint.residual_mm, joint.pulls) = (regression.residual_mm(&joint.columns[0]), regression.pulls());
        joint.noise = likely_noise(fine, &joint.residual_mm, noise, &selection.floors[0]);
        joint
    }

    /// Works out what each effect adds beside all others.
    pub(crate) fn weigh(&mut self, selection: &SelectionContext) {
        if self.found.len() < 2 {
            return;
        }
        let whole = self.misfit(selection);
        for index in 0..self.found.len() {
            let gain = 0.5 * (self.without(selection, index).misfit(selection) - whole);
            self.found[index].beside_gain = gain;
        }
    }

    /// The result of a search that ends with this model; the mean square of the residual before it is given, mm².
    pub(crate) fn finished(self, selection: &SelectionContext, residual_before_mm2: f64) -> Search {
        Search {
            residual_before_mm2,
            noise_after: self.noise,
            found: self.found,
            beside: Vec::new(),
            residual_mm: self.residual_mm,
            other: self.other,
            floor: selection.floors[0].clone(),
            contenders: selection.contenders.take(),
            stated_misfit: self.pulls.misfit(),
        }
    }

    /// Adds what a step found, with what it leaves.
    pub(crate) fn add(&mut self, selection: &SelectionContext, step: Step) {
        self.take(selection, step.found);
        self.residual_mm = step.residual_mm;
        self.pulls = step.pulls;
        self.noise = step.noise;
    }

    /// Adds the columns of an effect.
    pub(crate) fn take(&mut self, selection: &SelectionContext, found: SelectedEffect) {
        let chosen = &found.chosen;
        let coarse = selection.resolutions.coarse.columns(&chosen.effect, &chosen.terms).unwrap_or_default();
        let prior = chosen.judgement.tau.max(1.0);
        self.columns[1].extend(coarse.into_iter().map(|column| Accepted { column, prior }));
        self.columns[0].extend(chosen.accepted());
        self.found.push(found);
    }

    /// Twice the negative log likelihood of what it leaves, of readings and of what was stated of balls and bars.
    pub(crate) fn misfit(&self, selection: &SelectionContext) -> f64 {
        pooled_misfit(selection.resolutions.fine, &self.noise, &self.residual_mm) + self.pulls.misfit()
    }

    /// Log likelihood with its own noise, less what shapes and amplitudes cost.
    pub(crate) fn standing(&self, selection: &SelectionContext) -> f64 {
        let cost: f64 = self.found.iter().map(|found| found.gain - found.log_odds).sum();
        -0.5 * self.misfit(selection) - cost
    }
}

/// Log likelihood of a reading that counts as gross, less the constant of normal densities in mm: one in two hundred is, and then it
/// lies anywhere within a millimetre (−5.3 + 0.9).
pub(crate) const LEFT_OUT: f64 = -4.4;

/// Factors of two by which the noise of a test may differ from that of the others; one of them is a standard deviation.
const LOUDER_OCTAVES: [f64; 8] = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0];

/// −2 log likelihood of a test's residuals where its noise is so many times louder or quieter as is likeliest, with what that costs.
fn misfit_at_any_loudness(noise: &NoiseModel, trace: Vec<f64>) -> f64 {
    let trace = [trace];
    let at = |octaves: &f64| misfit(&noise.scaled(octaves.exp2()), &trace) + octaves * octaves;
    LOUDER_OCTAVES.iter().map(at).fold(f64::INFINITY, f64::min)
}

/// How many rows have a value.
fn rows_with_a_value(trace: &[f64]) -> usize {
    trace.iter().filter(|value| value.is_finite()).count()
}

impl Search {
    /// Log likelihood of what it leaves, less what shapes and amplitudes cost; the noise of each test may be louder or quieter
    /// than what was fitted to all, and readings that lie far from the others count as left out where that is likelier.
    pub(crate) fn standing(&self, model: &LinearModel) -> f64 {
        let cost: f64 = self.found.iter().map(|found| found.gain - found.log_odds).sum();
        let near = identify::kept_rows(model.problem, &self.residual_mm);
        let of_test = |test: usize| {
            let all = masked(model, &self.residual_mm, test);
            let without_far = only_kept(&all, &near[test]);
            let far = rows_with_a_value(&all) - rows_with_a_value(&without_far);
            let misfit_of = |trace: Vec<f64>| misfit_at_any_loudness(&self.noise_after[test], trace);
            let least = if far > 0 { misfit_of(without_far) - 2.0 * LEFT_OUT * far as f64 } else { f64::INFINITY };
            least.min(misfit_of(all))
        };
        let readings: f64 = (0..self.residual_mm.len()).map(of_test).sum();
        -0.5 * (readings + self.stated_misfit) - cost
    }
}

/// The effect of whose form a free curve is the rest: one found before it at its place.
pub(crate) fn rest_of(found: &[SelectedEffect], index: usize) -> Option<usize> {
    let own = &found.get(index)?.chosen;
    let is_lead = |other: &SelectedEffect| other.chosen.effect.place == own.effect.place;
    own.is_free().then(|| found[..index].iter().position(is_lead)).flatten()
}

/// Mean square of the rows that take part, mm².
pub(crate) fn mean_square(model: &LinearModel, residual_mm: &[Vec<f64>]) -> f64 {
    let kept = residual_mm
        .iter()
        .zip(&model.kept)
        .flat_map(|(residual, kept)| residual.iter().zip(kept).filter(|(_, kept)| **kept));
    crate::statistics::rms(kept.map(|(value, _)| *value)).powi(2)
}

/// Residuals of each sweep without mean and trend over its rows.
pub(crate) fn without_trends(model: &LinearModel, residual_mm: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let flattened = |(residual, kept): (&Vec<f64>, &Vec<bool>)| -> Vec<f64> {
        let rows = || (0..residual.len()).filter(|&row| kept[row]);
        let count = rows().count().max(1) as f64;
        let middle = rows().sum::<usize>() as f64 / count;
        let mean = rows().map(|row| residual[row]).sum::<f64>() / count;
        let squares: f64 = rows().map(|row| (row as f64 - middle).powi(2)).sum();
        let slope = rows().map(|row| (row as f64 - middle) * residual[row]).sum::<f64>() / squares.max(1.0);
        residual.iter().enumerate().map(|(row, value)| value - mean - slope * (row as f64 - middle)).collect()
    };
    residual_mm.iter().zip(&model.kept).map(flattened).collect()
}

/// Twice the negative log likelihood of residuals under the noise of their tests, less a constant.
pub(crate) fn pooled_misfit(model: &LinearModel, noise: &[NoiseModel], residual_mm: &[Vec<f64>]) -> f64 {
    let mut alike: Vec<(NoiseModel, Vec<Vec<f64>>)> = Vec::new();
    for (test, noise) in noise.iter().enumerate() {
        let masked = masked(model, residual_mm, test);
        match alike.iter_mut().find(|(joint, _)| joint == noise) {
            Some((_, traces)) => traces.push(masked),
            None => alike.push((*noise, vec![masked])),
        }
    }
    alike.iter().map(|(noise, traces)| misfit(noise, traces)).sum()
}

/// The columns of a model with those of a candidate.
pub(crate) fn joined(joint: &[Accepted], candidate: &Candidate) -> Vec<Accepted> {
    joint.iter().cloned().chain(candidate.accepted()).collect()
}

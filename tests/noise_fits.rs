//! Noise of recordings: the filter against the covariance that it stands for, and fits against the noise that was drawn.

use crate::noisy::Draws;
use fiveaxis::statistics::{NoiseModel, Whitener, fit_noise, minimise_smooth, misfit};
use nalgebra::{DMatrix, DVector};

const NOISE: NoiseModel = NoiseModel { white_mm: 2e-4, ar_mm: 3e-4, ar_rho: 0.9, drift_mm: 4e-4, offset_mm: 1e-4 };

/// Covariance of the readings of a trace, by the definition of the noise.
fn covariance(noise: &NoiseModel, present: &[bool]) -> DMatrix<f64> {
    let rows: Vec<usize> = (0..present.len()).filter(|&row| present[row]).collect();
    let walk = noise.drift_mm.powi(2) / present.len() as f64;
    DMatrix::from_fn(rows.len(), rows.len(), |a, b| {
        let (i, j) = (rows[a], rows[b]);
        let white = if i == j { noise.white_mm.powi(2) } else { 0.0 };
        let correlated = noise.ar_mm.powi(2) * noise.ar_rho.powi(i.abs_diff(j) as i32);
        white + correlated + noise.offset_mm.powi(2) + walk * i.min(j) as f64
    })
}

/// Traces of different lengths with gaps, more than are filtered side by side.
fn traces(draws: &mut Draws) -> Vec<Vec<bool>> {
    let lengths = [31, 7, 50, 50, 18, 64, 9, 33, 40, 12, 25];
    lengths.into_iter().map(|rows| (0..rows).map(|_| draws.normal() > -1.0).collect()).collect()
}

#[test]
fn filters_side_by_side_stand_for_the_covariance() {
    let mut draws = Draws(11);
    let present = traces(&mut draws);
    let rows: Vec<&[bool]> = present.iter().map(Vec::as_slice).collect();
    let together = Whitener::of_all(&NOISE, &rows);
    assert_eq!(together.len(), rows.len());
    for (present, filter) in present.iter().zip(&together) {
        let readings: Vec<f64> =
            present.iter().map(|read| if *read { 1e-3 * draws.normal() } else { f64::NAN }).collect();
        let own = DVector::from_vec(readings.iter().copied().filter(|reading| reading.is_finite()).collect());
        let factor = covariance(&NOISE, present).cholesky().expect("definite");
        let expected = own.dot(&factor.solve(&own));
        let log_determinant = 2.0 * factor.l_dirty().diagonal().iter().map(|pivot| pivot.ln()).sum::<f64>();
        for filter in [filter, &Whitener::new(&NOISE, present)] {
            let mut white: Vec<f64> =
                readings.iter().map(|reading| if reading.is_finite() { *reading } else { 0.0 }).collect();
            filter.apply(&mut white);
            let squares: f64 = white.iter().map(|value| value * value).sum();
            assert!((squares / expected - 1.0).abs() < 1e-9, "{squares} for {expected}");
            assert!((filter.log_determinant - log_determinant).abs() < 1e-8, "{}", filter.log_determinant);
        }
    }
}

/// Traces with this noise, as its definition draws it.
fn drawn(noise: &NoiseModel, traces: usize, rows: usize, draws: &mut Draws) -> Vec<Vec<f64>> {
    let trace = |_| {
        let (mut correlated, mut walk) = (noise.ar_mm * draws.normal(), noise.offset_mm * draws.normal());
        let step = noise.drift_mm / (rows as f64).sqrt();
        (0..rows)
            .map(|_| {
                let reading = noise.white_mm * draws.normal() + correlated + walk;
                let kept = (1.0 - noise.ar_rho.powi(2)).sqrt();
                correlated = noise.ar_rho * correlated + kept * noise.ar_mm * draws.normal();
                walk += step * draws.normal();
                reading
            })
            .collect()
    };
    (0..traces).map(trace).collect()
}

#[test]
fn the_likeliest_noise_is_likelier_than_the_true_one_and_near_it() {
    let mut draws = Draws(23);
    let kinds = [
        NoiseModel { ar_mm: 5e-6, drift_mm: 5e-6, offset_mm: 0.0, ..NOISE },
        NoiseModel { drift_mm: 5e-6, offset_mm: 0.0, ..NOISE },
        NoiseModel { offset_mm: 0.0, ..NOISE },
        NoiseModel { ar_rho: 0.99, offset_mm: 0.0, ..NOISE },
    ];
    for noise in kinds {
        let traces = drawn(&noise, 20, 400, &mut draws);
        // from where the readings themselves lead, from a start that is far, and from the truth
        let far = NoiseModel { white_mm: 2e-3, ar_mm: 1e-5, ar_rho: 0.5, drift_mm: 2e-3, offset_mm: 0.0 };
        for start in [None, Some(far), Some(noise)] {
            let found = fit_noise(&traces, &[], start);
            let (is, true_one) = (misfit(&found, &traces), misfit(&noise, &traces));
            // twice the gain in log likelihood of four numbers is of χ² with four degrees of freedom
            assert!(
                (-25.0..0.1).contains(&(is - true_one)),
                "{is} for {true_one}: {found:?} for {noise:?} from {start:?}"
            );
            assert!((found.rms_mm() / noise.rms_mm() - 1.0).abs() < 0.1, "{found:?} for {noise:?}");
        }
    }
}

#[test]
fn a_narrow_bent_valley_is_followed_to_its_end() {
    // Rosenbrock's function, across its valley as steep as the likelihood of some 40,000 readings, from near and from far
    let cost = |[x, y]: &[f64; 2]| 1e2 * ((1.0 - x).powi(2) + 100.0 * (y - x * x).powi(2));
    for start in [[1.1, 1.3], [-1.2, 1.0], [4.0, -3.0]] {
        let found = minimise_smooth(start, cost);
        assert!(cost(&found) < 0.01, "{found:?} from {start:?}: {}", cost(&found));
    }
}

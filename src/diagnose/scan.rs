//! The least of a function of one number that has several valleys: a grid first, then halved steps.

use rayon::prelude::*;

/// Steps of the grid to either side.
const GRID: i32 = 40;

/// Halvings of the grid's step, from some mm down to less than a µm.
const HALVINGS: usize = 22;

/// Where a function is least within 40 steps of zero, and how much it is there.
pub(super) fn least_along(of: &(impl Fn(f64) -> f64 + Sync), step: f64) -> (f64, f64) {
    let at = |k: i32| f64::from(k) * step;
    let grid: Vec<(f64, f64)> = (-GRID..=GRID).into_par_iter().map(|k| (at(k), of(at(k)))).collect();
    // of equals the unmoved one
    let unmoved = grid[GRID as usize];
    let (mut best, mut least) = grid.into_iter().fold(unmoved, |best, next| if next.1 < best.1 { next } else { best });
    let mut width = step;
    for _ in 0..HALVINGS {
        width *= 0.5;
        for shift in [best - width, best + width] {
            let next = of(shift);
            if next < least {
                (best, least) = (shift, next);
            }
        }
    }
    (best, least)
}

//! Least values of functions that are cheap but not smooth.

use rayon::prelude::*;

/// Steps of the grid to either side.
const GRID: i32 = 40;

/// Halvings of the grid's step, from some mm down to less than a µm.
const HALVINGS: usize = 22;

/// Where a function is least within 40 steps of zero, and how much it is there.
pub fn least_along(of: &(impl Fn(f64) -> f64 + Sync), step: f64) -> (f64, f64) {
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

/// Nelder–Mead in a few variables from `start` with first steps of `size`, restarted once to leave a collapsed simplex.
pub fn minimise_few<const N: usize>(start: [f64; N], size: f64, cost: impl Fn(&[f64; N]) -> f64) -> [f64; N] {
    let mut best = start;
    for round in 0..2 {
        let spread = size / (1 + 2 * round) as f64;
        let mut simplex: Vec<([f64; N], f64)> = (0..=N)
            .map(|vertex| {
                let mut x = best;
                if vertex > 0 {
                    x[vertex - 1] += spread;
                }
                (x, cost(&x))
            })
            .collect();
        for _ in 0..22 * N + 2 {
            simplex.sort_by(|one, other| one.1.total_cmp(&other.1));
            if simplex[N].1 - simplex[0].1 < 0.02 {
                break;
            }
            let centre: [f64; N] =
                std::array::from_fn(|k| simplex[..N].iter().map(|(x, _)| x[k]).sum::<f64>() / N as f64);
            let worst = simplex[N];
            let along = |t: f64| -> [f64; N] { std::array::from_fn(|k| centre[k] + t * (worst.0[k] - centre[k])) };
            let try_at = |t: f64| (along(t), cost(&along(t)));
            let reflected = try_at(-1.0);
            simplex[N] = if reflected.1 < simplex[0].1 {
                let expanded = try_at(-2.0);
                if expanded.1 < reflected.1 { expanded } else { reflected }
            } else if reflected.1 < simplex[N - 1].1 {
                reflected
            } else {
                let inside = try_at(if reflected.1 < worst.1 { -0.5 } else { 0.5 });
                if inside.1 < worst.1.min(reflected.1) {
                    inside
                } else {
                    let lead = simplex[0].0;
                    for vertex in simplex.iter_mut().skip(1) {
                        let x: [f64; N] = std::array::from_fn(|k| lead[k] + 0.5 * (vertex.0[k] - lead[k]));
                        *vertex = (x, cost(&x));
                    }
                    continue;
                }
            };
        }
        simplex.sort_by(|one, other| one.1.total_cmp(&other.1));
        best = simplex[0].0;
    }
    best
}

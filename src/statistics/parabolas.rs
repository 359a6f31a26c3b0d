//! Parabolas through the neighbourhood of every row: what a smooth course would be there, and its slope.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};

/// Rows of a neighbourhood that are looked at: more of them say nothing more, and cost.
const MOST_OF_WINDOW: usize = 200;
/// Fewest rows of a neighbourhood: three determine a parabola, these also what it leaves.
const FEWEST_OF_WINDOW: usize = 8;
/// Times what neighbourhoods usually leave, from which on there is a corner within.
const CORNER: f64 = 2.0;

/// A parabola at a row.
#[derive(Debug, Clone, Copy)]
pub struct Local {
    pub value: f64,
    /// Root mean square of what it leaves of the rows about it.
    left: f64,
}

/// The parabola about every row through those within `half` of it; values that are not finite are passed over, abscissas rise. At a corner it
/// lies on the side that it fits. `None` for rows that have too few about them.
pub fn parabolas(x: &[f64], y: &[f64], half: f64) -> Vec<Option<Local>> {
    let of_row = |row: usize, (before, after): (f64, f64)| {
        let (from, to) = (x[row] - half * before, x[row] + half * after);
        parabola(x, y, x[row], x.partition_point(|&x| x < from)..x.partition_point(|&x| x <= to))
    };
    let centred: Vec<Option<Local>> = (0..x.len()).map(|row| of_row(row, (1.0, 1.0))).collect();
    let usual = super::median(centred.iter().flatten().map(|local| local.left)).unwrap_or_default();
    let at_row = |(row, local): (usize, Option<Local>)| {
        let sides = || [of_row(row, (2.0, 0.0)), of_row(row, (0.0, 2.0))].into_iter().flatten();
        let nearer = |best: Local, side: Local| if side.left < best.left { side } else { best };
        local.map(|local| if local.left > CORNER * usual { sides().fold(local, nearer) } else { local })
    };
    centred.into_iter().enumerate().map(at_row).collect()
}

/// The parabola through some rows, at an abscissa.
fn parabola(x: &[f64], y: &[f64], at: f64, rows: Range<usize>) -> Option<Local> {
    let stride = rows.len().div_ceil(MOST_OF_WINDOW).max(1);
    let points = || rows.clone().step_by(stride).map(|row| (x[row] - at, y[row])).filter(|(_, y)| y.is_finite());
    if points().count() < FEWEST_OF_WINDOW {
        return None;
    }
    // in units of the widest distance, or the matrix would be singular by its units alone
    let widest = points().map(|(d, _)| d.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let terms = |d: f64| Vector3::new(1.0, d / widest, (d / widest).powi(2));
    let (mut products, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (d, y) in points() {
        let terms = terms(d);
        products += terms * terms.transpose();
        right += terms * y;
    }
    let fitted = products.cholesky()?.solve(&right);
    let squares: f64 = points().map(|(d, y)| (y - fitted.dot(&terms(d))).powi(2)).sum();
    Some(Local { value: fitted[0], left: (squares / points().count() as f64).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::parabolas;

    #[test]
    fn a_corner_stays_and_scatter_goes() {
        let time_s: Vec<f64> = (0..1000).map(|row| row as f64 * 0.01).collect();
        let way = |t: f64| if t < 5.0 { 10.0 * t } else { 100.0 - 10.0 * t };
        let scatter = |row: usize| ((row * 7919 % 1000) as f64 / 1000.0 - 0.5) * 0.2;
        let mut noisy: Vec<f64> = time_s.iter().enumerate().map(|(row, &t)| way(t) + scatter(row)).collect();
        let even = parabolas(&time_s, &noisy, 0.5);
        let off = |row: usize| (even[row].unwrap().value - way(time_s[row])).abs();
        assert!((0..1000).all(|row| off(row) < 0.1), "{:?}", (0..1000).map(off).fold(0.0, f64::max));
        let squares: f64 = (0..1000).map(|row| off(row).powi(2)).sum();
        assert!((squares / 1000.0).sqrt() < 0.02);
        assert!(parabolas(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0], 9.0).iter().all(Option::is_none));
        // values that are kept back
        noisy[300..340].fill(f64::NAN);
        let gap: Vec<bool> = parabolas(&time_s, &noisy, 0.06).iter().map(Option::is_none).collect();
        assert!(gap[320] && !gap[280] && !gap[360]);
    }
}

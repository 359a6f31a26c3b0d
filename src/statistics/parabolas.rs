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
    /// Per unit of the abscissa.
    pub slope: f64,
    /// Root mean square of what it leaves of its neighbourhood.
    pub left: f64,
}

/// What belongs to the neighbourhood of a row, on either side of it.
#[derive(Debug, Clone, Copy)]
pub enum Neighbours {
    /// Rows whose abscissas differ by so much at most.
    Within(f64),
    /// So many rows.
    Rows(usize),
}

impl Neighbours {
    /// Rows from `before` to `after` sides away from a row.
    fn of(self, x: &[f64], row: usize, (before, after): (usize, usize)) -> Range<usize> {
        match self {
            Neighbours::Within(half) => {
                let (from, to) = (x[row] - half * before as f64, x[row] + half * after as f64);
                x.partition_point(|&x_row| x_row < from)..x.partition_point(|&x_row| x_row <= to)
            }
            Neighbours::Rows(count) => {
                // at an end as many on the other side
                let all = x.len().min((before + after) * count + 1);
                let from = row.saturating_sub(count * before).min(x.len() - all);
                from..from + all
            }
        }
    }
}

/// The parabola about every row through its neighbours; values that are not finite are passed over, abscissas rise. At a corner it
/// lies on the side that it fits. `None` for rows that have too few.
pub fn parabolas(x: &[f64], y: &[f64], neighbours: Neighbours) -> Vec<Option<Local>> {
    let of_row = |row: usize, sides: (usize, usize)| parabola(x, y, x[row], neighbours.of(x, row, sides));
    let centred: Vec<Option<Local>> = (0..x.len()).map(|row| of_row(row, (1, 1))).collect();
    let usual = super::median(centred.iter().flatten().map(|local| local.left)).unwrap_or_default();
    let at_row = |(row, local): (usize, Option<Local>)| {
        let sides = || [of_row(row, (2, 0)), of_row(row, (0, 2))].into_iter().flatten();
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
    Some(Local { value: fitted[0], slope: fitted[1] / widest, left: (squares / points().count() as f64).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::{Local, Neighbours, parabolas};

    #[test]
    fn a_corner_stays_and_scatter_goes() {
        let time_s: Vec<f64> = (0..1000).map(|row| row as f64 * 0.01).collect();
        let way = |t: f64| if t < 5.0 { 10.0 * t } else { 100.0 - 10.0 * t };
        let mut scatter = (0..1000).map(|row| ((row * 7919 % 1000) as f64 / 1000.0 - 0.5) * 0.2);
        let mut noisy: Vec<f64> = time_s.iter().map(|&t| way(t) + scatter.next().unwrap()).collect();
        let even = parabolas(&time_s, &noisy, Neighbours::Within(0.5));
        let even: Vec<Local> = even.into_iter().map(Option::unwrap).collect();
        let off = |row: usize| (even[row].value - way(time_s[row])).abs();
        assert!((0..1000).all(|row| off(row) < 0.1), "{:?}", (0..1000).map(off).fold(0.0, f64::max));
        let squares: f64 = (0..1000).map(|row| off(row).powi(2)).sum();
        assert!((squares / 1000.0).sqrt() < 0.02);
        assert!((even[250].slope - 10.0).abs() < 0.2 && (even[750].slope + 10.0).abs() < 0.2);
        assert!(parabolas(&time_s, &noisy, Neighbours::Rows(6)).iter().all(Option::is_some));
        assert!(parabolas(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0], Neighbours::Rows(9)).iter().all(Option::is_none));
        // readings that are kept back
        noisy[300..340].fill(f64::NAN);
        let gap: Vec<bool> = parabolas(&time_s, &noisy, Neighbours::Rows(6)).iter().map(Option::is_none).collect();
        assert!(gap[320] && !gap[280] && !gap[360]);
    }
}

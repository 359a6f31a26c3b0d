//! Two turns that bring one direction onto another: `R(k1, a)·R(k2, b)·from = to`. Closed form, no machine.

use nalgebra::Vector3;

/// Solutions of the two turns, rad.
#[derive(Debug, Clone, PartialEq)]
pub enum TwoTurns {
    /// One or two pairs (first, second).
    Pairs(Vec<(f64, f64)>),
    /// `to` lies along the first axis: the first turn is free, the second is this.
    FirstFree(f64),
    /// `from` lies along the second axis: the second turn is free, the first is this.
    SecondFree(f64),
    /// `to` is this far from every direction that can be reached, rad; the nearest pair is given.
    OutOfReach { by_rad: f64, nearest: (f64, f64) },
    /// The axes are parallel: two turns are one.
    Parallel,
}

/// Directions nearer to an axis than this are taken as along it, rad: rounding of products of rotations stays below.
const ALONG_WITHIN_RAD: f64 = 1e-13;
/// `to` beyond the reach by no more than this is at its edge, rad.
const AT_THE_EDGE: f64 = 1e-12;

/// Solves the two turns; `k1`, `k2`, `from` and `to` are unit vectors.
///
/// With z the direction after the second turn, `z·k2 = from·k2` and `z·k1 = to·k1`, so that
/// `z = α k1 + β k2 ± γ k1×k2` (Murray, Li, Sastry 1994, section 3.3.2, subproblem 2).
pub fn two_turns(k1: &Vector3<f64>, k2: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> TwoTurns {
    let normal = k1.cross(k2);
    let across = normal.norm_squared();
    if across < ALONG_WITHIN_RAD * ALONG_WITHIN_RAD {
        return TwoTurns::Parallel;
    }
    let [first_free, second_free] = [to.cross(k1).norm() < ALONG_WITHIN_RAD, from.cross(k2).norm() < ALONG_WITHIN_RAD];
    let (along, one, two) = (k1.dot(k2), k1.dot(to), k2.dot(from));
    let (alpha, beta) = ((one - along * two) / across, (two - along * one) / across);
    let rest = 1.0 - alpha * alpha - beta * beta - 2.0 * alpha * beta * along;
    // the angles of `to` and of k2's circle about k1 and between the axes decide the reach
    let (lowest, highest) = reach(k1, k2, from);
    let off = angle(k1, to);
    let by_rad = (lowest - off).max(off - highest).max(0.0);
    if by_rad > AT_THE_EDGE {
        return TwoTurns::OutOfReach {
            by_rad,
            nearest: nearest(k1, k2, from, to, if off < lowest { lowest } else { highest }),
        };
    }
    let gamma = (rest.max(0.0) / across).sqrt();
    let base = k1 * alpha + k2 * beta;
    if first_free {
        return TwoTurns::FirstFree(turn_between(k2, from, &base));
    }
    if second_free {
        return TwoTurns::SecondFree(turn_between(k1, &base, to));
    }
    let mut pairs = Vec::with_capacity(2);
    for side in [1.0, -1.0] {
        let z = base + normal * (side * gamma);
        let pair = (turn_between(k1, &z, to), turn_between(k2, from, &z));
        let is_new = pairs.iter().all(|other: &(f64, f64)| {
            let apart = |a: f64, b: f64| ((a - b) / 2.0).sin().abs();
            apart(other.0, pair.0) + apart(other.1, pair.1) > 1e-9
        });
        if is_new {
            pairs.push(pair);
        }
    }
    TwoTurns::Pairs(pairs)
}

/// Smallest and largest angle from `k1` that two turns can give a direction, rad.
pub(super) fn reach(k1: &Vector3<f64>, k2: &Vector3<f64>, from: &Vector3<f64>) -> (f64, f64) {
    let (tilt, radius) = (angle(k1, k2), angle(k2, from));
    let highest = tilt + radius;
    ((tilt - radius).abs(), highest.min(2.0 * std::f64::consts::PI - highest))
}

/// Angle between directions, rad, exact near 0 and π too.
pub(super) fn angle(one: &Vector3<f64>, other: &Vector3<f64>) -> f64 {
    one.cross(other).norm().atan2(one.dot(other))
}

/// Turn about `k` that brings the part of `from` across it onto that of `to`, rad, −π … π.
pub(super) fn turn_between(k: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    let (a, b) = (from - k * k.dot(from), to - k * k.dot(to));
    k.dot(&a.cross(&b)).atan2(a.dot(&b))
}

/// The pair that brings `from` nearest to a `to` out of reach: at the edge `edge` (rad from `k1`) of the reach.
fn nearest(k1: &Vector3<f64>, k2: &Vector3<f64>, from: &Vector3<f64>, to: &Vector3<f64>, edge: f64) -> (f64, f64) {
    let aside = to - k1 * k1.dot(to);
    // along k1 every direction of the edge is as near as another
    let aside = aside.try_normalize(ALONG_WITHIN_RAD).unwrap_or_else(|| (k2 - k1 * k1.dot(k2)).normalize());
    let at_edge = k1 * edge.cos() + aside * edge.sin();
    let normal = k1.cross(k2);
    let (along, one, two) = (k1.dot(k2), k1.dot(&at_edge), k2.dot(from));
    let across = normal.norm_squared();
    let z = k1 * ((one - along * two) / across) + k2 * ((two - along * one) / across);
    (turn_between(k1, &z, &at_edge), turn_between(k2, from, &z))
}

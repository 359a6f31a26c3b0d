//! Rows of one socket in which the ball sat in another: a socket that the session file left out. It places nothing.

use nalgebra::Vector3;

/// Groups nearer to each other than so many times their own spread are one.
const APART: f64 = 4.0;
/// The same in mm. The places are those of the nominal chain, whose dimensions are off by millimetres: poses from two sides put one
/// ball in two places. Sockets are farther from each other than balls are thick.
const LEAST_MM: f64 = 15.0;
/// Rows that a group needs.
const LEAST_ROWS: usize = 3;
/// Rounds in which rows find the nearer group.
const ROUNDS: usize = 20;

/// What is wrong with the places of a ball (mm, row by row, of the nominal chain) that should be one place; `None`: nothing. `others_mm`
/// is how far the places of other sockets scatter: so far off is the nominal chain.
pub(super) fn second_socket(places: &[Vector3<f64>], others_mm: f64) -> Option<String> {
    let groups = halves(places)?;
    let rows = |wanted: bool| groups.iter().enumerate().filter(move |(_, group)| **group == wanted).map(|(row, _)| row);
    let (one, other) = (rows(false).count(), rows(true).count());
    if one.min(other) < LEAST_ROWS {
        return None;
    }
    let centres = [false, true].map(|group| mean(rows(group).map(|row| places[row])));
    let apart_mm = (centres[0] - centres[1]).norm();
    let off = |(row, group): (usize, &bool)| (places[row] - centres[usize::from(*group)]).norm_squared();
    let spread_mm = (groups.iter().enumerate().map(off).sum::<f64>() / places.len() as f64).sqrt();
    if apart_mm < LEAST_MM || apart_mm < APART * spread_mm.max(others_mm) {
        return None;
    }
    let fewer = other <= one;
    let first = rows(fewer).next()? + 1;
    Some(format!(
        "{} of {} rows, row {first} the first of them, put the ball {apart_mm:.0} mm from where the others put it: it sat in another \
         socket; give each socket a test of its own, or the same one a new setup where it was moved",
        one.min(other),
        places.len()
    ))
}

/// How far places scatter about their mean, mm.
pub(super) fn scatter_mm(places: &[Vector3<f64>]) -> f64 {
    let middle = mean(places.iter().copied());
    (places.iter().map(|place| (place - middle).norm_squared()).sum::<f64>() / places.len().max(1) as f64).sqrt()
}

/// Group of every row, about two means that start at the places farthest from each other.
fn halves(places: &[Vector3<f64>]) -> Option<Vec<bool>> {
    let farthest = |from: &Vector3<f64>| {
        places.iter().copied().max_by(|a, b| (a - from).norm_squared().total_cmp(&(b - from).norm_squared()))
    };
    let one = farthest(&mean(places.iter().copied()))?;
    let mut centres = [one, farthest(&one)?];
    let mut groups = vec![false; places.len()];
    for _ in 0..ROUNDS {
        for (group, place) in groups.iter_mut().zip(places) {
            *group = (place - centres[1]).norm_squared() < (place - centres[0]).norm_squared();
        }
        let of = |wanted: bool| groups.iter().zip(places).filter(move |(group, _)| **group == wanted);
        centres = [false, true].map(|wanted| mean(of(wanted).map(|(_, place)| *place)));
    }
    Some(groups)
}

fn mean(places: impl Iterator<Item = Vector3<f64>>) -> Vector3<f64> {
    let (sum, count) = places.fold((Vector3::zeros(), 0usize), |(sum, count), place| (sum + place, count + 1));
    sum / count.max(1) as f64
}

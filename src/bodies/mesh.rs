//! Triangle meshes to convex pieces that cover every triangle; reads no files.
//!
//! Each piece is the hull of a subset of the triangles, so the pieces together cover the whole surface: a part that
//! enters the body passes through a piece. A decomposition may fill hollows between its pieces, never open the surface.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::Solid;
use super::solid::hull;

/// Most triangles of a mesh; larger ones are to be simplified before.
pub const MAX_TRIANGLES: usize = 200_000;
/// Most pieces of one mesh.
const MAX_PIECES: usize = 24;
/// A split is kept when its two hulls take at most this part of the volume of the hull they replace.
const WORTHWHILE: f64 = 0.85;

/// Why a mesh was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MeshError {
    #[error("has {found} triangles; at most {MAX_TRIANGLES} are allowed, simplify the mesh")]
    TooMany { found: usize },
    #[error("has {open} open edges (holes), the first at ({x:.3}, {y:.3}, {z:.3}) mm; close the mesh")]
    Open { open: usize, x: f64, y: f64, z: f64 },
    #[error("has no triangle")]
    Empty,
    #[error("is flat or degenerate: it encloses no volume")]
    Flat,
    #[error("has a corner that is not a finite number")]
    NotFinite,
}

/// Convex pieces whose union covers the mesh; corners in the mesh's frame, mm.
pub fn convex_pieces(triangles: &[[Vector3<f64>; 3]]) -> Result<Vec<Solid>, MeshError> {
    if triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    if triangles.len() > MAX_TRIANGLES {
        return Err(MeshError::TooMany { found: triangles.len() });
    }
    if triangles.iter().flatten().any(|corner| !corner.iter().all(|value| value.is_finite())) {
        return Err(MeshError::NotFinite);
    }
    refuse_open_edges(triangles)?;
    let (corners, volume) = hull(triangles.iter().flatten()).ok_or(MeshError::Flat)?;
    if volume <= 0.0 {
        return Err(MeshError::Flat);
    }
    let mut pieces = vec![(triangles.to_vec(), corners, volume)];
    let mut next = 0;
    while next < pieces.len() {
        match (pieces.len() < MAX_PIECES).then(|| split(&pieces[next].0, pieces[next].2)).flatten() {
            Some([one, other]) => {
                pieces[next] = one;
                pieces.push(other);
            }
            None => next += 1,
        }
    }
    Ok(pieces.into_iter().map(|(_, corners, _)| Solid::Hull { corners }).collect())
}

type Piece = (Vec<[Vector3<f64>; 3]>, Vec<Vector3<f64>>, f64);

/// The better of the three halvings across the coordinate directions, if it is worthwhile.
fn split(triangles: &[[Vector3<f64>; 3]], volume: f64) -> Option<[Piece; 2]> {
    let centre = |t: &[Vector3<f64>; 3], k: usize| (t[0][k] + t[1][k] + t[2][k]) / 3.0;
    let mut best: Option<([Piece; 2], f64)> = None;
    for k in 0..3 {
        let (low, high) = triangles
            .iter()
            .fold((f64::MAX, f64::MIN), |(low, high), t| (low.min(centre(t, k)), high.max(centre(t, k))));
        for part in [0.25, 0.5, 0.75] {
            let at = low + (high - low) * part;
            let (one, other): (Vec<_>, Vec<_>) = triangles.iter().copied().partition(|t| centre(t, k) < at);
            if let (Some((c1, v1)), Some((c2, v2))) = (hull(one.iter().flatten()), hull(other.iter().flatten()))
                && best.as_ref().is_none_or(|(_, total)| v1 + v2 < *total)
            {
                best = Some(([(one, c1, v1), (other, c2, v2)], v1 + v2));
            }
        }
    }
    best.filter(|(_, total)| *total < WORTHWHILE * volume).map(|(pieces, _)| pieces)
}

/// Every edge of a closed mesh belongs to two triangles.
fn refuse_open_edges(triangles: &[[Vector3<f64>; 3]]) -> Result<(), MeshError> {
    // STL repeats corners with rounding: 1e-4 mm merges them
    let key = |p: &Vector3<f64>| p.map(|value| (value * 1e4).round() as i64);
    let mut edges: HashMap<[Vector3<i64>; 2], (i32, Vector3<f64>)> = HashMap::new();
    for triangle in triangles {
        for k in 0..3 {
            let (a, b) = (key(&triangle[k]), key(&triangle[(k + 1) % 3]));
            if a == b {
                continue;
            }
            let forward = a.as_slice() < b.as_slice();
            let edge = if forward { [a, b] } else { [b, a] };
            edges.entry(edge).or_insert((0, triangle[k])).0 += if forward { 1 } else { -1 };
        }
    }
    let mut open: Vec<Vector3<f64>> = edges.values().filter(|(count, _)| *count != 0).map(|(_, at)| *at).collect();
    open.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    match open.first() {
        None => Ok(()),
        Some(at) => Err(MeshError::Open { open: open.len(), x: at.x, y: at.y, z: at.z }),
    }
}

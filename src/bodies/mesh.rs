//! Triangle meshes to convex pieces that cover every triangle; reads no files.
//!
//! Each piece is the hull of the triangles on one side of some cuts across x, y and z, so the pieces together cover the whole
//! surface: a part that enters the body passes through a piece. Hollows may be filled, the surface is never opened.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::Solid;
use super::solid::{Hull, MAX_CORNERS, hull};

/// Most triangles of a mesh; larger ones are to be simplified before.
pub const MAX_TRIANGLES: usize = 200_000;
/// Most pieces of one mesh.
const MAX_PIECES: usize = 24;
/// Triangles on which a cut is chosen.
const COARSE_TRIANGLES: usize = 1_000;
/// Corners of a hull by which cuts are compared.
const ROUGH_CORNERS: usize = 64;
/// Places where corners gather that are tried as cuts, in each direction.
const CUTS: usize = 6;
/// Cuts are kept when the pieces take at most this part of the volume of the hull they replace.
const WORTHWHILE: f64 = 0.9;
/// Hollows less deep than this part of the mesh's diagonal stay filled.
const DEPTH_SHARE: f64 = 0.01;
/// A cut replaces another when it saves at least this part of the volume: between equals the first is taken.
const LEAST_SAVING: f64 = 1e-3;
/// Corners nearer than this are one, mm: STL repeats corners with rounding.
const SAME_MM: f64 = 1e-4;

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

/// Three corners, mm.
pub type Triangle = [Vector3<f64>; 3];

/// Convex pieces whose union covers the mesh; corners in the mesh's frame, mm.
pub fn convex_pieces(triangles: &[Triangle]) -> Result<Vec<Solid>, MeshError> {
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
    let whole = Piece::of(triangles.to_vec(), MAX_CORNERS).ok_or(MeshError::Flat)?;
    Ok(cut_up(whole).into_iter().map(|hull| Solid::Hull { corners: hull.simplified() }).collect())
}

/// Some triangles with their hull.
struct Piece {
    triangles: Vec<Triangle>,
    hull: Hull,
}

impl Piece {
    fn of(triangles: Vec<Triangle>, corners: usize) -> Option<Piece> {
        Some(Piece { hull: hull(triangles.iter().flatten(), corners)?, triangles })
    }

    /// Triangles from all over, few enough to try cuts on.
    fn coarse(&self) -> Vec<Triangle> {
        let count = self.triangles.len();
        if count <= COARSE_TRIANGLES {
            return self.triangles.clone();
        }
        // by the golden section: a fixed step falls into the rhythm of rows and columns
        let part = |k: usize| (k as f64 * 0.618_033_988_749_895).fract();
        (0..COARSE_TRIANGLES).map(|k| self.triangles[(part(k) * count as f64) as usize]).collect()
    }

    /// Depth of the deepest corner or middle of a triangle below the hull's surface, mm.
    fn hollow_mm(&self) -> f64 {
        let planes = self.hull.planes();
        let depth = |p: &Vector3<f64>| planes.iter().map(|(normal, at)| at - normal.dot(p)).fold(f64::MAX, f64::min);
        let deepest = |t: &Triangle| {
            let middle = (t[0] + t[1] + t[2]) / 3.0;
            t.iter().chain([&middle]).map(depth).fold(0.0, f64::max)
        };
        self.coarse().iter().map(deepest).fold(0.0, f64::max)
    }
}

/// A piece with the two it was cut into.
struct Node {
    piece: Piece,
    parts: Option<[usize; 2]>,
    is_settled: bool,
}

/// Cuts the hollow pieces, the largest first, then puts back together what gained nothing.
///
/// A single cut through a frame gains nothing: the gain shows only when its parts are cut again, hence the tree.
fn cut_up(whole: Piece) -> Vec<Hull> {
    let shallow_mm = DEPTH_SHARE * whole.hull.diagonal_mm();
    let mut nodes = vec![Node { piece: whole, parts: None, is_settled: false }];
    let mut pieces = 1;
    while pieces < MAX_PIECES {
        let open = (0..nodes.len()).filter(|&n| nodes[n].parts.is_none() && !nodes[n].is_settled);
        let volume = |n: &usize| nodes[*n].piece.hull.volume_mm3;
        let Some(next) = open.max_by(|a, b| volume(a).total_cmp(&volume(b))) else { break };
        let piece = &nodes[next].piece;
        match (piece.hollow_mm() > shallow_mm).then(|| split(piece)).flatten() {
            Some(parts) => {
                nodes[next].parts = Some([nodes.len(), nodes.len() + 1]);
                nodes.extend(parts.map(|piece| Node { piece, parts: None, is_settled: false }));
                pieces += 1;
            }
            None => nodes[next].is_settled = true,
        }
    }
    let mut kept = Vec::new();
    gather(&nodes, 0, &mut kept);
    kept.into_iter().map(|n| nodes[n].piece.hull.clone()).collect()
}

/// The pieces of a node, or itself where they gain too little; their volume together, mm³.
fn gather(nodes: &[Node], node: usize, kept: &mut Vec<usize>) -> f64 {
    let own = nodes[node].piece.hull.volume_mm3;
    let before = kept.len();
    if let Some([one, other]) = nodes[node].parts {
        let together = gather(nodes, one, kept) + gather(nodes, other, kept);
        if together <= WORTHWHILE * own {
            return together;
        }
    }
    kept.truncate(before);
    kept.push(node);
    own
}

/// The cut across a coordinate direction that leaves the least volume.
fn split(whole: &Piece) -> Option<[Piece; 2]> {
    // the cut is chosen on a coarse picture of a fine mesh and made on the mesh itself
    let coarse = whole.coarse();
    let mut best: Option<(f64, usize, f64)> = None;
    for k in 0..3 {
        for at in cuts(&coarse, k) {
            let Some([one, other]) = cut(&coarse, k, at, ROUGH_CORNERS) else { continue };
            let volume = one.hull.volume_mm3 + other.hull.volume_mm3;
            if best.is_none_or(|(least, ..)| volume < (1.0 - LEAST_SAVING) * least) {
                best = Some((volume, k, at));
            }
        }
    }
    let (_, k, at) = best?;
    cut(&whole.triangles, k, at, MAX_CORNERS)
}

/// Places to cut across a direction: where corners gather, as they do at the faces of walls, and quarters.
fn cuts(triangles: &[Triangle], k: usize) -> Vec<f64> {
    let mut values: Vec<f64> = triangles.iter().flatten().map(|corner| corner[k]).collect();
    values.sort_by(f64::total_cmp);
    let (Some(&low), Some(&high)) = (values.first(), values.last()) else { return Vec::new() };
    let margin = (1e-6 * (high - low)).max(2.0 * SAME_MM);
    values.retain(|value| *value > low + margin && *value < high - margin);
    let mut places: Vec<(usize, f64)> = Vec::new();
    for value in values {
        match places.last_mut() {
            Some((count, place)) if value - *place <= SAME_MM => *count += 1,
            _ => places.push((1, value)),
        }
    }
    places.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.total_cmp(&b.1)));
    let gathered = places.iter().take(CUTS).map(|(_, place)| *place);
    gathered.chain([0.5, 0.25, 0.75].map(|part| low + (high - low) * part)).collect()
}

/// Pieces below and above a cut, the triangles across it divided; `None` when one is flat.
fn cut(triangles: &[Triangle], k: usize, at: f64, corners: usize) -> Option<[Piece; 2]> {
    let (mut below, mut above, mut within) = (Vec::new(), Vec::new(), Vec::new());
    for triangle in triangles {
        let (low, high) = triangle.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p[k]), b.max(p[k])));
        match (high <= at + SAME_MM, low >= at - SAME_MM) {
            (true, true) => within.push(*triangle),
            (true, false) => below.push(*triangle),
            (false, true) => above.push(*triangle),
            (false, false) => {
                below.extend(side(triangle, k, at, 1.0));
                above.extend(side(triangle, k, at, -1.0));
            }
        }
    }
    let (below, above) = (Piece::of(below, corners)?, Piece::of(above, corners)?);
    if within.is_empty() {
        return Some([below, above]);
    }
    // a face in the cut belongs to the wall behind it: to the side whose hull holds it already
    let holds = |piece: &Piece| {
        let planes = piece.hull.planes();
        move |t: &Triangle| {
            t.iter().all(|p| planes.iter().all(|(normal, offset)| normal.dot(p) <= offset + 10.0 * SAME_MM))
        }
    };
    let held_above = holds(&above);
    let held_below = holds(&below);
    let (up, down): (Vec<Triangle>, Vec<Triangle>) = within.iter().partition(|t| held_above(t) && !held_below(t));
    let grown = |piece: Piece, more: Vec<Triangle>| match more.is_empty() {
        true => Some(piece),
        false => Piece::of(piece.triangles.into_iter().chain(more).collect(), corners),
    };
    Some([grown(below, down)?, grown(above, up)?])
}

/// The part of a triangle below (`sign` 1) or above (−1) a cut, as triangles.
fn side(triangle: &Triangle, k: usize, at: f64, sign: f64) -> impl Iterator<Item = Triangle> + use<> {
    let mut corners: Vec<Vector3<f64>> = Vec::with_capacity(4);
    for n in 0..3 {
        let (here, next) = (&triangle[n], &triangle[(n + 1) % 3]);
        let (from, to) = (sign * (at - here[k]), sign * (at - next[k]));
        if from >= 0.0 {
            corners.push(*here);
        }
        if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
            corners.push(here + (next - here) * (from / (from - to)));
        }
    }
    (2..corners.len()).map(move |n| [corners[0], corners[n - 1], corners[n]])
}

/// Every edge of a closed mesh belongs to two triangles, or four where bodies touch; which way triangles look is not asked.
fn refuse_open_edges(triangles: &[Triangle]) -> Result<(), MeshError> {
    let key = |p: &Vector3<f64>| p.map(|value| (value / SAME_MM).round() as i64);
    let mut edges: HashMap<[Vector3<i64>; 2], (u32, Vector3<f64>)> = HashMap::new();
    for triangle in triangles {
        for k in 0..3 {
            let (a, b) = (key(&triangle[k]), key(&triangle[(k + 1) % 3]));
            if a == b {
                continue;
            }
            let edge = if a.as_slice() < b.as_slice() { [a, b] } else { [b, a] };
            edges.entry(edge).or_insert((0, triangle[k])).0 += 1;
        }
    }
    let mut open: Vec<Vector3<f64>> = edges.values().filter(|(count, _)| count % 2 != 0).map(|(_, at)| *at).collect();
    open.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
    match open.first() {
        None => Ok(()),
        Some(at) => Err(MeshError::Open { open: open.len(), x: at.x, y: at.y, z: at.z }),
    }
}

//! STL (binary and text) and OBJ files to triangles, mm. Paths stay in the project: beside the machine file or in `shapes`.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};

use nalgebra::Vector3;

use crate::bodies::{MAX_TRIANGLES, MeshError, Solid, Triangle, convex_pieces};
use crate::load::checked_text::limits::{MESH_BYTES, MESHES};
use crate::load::checked_text::text::{bytes_limited, lies_in};
use crate::machine::{AxisKind, Machine};

/// Why a mesh file was not read.
#[derive(Debug, thiserror::Error)]
pub(super) enum MeshFileError {
    #[error("mesh '{0}' leaves the machine's folder; put it beside the machine file or in ../shapes")]
    Outside(String),
    #[error("mesh '{0}' is a link out of the machine's folder and of ../shapes; put a copy there")]
    Linked(String),
    #[error("{0}")]
    TooMany(String),
    #[error("mesh {file} cannot be read: {why}")]
    Unreadable { file: String, why: String },
    #[error("mesh {file} line {line}: {found}")]
    Text { file: String, line: usize, found: String },
    #[error("mesh {file} {why}")]
    Shape { file: String, why: MeshError },
    #[error("mesh {file} is {size} across, the machine some {machine_mm:.0} mm; check its unit and {other_scale}")]
    Unit { file: String, size: String, machine_mm: f64, other_scale: String },
}

/// How a mesh file is to be taken.
pub(super) struct MeshUse<F: Fn(f64) -> String> {
    /// mm per unit of the file, by direction.
    pub scale: Vector3<f64>,
    pub machine_size_mm: f64,
    /// A scale was written down: a tiny mesh is what it is.
    pub small_is_meant: bool,
    /// What to write for a scale that is this many times larger.
    pub other_scale: F,
}

/// A mesh smaller than this part of the machine has most likely another unit.
const LEAST_SHARE_OF_MACHINE: f64 = 1.0 / 300.0;
/// A mesh larger than this many machines has most likely another unit.
const MOST_TIMES_MACHINE: f64 = 20.0;

/// Size of a machine by its travels and the places of its axes, mm.
pub(super) fn machine_size_mm(machine: &Machine) -> f64 {
    let travel = machine.axes.iter().filter(|axis| axis.kind == AxisKind::Linear).filter_map(|axis| axis.range);
    let travel = travel.map(|(low, high)| high - low).fold(0.0, f64::max);
    let places = machine.axes.iter().map(|axis| 2.0 * axis.origin.norm()).fold(0.0, f64::max);
    // nothing stated: a small machine
    let stated = travel.max(places).max(machine.gauge_length_mm.unwrap_or(0.0));
    if stated > 0.0 { stated.max(200.0) } else { 600.0 }
}

/// Folder, name, bits of the scale, and whether a small size is meant.
type MeshKey = (PathBuf, String, [u64; 3], bool);

/// The meshes of one machine: a file that several bodies name is read and cut up once.
pub(super) struct Meshes {
    /// Folder that names are relative to.
    folder: PathBuf,
    /// Pieces of the files read so far.
    read: RefCell<HashMap<MeshKey, Vec<Solid>>>,
}

impl Meshes {
    /// Meshes named in a machine file or robot description.
    pub fn beside(file: &Path) -> Meshes {
        Meshes { folder: file.parent().map(PathBuf::from).unwrap_or_default(), read: RefCell::default() }
    }

    /// Convex solids that cover the mesh of a file named relative to the machine file.
    pub fn solids<F: Fn(f64) -> String>(&self, name: &str, how: &MeshUse<F>) -> Result<Vec<Solid>, MeshFileError> {
        self.solids_in(&self.folder, name, how)
    }

    /// Convex solids that cover the mesh of a file named relative to a folder, which it does not leave.
    pub fn solids_in<F: Fn(f64) -> String>(
        &self,
        folder: &Path,
        name: &str,
        how: &MeshUse<F>,
    ) -> Result<Vec<Solid>, MeshFileError> {
        let scale = [how.scale.x, how.scale.y, how.scale.z].map(f64::to_bits);
        let key = (folder.to_path_buf(), name.to_string(), scale, how.small_is_meant);
        if let Some(solids) = self.read.borrow().get(&key) {
            return Ok(solids.clone());
        }
        let solids = mesh_solids(folder, name, how)?;
        let mut read = self.read.borrow_mut();
        read.insert(key, solids.clone());
        MESHES.exceeded(read.len()).map_or(Ok(solids), |message| Err(MeshFileError::TooMany(message)))
    }
}

/// Convex solids that cover the mesh of a file named relative to `folder`.
fn mesh_solids<F: Fn(f64) -> String>(folder: &Path, name: &str, how: &MeshUse<F>) -> Result<Vec<Solid>, MeshFileError> {
    let triangles = load_mesh(folder, name, &how.scale)?;
    let (low, high) = triangles
        .iter()
        .flatten()
        .fold((Vector3::repeat(f64::MAX), Vector3::repeat(f64::MIN)), |(low, high), p| (low.inf(p), high.sup(p)));
    let size_mm = (high - low).norm();
    let off = |factor: f64| MeshFileError::Unit {
        file: name.into(),
        size: if size_mm < 1.0 { format!("{size_mm:.3} mm") } else { format!("{size_mm:.0} mm") },
        machine_mm: how.machine_size_mm,
        other_scale: (how.other_scale)(factor),
    };
    if size_mm.is_finite() && size_mm > MOST_TIMES_MACHINE * how.machine_size_mm {
        return Err(off(1e-3));
    }
    if size_mm > 0.0 && size_mm < LEAST_SHARE_OF_MACHINE * how.machine_size_mm && !how.small_is_meant {
        return Err(off(1e3));
    }
    convex_pieces(&triangles).map_err(|why| MeshFileError::Shape { file: name.into(), why })
}

/// Triangles of a mesh file named relative to `folder`.
fn load_mesh(folder: &Path, name: &str, scale: &Vector3<f64>) -> Result<Vec<Triangle>, MeshFileError> {
    let inner = name.strip_prefix("../shapes/").unwrap_or(name);
    if inner.is_empty() || !Path::new(inner).components().all(|part| matches!(part, Component::Normal(_))) {
        return Err(MeshFileError::Outside(name.into()));
    }
    let unreadable = |why: String| MeshFileError::Unreadable { file: name.into(), why };
    let file = folder.join(name);
    if file.exists() && !lies_in(&file, &[folder, &folder.join("../shapes")]) {
        return Err(MeshFileError::Linked(name.into()));
    }
    let bytes = bytes_limited(&file, MESH_BYTES).map_err(|why| unreadable(format!("it {why}")))?;
    let extension = Path::new(inner).extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("stl") => match binary_stl(&bytes, scale) {
            Some(triangles) => Ok(triangles),
            None if bytes.trim_ascii_start().starts_with(b"solid") && !bytes.contains(&0) => {
                text_stl(name, &String::from_utf8_lossy(&bytes), scale)
            }
            None => Err(unreadable(binary_stl_cut(&bytes))),
        },
        Some("obj") => obj(name, &String::from_utf8_lossy(&bytes), scale),
        _ => Err(unreadable("it is neither .stl nor .obj".into())),
    }
}

/// Binary STL, recognised by its size: 84 bytes and 50 for each triangle.
fn binary_stl(bytes: &[u8], scale: &Vector3<f64>) -> Option<Vec<Triangle>> {
    let count = u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?) as usize;
    if bytes.len() != 84 + count.checked_mul(50)? {
        return None;
    }
    let number = |at: usize| Some(f64::from(f32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?)));
    (0..count)
        .map(|triangle| {
            let corner = |k: usize| {
                let at = 84 + triangle * 50 + 12 + 12 * k;
                Some(Vector3::new(number(at)?, number(at + 4)?, number(at + 8)?).component_mul(scale))
            };
            Some([corner(0)?, corner(1)?, corner(2)?])
        })
        .collect()
}

/// Why a file that is no text is no binary STL either.
fn binary_stl_cut(bytes: &[u8]) -> String {
    match bytes.get(80..84).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes) {
        None => format!("it has {} bytes; an STL starts with 'solid' or with 84 bytes of head", bytes.len()),
        Some(count) => format!(
            "as a binary STL of {count} triangles it has {} bytes, it is {} long: the file is cut off or no STL",
            84 + 50 * u64::from(count),
            bytes.len()
        ),
    }
}

fn text_stl(file: &str, text: &str, scale: &Vector3<f64>) -> Result<Vec<Triangle>, MeshFileError> {
    let mut corners = Vec::new();
    let (mut facets, mut is_closed) = (0, false);
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vertex") => corners.push(corner(file, index, words, scale)?),
            Some("endfacet") => facets += 1,
            Some("endsolid") => is_closed = true,
            Some("solid") => is_closed = false,
            _ => {}
        }
    }
    if !is_closed || corners.len() != 3 * facets {
        let found = "the file is cut off: each facet has three vertices and an endfacet, the end is endsolid".into();
        return Err(MeshFileError::Text { file: file.into(), line: text.lines().count(), found });
    }
    Ok(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect())
}

fn obj(file: &str, text: &str, scale: &Vector3<f64>) -> Result<Vec<Triangle>, MeshFileError> {
    // counted before they take memory
    let faces = text.lines().map(str::split_whitespace).filter(|words| words.clone().next() == Some("f"));
    let found = faces.map(|words| words.count().saturating_sub(3)).sum();
    if found > MAX_TRIANGLES {
        return Err(MeshFileError::Shape { file: file.into(), why: MeshError::TooMany { found } });
    }
    let mut corners: Vec<Vector3<f64>> = Vec::new();
    let mut triangles: Vec<Triangle> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let refuse = |found: String| MeshFileError::Text { file: file.into(), line: index + 1, found };
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => corners.push(corner(file, index, words, scale)?),
            Some("f") => {
                let face = words
                    .map(|word| {
                        let number: i64 = word.split('/').next().and_then(|n| n.parse().ok()).unwrap_or(0);
                        let place = if number < 0 { corners.len() as i64 + number } else { number - 1 };
                        usize::try_from(place).ok().and_then(|place| corners.get(place).copied()).ok_or_else(|| {
                            refuse(format!("'{word}' names no corner; there are {} so far", corners.len()))
                        })
                    })
                    .collect::<Result<Vec<_>, _>>()?;
                if face.len() < 3 {
                    return Err(refuse("a face has at least three corners".into()));
                }
                triangles.extend((1..face.len() - 1).map(|k| [face[0], face[k], face[k + 1]]));
            }
            _ => {}
        }
    }
    Ok(triangles)
}

fn corner<'w>(
    file: &str,
    index: usize,
    words: impl Iterator<Item = &'w str>,
    scale: &Vector3<f64>,
) -> Result<Vector3<f64>, MeshFileError> {
    let numbers: Vec<f64> = words.take(3).filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [x, y, z] if numbers.iter().all(|value| value.is_finite()) => Ok(Vector3::new(x, y, z).component_mul(scale)),
        _ => Err(MeshFileError::Text {
            file: file.into(),
            line: index + 1,
            found: "a corner has three finite numbers, as in 0 0 1.5".into(),
        }),
    }
}

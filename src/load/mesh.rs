//! STL (binary and text) and OBJ files to triangles, mm. Paths stay in the project: beside the machine file or in `shapes`.

use std::path::{Component, Path};

use nalgebra::Vector3;

use crate::bodies::MAX_TRIANGLES;

/// Largest mesh file, bytes: a text STL at the triangle limit takes about 60 MB.
const MAX_MESH_BYTES: u64 = 64 << 20;

/// Why a mesh file was not read.
#[derive(Debug, thiserror::Error)]
pub(super) enum MeshFileError {
    #[error("mesh '{0}' leaves the machine's folder; put it beside the machine file or in ../shapes")]
    Outside(String),
    #[error("mesh {file} cannot be read: {why}")]
    Unreadable { file: String, why: String },
    #[error("mesh {file} line {line}: {found}")]
    Text { file: String, line: usize, found: String },
}

/// Triangles of a mesh file named relative to `folder`.
pub(super) fn load_mesh(folder: &Path, name: &str, scale: f64) -> Result<Vec<[Vector3<f64>; 3]>, MeshFileError> {
    let inner = name.strip_prefix("../shapes/").unwrap_or(name);
    if inner.is_empty() || !Path::new(inner).components().all(|part| matches!(part, Component::Normal(_))) {
        return Err(MeshFileError::Outside(name.into()));
    }
    let unreadable = |why: String| MeshFileError::Unreadable { file: name.into(), why };
    let file = folder.join(name);
    let size = std::fs::metadata(&file).map_err(|why| unreadable(why.to_string()))?.len();
    if size > MAX_MESH_BYTES {
        return Err(unreadable(format!(
            "it has {} MB; at most {} MB are allowed, simplify the mesh to {MAX_TRIANGLES} triangles",
            size >> 20,
            MAX_MESH_BYTES >> 20
        )));
    }
    let bytes = std::fs::read(&file).map_err(|why| unreadable(why.to_string()))?;
    let extension = Path::new(inner).extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("stl") => match binary_stl(&bytes, scale) {
            Some(triangles) => Ok(triangles),
            None => text_stl(name, &String::from_utf8_lossy(&bytes), scale),
        },
        Some("obj") => obj(name, &String::from_utf8_lossy(&bytes), scale),
        _ => Err(unreadable("it is neither .stl nor .obj".into())),
    }
}

/// Binary STL, recognised by its size: 84 bytes and 50 for each triangle.
fn binary_stl(bytes: &[u8], scale: f64) -> Option<Vec<[Vector3<f64>; 3]>> {
    let count = u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?) as usize;
    if bytes.len() != 84 + count.checked_mul(50)? {
        return None;
    }
    let number = |at: usize| Some(f64::from(f32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?)) * scale);
    (0..count)
        .map(|triangle| {
            let corner = |k: usize| {
                let at = 84 + triangle * 50 + 12 + 12 * k;
                Some(Vector3::new(number(at)?, number(at + 4)?, number(at + 8)?))
            };
            Some([corner(0)?, corner(1)?, corner(2)?])
        })
        .collect()
}

fn text_stl(file: &str, text: &str, scale: f64) -> Result<Vec<[Vector3<f64>; 3]>, MeshFileError> {
    let mut corners = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        if words.next() == Some("vertex") {
            corners.push(corner(file, index, words, scale)?);
        }
    }
    if corners.is_empty() || corners.len() % 3 != 0 {
        let found = "is no STL: no triangles, or a triangle cut short".into();
        return Err(MeshFileError::Text { file: file.into(), line: text.lines().count(), found });
    }
    Ok(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect())
}

fn obj(file: &str, text: &str, scale: f64) -> Result<Vec<[Vector3<f64>; 3]>, MeshFileError> {
    let mut corners: Vec<Vector3<f64>> = Vec::new();
    let mut triangles = Vec::new();
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
    scale: f64,
) -> Result<Vector3<f64>, MeshFileError> {
    let numbers: Vec<f64> = words.take(3).filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [x, y, z] => Ok(Vector3::new(x, y, z) * scale),
        _ => Err(MeshFileError::Text {
            file: file.into(),
            line: index + 1,
            found: "a corner has three numbers, as in 'vertex 0 0 1.5'".into(),
        }),
    }
}

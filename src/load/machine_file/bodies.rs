//! Solids and mounting surfaces of a machine file to [`Bodies`]. Meshes are in `mesh`, robots in `urdf`.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use super::machine::{is_urdf, load_machine_with_links};
use crate::bodies::{Bodies, Body, Mount, Outline, Solid, frame_along};
use crate::chain::{Chain, Pose};
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::limits::{HULL_POINTS, MESHES, MOUNTS, SOLIDS, YAML_BYTES};
use crate::load::checked_text::message::{LoadError, did_you_mean};
use crate::load::checked_text::quantity::{finite, point};
use crate::load::checked_text::text::read_limited;
use crate::load::links::known_link;
use crate::load::mesh::{MeshUse, Meshes, machine_size_mm};
use crate::load::urdf::{LinkChoice, bodies_from_urdf, ends_from_urdf, mesh_names};
use crate::machine::Machine;

/// The part of a machine file that this reader knows; the rest is the machine's own.
#[derive(Deserialize)]
struct SolidsFile {
    #[serde(default)]
    bodies: Vec<BodyFile>,
    #[serde(default)]
    mounts: Vec<MountFile>,
    #[serde(default)]
    touching: Vec<[String; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyFile {
    name: String,
    link: String,
    #[serde(rename = "box")]
    cuboid: Option<BoxFile>,
    cylinder: Option<RoundFile>,
    capsule: Option<RoundFile>,
    hull: Option<Vec<[f64; 3]>>,
    mesh: Option<MeshFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxFile {
    at: [f64; 3],
    size: [f64; 3],
    /// Turns about R's x, y, z in this order, degrees.
    turned: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RoundFile {
    from: [f64; 3],
    to: [f64; 3],
    radius: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshFile {
    file: String,
    at: Option<[f64; 3]>,
    turned: Option<[f64; 3]>,
    /// mm per unit of the file.
    scale: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MountFile {
    name: String,
    link: String,
    at: [f64; 3],
    normal: [f64; 3],
    along: Option<[f64; 3]>,
    /// Radius, or inner and outer radius.
    disc: Option<Vec<f64>>,
    rectangle: Option<[f64; 2]>,
    slot_pitch: Option<f64>,
}

/// Reads a machine file with its solids; links of a URDF are found by name.
pub fn load_machine_and_bodies(file: &Path) -> Result<(Machine, Bodies), LoadError> {
    load_machine_and_bodies_with_links(file, &LinkChoice::default())
}

/// Reads a machine file with its solids; `links` names the bed, workpiece and tool of a URDF.
pub fn load_machine_and_bodies_with_links(file: &Path, links: &LinkChoice) -> Result<(Machine, Bodies), LoadError> {
    let machine = load_machine_with_links(file, links)?;
    let text = read_limited(file, YAML_BYTES)?;
    if is_urdf(file, &text) {
        let bodies = bodies_from_urdf(file, &text, links, &machine)?;
        return Ok((machine, bodies));
    }
    let document = Document::parse(file, text)?;
    let raw: SolidsFile = document.read()?;
    for (key, message) in [("bodies", SOLIDS.exceeded(raw.bodies.len())), ("mounts", MOUNTS.exceeded(raw.mounts.len()))]
    {
        if let Some(message) = message {
            return Err(document.refuse(&[Step::Key(key)], message));
        }
    }
    let meshes = Meshes::beside(file);
    let reader =
        Reader { document: &document, meshes, chain: Chain::of(&machine), machine_size_mm: machine_size_mm(&machine) };
    let mut solids = 0;
    let mut bodies = Bodies::default();
    for (index, body) in raw.bodies.iter().enumerate() {
        let body = reader.body(index, body)?;
        solids += body.solids.len();
        if let Some(message) = SOLIDS.exceeded(solids) {
            return Err(document.refuse(&[Step::Key("bodies"), Step::Index(index)], message));
        }
        bodies.bodies.push(body);
    }
    for (index, mount) in raw.mounts.iter().enumerate() {
        bodies.mounts.push(reader.mount(index, mount)?);
    }
    for (index, pair) in raw.touching.iter().enumerate() {
        bodies.touching.push(reader.touching(index, pair, &bodies.bodies)?);
    }
    Ok((machine, bodies))
}

/// A robot description with its solids, and the frames of its workpiece and tool links in R; a YAML file is refused.
pub fn load_description(file: &Path, links: &LinkChoice) -> Result<(Machine, Bodies, [Pose; 2]), LoadError> {
    let text = read_limited(file, YAML_BYTES)?;
    if !is_urdf(file, &text) {
        return Err(LoadError::file(file, "is no robot description (URDF); a machine file needs no init"));
    }
    let (machine, bodies) = load_machine_and_bodies_with_links(file, links)?;
    Ok((machine, bodies, ends_from_urdf(file, &text, links)?))
}

/// Names of the mesh files of a machine, relative to its folder, in order and each once.
pub fn mesh_files(file: &Path) -> Result<Vec<String>, LoadError> {
    let text = read_limited(file, YAML_BYTES)?;
    let mut names = match is_urdf(file, &text) {
        true => mesh_names(file, &text)?,
        false => {
            let raw: SolidsFile = Document::parse(file, text)?.read()?;
            raw.bodies.into_iter().filter_map(|body| Some(body.mesh?.file)).collect()
        }
    };
    names.sort();
    names.dedup();
    MESHES.exceeded(names.len()).map_or(Ok(names), |message| Err(LoadError::file(file, message)))
}

struct Reader<'a> {
    document: &'a Document,
    meshes: Meshes,
    chain: Chain,
    machine_size_mm: f64,
}

impl Reader<'_> {
    fn body(&self, index: usize, raw: &BodyFile) -> Result<Body, LoadError> {
        let at = |key| [Step::Key("bodies"), Step::Index(index), Step::Key(key)];
        let refuse = |key, message: String| self.document.refuse(&at(key), format!("body '{}': {message}", raw.name));
        self.link(&at("link"), &raw.link)?;
        let point = |key, value: &[f64; 3]| self.point(&at(key), value);
        let shapes = [
            raw.cuboid.is_some(),
            raw.cylinder.is_some(),
            raw.capsule.is_some(),
            raw.hull.is_some(),
            raw.mesh.is_some(),
        ];
        if shapes.iter().filter(|given| **given).count() != 1 {
            return Err(refuse("name", "give exactly one of box, cylinder, capsule, hull, mesh".into()));
        }
        let body = |solids, rotation, translation_mm| Body {
            name: raw.name.clone(),
            link: raw.link.clone(),
            solids,
            at: Pose { rotation, translation_mm },
        };
        if let Some(cuboid) = &raw.cuboid {
            let size = point("box", &cuboid.size)?;
            if size.min() <= 0.0 {
                return Err(refuse("box", "every size of a box is above zero".into()));
            }
            let rotation = self.turned(&at("box"), cuboid.turned)?;
            return Ok(body(vec![Solid::Box { half_mm: size * 0.5 }], rotation, point("box", &cuboid.at)?));
        }
        for (key, round) in [("cylinder", &raw.cylinder), ("capsule", &raw.capsule)] {
            let Some(round) = round else { continue };
            let (from, to) = (point(key, &round.from)?, point(key, &round.to)?);
            let radius_mm = finite(self.document, &at(key), round.radius)?;
            let length = (to - from).norm();
            if radius_mm <= 0.0 || length <= 0.0 {
                return Err(refuse(key, "the radius is above zero, and from and to differ".into()));
            }
            let half_mm = 0.5 * length;
            let solid = match key {
                "cylinder" => Solid::Cylinder { radius_mm, half_mm },
                _ => Solid::Capsule { radius_mm, half_mm },
            };
            return Ok(body(vec![solid], frame_along(&((to - from) / length)), (from + to) * 0.5));
        }
        if let Some(corners) = &raw.hull {
            if let Some(message) = HULL_POINTS.exceeded(corners.len()) {
                return Err(refuse("hull", message));
            }
            let corners = corners.iter().map(|corner| point("hull", corner)).collect::<Result<Vec<_>, _>>()?;
            let solid = Solid::hull_of(&corners)
                .ok_or_else(|| refuse("hull", "its points lie in a plane; a hull encloses a volume".into()))?;
            return Ok(body(vec![solid], Matrix3::identity(), Vector3::zeros()));
        }
        let Some(mesh) = &raw.mesh else { return Ok(body(Vec::new(), Matrix3::identity(), Vector3::zeros())) };
        let scale = finite(self.document, &at("mesh"), mesh.scale.unwrap_or(1.0))?;
        if scale <= 0.0 {
            return Err(refuse("mesh", "scale is above zero, mm per unit of the file".into()));
        }
        let how = MeshUse {
            scale: Vector3::repeat(scale),
            machine_size_mm: self.machine_size_mm,
            small_is_meant: mesh.scale.is_some(),
            other_scale: |factor| match factor > 1.0 {
                true => format!("write scale: {factor} (scale: 1 where it is meant so)"),
                false => format!("write scale: {}", scale * factor),
            },
        };
        let pieces = self.meshes.solids(&mesh.file, &how).map_err(|why| refuse("mesh", why.to_string()))?;
        let rotation = self.turned(&at("mesh"), mesh.turned)?;
        let translation_mm = point("mesh", &mesh.at.unwrap_or_default())?;
        Ok(body(pieces, rotation, translation_mm))
    }

    fn mount(&self, index: usize, raw: &MountFile) -> Result<Mount, LoadError> {
        let at = |key| [Step::Key("mounts"), Step::Index(index), Step::Key(key)];
        let refuse = |key, message: &str| self.document.refuse(&at(key), format!("mount '{}': {message}", raw.name));
        self.link(&at("link"), &raw.link)?;
        let normal = self.direction(&at("normal"), &raw.normal)?;
        let along = match &raw.along {
            Some(along) => self.direction(&at("along"), along)?,
            None => [Vector3::x(), Vector3::y()]
                .iter()
                .find_map(|axis| (axis - normal * normal.dot(axis)).try_normalize(0.5))
                .unwrap_or_else(Vector3::z),
        };
        if along.dot(&normal).abs() > 1e-6 {
            return Err(refuse("along", "along lies in the surface, at a right angle to normal"));
        }
        let outline = match (raw.disc.as_deref(), raw.rectangle) {
            (Some([radius]), None) if *radius > 0.0 => Outline::Disc { inner_radius_mm: 0.0, radius_mm: *radius },
            (Some([inner, radius]), None) if *inner >= 0.0 && radius > inner => {
                Outline::Disc { inner_radius_mm: *inner, radius_mm: *radius }
            }
            (None, Some(size)) if size.iter().all(|s| *s > 0.0) => Outline::Rectangle { size_mm: size },
            _ => {
                return Err(refuse(
                    "name",
                    "give one outline: 'disc: [radius]', 'disc: [inner, outer]' or 'rectangle: [along, across]', above zero",
                ));
            }
        };
        if raw.slot_pitch.is_some_and(|pitch| !(pitch.is_finite() && pitch > 0.0)) {
            return Err(refuse("slot_pitch", "slot_pitch is above zero, mm"));
        }
        Ok(Mount {
            name: raw.name.clone(),
            link: raw.link.clone(),
            middle: self.point(&at("at"), &raw.at)?,
            normal,
            along,
            outline,
            slot_pitch_mm: raw.slot_pitch,
        })
    }

    /// A pair of bodies that touch by design: two different ones, each the only one of its name, on different links.
    fn touching(&self, index: usize, pair: &[String; 2], bodies: &[Body]) -> Result<(String, String), LoadError> {
        let place = [Step::Key("touching"), Step::Index(index)];
        let refuse = |message: String| self.document.refuse(&place, message);
        let named = |name: &String| {
            let mut found = bodies.iter().filter(|body| body.name == *name);
            match (found.next(), found.next()) {
                (Some(body), None) => Ok(body),
                (Some(_), Some(_)) => {
                    Err(refuse(format!("several bodies are called '{name}'; give each a name of its own")))
                }
                (None, _) => {
                    let known: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
                    let hint = did_you_mean(name, &known);
                    let known = if known.is_empty() { "none".into() } else { known.join(", ") };
                    Err(refuse(format!("no body is called '{name}'{hint} (bodies: {known})")))
                }
            }
        };
        let [one, other] = pair;
        let (first, second) = (named(one)?, named(other)?);
        if self.chain.link(&first.link) == self.chain.link(&second.link) {
            return Err(refuse(format!(
                "'{one}' and '{other}' are on one link and never compared; list bodies of different links, or take the pair out"
            )));
        }
        Ok((one.clone(), other.clone()))
    }

    fn link(&self, place: &[Step], name: &str) -> Result<(), LoadError> {
        known_link(self.document, &self.chain, place, name)
    }

    fn point(&self, place: &[Step], value: &[f64; 3]) -> Result<Vector3<f64>, LoadError> {
        point(self.document, place, value)
    }

    fn direction(&self, place: &[Step], value: &[f64; 3]) -> Result<Vector3<f64>, LoadError> {
        self.point(place, value)?
            .try_normalize(1e-9)
            .ok_or_else(|| self.document.refuse(place, "the direction has no length; give a vector such as [0, 0, 1]"))
    }

    fn turned(&self, place: &[Step], value: Option<[f64; 3]>) -> Result<Matrix3<f64>, LoadError> {
        let angles = self.point(place, &value.unwrap_or_default())?.map(f64::to_radians);
        let about = |axis: Vector3<f64>, angle: f64| *nalgebra::Rotation3::new(axis * angle).matrix();
        Ok(about(Vector3::z(), angles.z) * about(Vector3::y(), angles.y) * about(Vector3::x(), angles.x))
    }
}

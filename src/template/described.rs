//! A machine as a robot description gives it, made ready to plan: letters for axes, boxes for meshes, a surface for the pivot, a nose.

use nalgebra::{Matrix3, Vector3};

use super::figures::{GAUGE_MM, SizesError, TableSize, assumed_range};
use super::made::Made;
use crate::bodies::{Bodies, Body, Mount, Outline, Solid, frame_along};
use crate::chain::Pose;
use crate::machine::{AxisKind, Directions, Machine, SpindleSide, StructuralCode, letter_axis};

/// What a description does not say of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Wishes {
    /// Frames of workpiece link and tool link in R with all axes at zero.
    pub workpiece: Pose,
    pub tool: Pose,
    /// Table where no collision geometry of the workpiece link shows one.
    pub table: Option<TableSize>,
    /// Diameter of the spindle housing where the tool's links have no geometry, mm.
    pub housing_mm: f64,
    /// How the control counts the axes; the description counts them as carried.
    pub directions: Directions,
}

/// Bodies of neighbouring links that are nearer than this at zero meet in a bearing or a guideway, mm.
const JOINED_MM: f64 = 10.0;
/// Table where none is drawn: its thickness, mm. Housing where none is drawn: its length, mm.
const TABLE_MM: f64 = 40.0;
const HOUSING_MM: f64 = 200.0;
/// Directions that differ by less than this from a coordinate direction have its letter: the cosine of 45°.
const NEAREST: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Smallest surface that takes a stand, mm.
const SURFACE_MM: f64 = 80.0;
/// Range of an axis that turns without end, for programs, rad.
const ENDLESS_RAD: f64 = std::f64::consts::TAU;

const CAVEATS: [&str; 3] = [
    "made from a robot description: axes, ranges not called ASSUMED and shapes are the description's, letters are those of the axes' directions",
    "meshes are boxes about their convex pieces, parts of neighbouring links that meet at zero are taken for joined, compare every clearance with your machine",
    "surface of the pivot and spindle nose are found from the description, check both",
];

/// Machine and bodies with which a plan can be made.
pub fn plannable(machine: &Machine, bodies: &Bodies, wishes: &Wishes) -> Result<Made, SizesError> {
    let letters = letters(machine)?;
    let renamed = |name: &str| match machine.axis_index(name) {
        Some(axis) => letters[axis].clone(),
        None => name.to_string(),
    };
    let on_table = machine.code.workpiece_side.len();
    let mut named = Machine {
        code: StructuralCode { workpiece_side: letters[..on_table].to_vec(), tool_side: letters[on_table..].to_vec() },
        caveats: CAVEATS.map(str::to_string).to_vec(),
        link_names: Vec::new(),
        ..machine.clone()
    };
    let mut assumed = Vec::new();
    for (axis, letter) in named.axes.iter_mut().zip(&letters) {
        axis.name.clone_from(letter);
        if axis.kind == AxisKind::Rotary && axis.range.is_none() {
            axis.range = Some((-ENDLESS_RAD, ENDLESS_RAD));
            let degrees = ENDLESS_RAD.to_degrees();
            assumed.push(assumed_range(letter, (-degrees, degrees), "the description limits it nowhere"));
        }
    }
    named.caveats.extend(assumed.iter().cloned());
    if wishes.directions == Directions::Iso841 {
        count_by_iso841(&mut named);
    }
    let mut all = Bodies::default();
    for body in &bodies.bodies {
        for solid in &body.solids {
            let name = free_name(&all, &body.name);
            all.bodies.push(plain(&Body { name, link: renamed(&body.link), solids: Vec::new(), at: body.at }, solid));
        }
    }
    let link_of = |side: Option<&String>| side.cloned().unwrap_or_else(|| "b".into());
    let (table, spindle) = (link_of(letters[..on_table].first()), link_of(letters[on_table..].last()));
    let mount = surface(&mut all, &table, wishes)?;
    let nose = nose(&mut all, &spindle, wishes);
    all.mounts.push(mount);
    named.spindle = Some(nose);
    join(&mut all, &named.code);
    Ok(Made { machine: named, bodies: all, assumed })
}

/// Counts axes as ISO 841 does. Every joint keeps its motion; the count q of the description becomes -q where the
/// direction is turned to the positive one of its letter, and once more where the axis carries the workpiece.
fn count_by_iso841(machine: &mut Machine) {
    for (place, axis) in machine.axes.iter_mut().enumerate() {
        let usual = letter_axis(&axis.name).map(|(_, direction)| direction);
        let is_backward = usual.is_some_and(|usual| usual.dot(&axis.direction) < 0.0);
        // + 0.0: no minus before a zero
        if is_backward {
            axis.direction = axis.direction.map(|part| -part + 0.0);
        }
        if is_backward != machine.code.carries_workpiece(place) {
            axis.range = axis.range.map(|(low, high)| (-high + 0.0, -low + 0.0));
        }
    }
    machine.directions = Some(Directions::Iso841);
}

/// A letter for each axis: X, Y, Z along and A, B, C about the coordinate directions.
fn letters(machine: &Machine) -> Result<Vec<String>, SizesError> {
    let mut letters: Vec<String> = Vec::new();
    for axis in &machine.axes {
        let names = if axis.kind == AxisKind::Linear { ["X", "Y", "Z"] } else { ["A", "B", "C"] };
        let own = names.iter().position(|name| *name == axis.name);
        let nearest = own.or_else(|| (0..3).find(|&k| axis.direction[k].abs() > NEAREST));
        let Some(letter) = nearest.map(|k| names[k].to_string()) else {
            return Err(SizesError(format!(
                "joint '{}' lies between the coordinate directions and gets no letter; call it {} in the description",
                axis.name,
                names.join(", ")
            )));
        };
        if let Some(k) = letters.iter().position(|other| *other == letter) {
            return Err(SizesError(format!(
                "joints '{}' and '{}' would both be {letter}; call one of them by another of {} in the description",
                machine.axes[k].name,
                axis.name,
                names.join(", ")
            )));
        }
        letters.push(letter);
    }
    Ok(letters)
}

/// `table`, then `table 2`: pairs of bodies are named.
fn free_name(all: &Bodies, name: &str) -> String {
    let taken = |name: &str| all.bodies.iter().any(|body| body.name == name);
    let numbered = (1..).map(|k| if k == 1 { name.to_string() } else { format!("{name} {k}") });
    numbered.take(all.bodies.len() + 1).find(|name| !taken(name)).unwrap_or_else(|| name.to_string())
}

/// A solid that people can read in a file: a cylinder as it is, everything else the box about it along the directions of R.
fn plain(body: &Body, solid: &Solid) -> Body {
    if let Solid::Cylinder { .. } = solid {
        return Body { solids: vec![solid.clone()], ..body.clone() };
    }
    let (low, high) = extent(&Body { solids: vec![solid.clone()], ..body.clone() });
    Body {
        solids: vec![Solid::Box { half_mm: (high - low) * 0.5 }],
        at: Pose { rotation: Matrix3::identity(), translation_mm: (low + high) * 0.5 },
        ..body.clone()
    }
}

/// Lowest and highest coordinates of a body in R, mm.
fn extent(body: &Body) -> (Vector3<f64>, Vector3<f64>) {
    let (rotation, at) = (&body.at.rotation, &body.at.translation_mm);
    let mut low = Vector3::repeat(f64::INFINITY);
    let mut high = Vector3::repeat(f64::NEG_INFINITY);
    for solid in &body.solids {
        let mut about = |middle: Vector3<f64>, half: Vector3<f64>| {
            low = low.inf(&(middle - half));
            high = high.sup(&(middle + half));
        };
        match solid {
            Solid::Box { half_mm } => about(*at, rotation.abs() * half_mm),
            Solid::Ball { radius_mm } => about(*at, Vector3::repeat(*radius_mm)),
            Solid::Cylinder { radius_mm, half_mm } => {
                let along = rotation.column(2);
                let round = along.map(|part| radius_mm * (1.0 - part * part).max(0.0).sqrt());
                about(*at, along.abs() * *half_mm + round);
            }
            Solid::Capsule { radius_mm, half_mm } => {
                about(*at, rotation.column(2).abs() * *half_mm + Vector3::repeat(*radius_mm));
            }
            Solid::Hull { corners } => {
                corners.iter().for_each(|corner| about(rotation * corner + at, Vector3::zeros()));
            }
        }
    }
    (low, high)
}

/// The highest upward face of the link that carries the workpiece, or a table at the workpiece link's frame.
fn surface(all: &mut Bodies, link: &str, wishes: &Wishes) -> Result<Mount, SizesError> {
    if let (None, Some(size)) = (all.bodies.iter().find(|body| body.link == *link), wishes.table) {
        let top = wishes.workpiece.translation_mm;
        let middle = top - Vector3::z() * (0.5 * TABLE_MM);
        let [x, y] = size.half();
        let (solid, rotation) = match size {
            TableSize::Disc { .. } => {
                (Solid::Cylinder { radius_mm: x, half_mm: 0.5 * TABLE_MM }, frame_along(&Vector3::z()))
            }
            TableSize::Rectangle { .. } => {
                (Solid::Box { half_mm: Vector3::new(x, y, 0.5 * TABLE_MM) }, Matrix3::identity())
            }
        };
        all.bodies.push(Body {
            name: free_name(all, "work table"),
            link: link.to_string(),
            solids: vec![solid],
            at: Pose { rotation, translation_mm: middle },
        });
    }
    let of_link = all.bodies.iter().filter(|body| body.link == *link);
    let wide = of_link.filter(|body| {
        let (low, high) = extent(body);
        (high - low).xy().min() >= SURFACE_MM
    });
    let highest = wide.max_by(|one, other| extent(one).1.z.total_cmp(&extent(other).1.z));
    let Some(body) = highest else {
        return Err(SizesError(format!(
            "link {link}, which carries the workpiece, has no collision geometry with a surface of {SURFACE_MM} mm; say the table's size with --table, e.g. --table 320"
        )));
    };
    let (low, high) = extent(body);
    let size = high - low;
    let upright = body.at.rotation.column(2).z.abs() > 1.0 - 1e-9;
    let outline = match body.solids.first() {
        Some(Solid::Cylinder { radius_mm, .. }) if upright => {
            Outline::Disc { inner_radius_mm: 0.0, radius_mm: *radius_mm }
        }
        _ => Outline::Rectangle { size_mm: [size.x, size.y] },
    };
    let middle = Vector3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), high.z);
    Ok(Mount {
        name: "table top".into(),
        link: link.to_string(),
        middle,
        normal: Vector3::z(),
        along: Vector3::x(),
        outline,
        slot_pitch_mm: None,
    })
}

/// The nose at the tool link's frame, whose z lies along the spindle; the tool looks to where the workpiece is.
fn nose(all: &mut Bodies, link: &str, wishes: &Wishes) -> SpindleSide {
    let nose = wishes.tool.translation_mm;
    let along: Vector3<f64> = wishes.tool.rotation.column(2).into_owned();
    let ahead = (wishes.workpiece.translation_mm - nose).dot(&along);
    // from the tip into the spindle
    let direction = if ahead > 0.0 { -along } else { along }.map(|part| if part.abs() < 1e-9 { 0.0 } else { part });
    if all.bodies.iter().all(|body| body.link != *link) {
        all.bodies.push(Body {
            name: free_name(all, "spindle housing"),
            link: link.to_string(),
            solids: vec![Solid::Cylinder { radius_mm: 0.5 * wishes.housing_mm, half_mm: 0.5 * HOUSING_MM }],
            at: Pose { rotation: frame_along(&direction), translation_mm: nose + direction * (0.5 * HOUSING_MM) },
        });
    }
    SpindleSide { link: link.to_string(), nose, direction, gauge_length_mm: GAUGE_MM }
}

/// Lists parts of neighbouring links that meet at zero as joined.
fn join(all: &mut Bodies, code: &StructuralCode) {
    let outward: Vec<&str> = code.workpiece_side.iter().rev().map(String::as_str).collect();
    let tool: Vec<&str> = code.tool_side.iter().map(String::as_str).collect();
    let is_next = |one: &str, other: &str| {
        [&outward, &tool].iter().any(|side| {
            let links: Vec<&str> = std::iter::once("b").chain(side.iter().copied()).collect();
            links.windows(2).any(|pair| [pair[0], pair[1]] == [one, other] || [pair[1], pair[0]] == [one, other])
        })
    };
    let mut joined = Vec::new();
    for (k, one) in all.bodies.iter().enumerate() {
        for other in all.bodies[k + 1..].iter().filter(|other| is_next(&one.link, &other.link)) {
            let (a, b) = (extent(one), extent(other));
            let gap = (a.0 - b.1).sup(&(b.0 - a.1)).sup(&Vector3::zeros()).norm();
            if gap < JOINED_MM {
                joined.push((one.name.clone(), other.name.clone()));
            }
        }
    }
    all.touching = joined;
}

//! The ball bar of one test as solids: balls, necks, bar, cups, stems, stand and fixture. Where it stands is the test's.

use nalgebra::Vector3;

use super::convex::Convex;
use super::scene::{BarEnds, Cone, Scene};
use super::world::{Part, World};
use crate::bodies::{Bodies, Kit, Mount};
use crate::chain::Geometry;
use crate::session::{Path, Test};

/// A bar stays this far inside the cones of its cups, rad: cups stand and are made to some tenths of a degree, and the rim
/// that a bar touches is half a millimetre farther, seen from 30 mm.
pub const CONE_MARGIN_RAD: f64 = 1.0 / 180.0 * std::f64::consts::PI;
/// A part of a mount's body may rise above the surface by this and still be what the stand stands on, mm: pieces of meshes
/// are a little larger than what they cover.
const SEAT_MM: f64 = 2.0;

/// Where an instrument stands: what a test says and what the machine offers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement<'a> {
    pub mount: &'a Mount,
    /// Ball centre above the surface, mm.
    pub height_mm: f64,
}

/// Why an instrument cannot be placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InstrumentError {
    #[error(
        "test '{test}': the pivot at ({x:.3}, {y:.3}, {z:.3}) on link {link} stands on no mounting surface; surfaces of that link: {known}"
    )]
    NoMount { test: String, link: String, x: f64, y: f64, z: f64, known: String },
    #[error("test '{test}': {reason}")]
    NoSpindle { test: String, reason: String },
    #[error("test '{test}': bar {found} mm is not made by the kit '{kit}', which makes {known}")]
    NoBar { test: String, found: f64, kit: String, known: String },
}

/// The instrument of one test.
#[derive(Debug, Clone)]
pub struct Instrument<'a> {
    pub placement: Placement<'a>,
    parts: Vec<Part>,
    bar: BarEnds,
    cones: Vec<Cone>,
    /// World parts on which the stand stands and which hold the stem: touch by design.
    stands_on: Vec<usize>,
    clamped_by: Vec<usize>,
    stand_parts: Vec<usize>,
    stem_parts: Vec<usize>,
    /// Parts of the bar, by index.
    bar_parts: Vec<usize>,
    cup_parts: [usize; 2],
    ball_parts: [usize; 2],
    spindle_cup_looks: Vector3<f64>,
}

impl<'a> Placement<'a> {
    /// The surface on which a pivot ball stands.
    pub fn of(
        bodies: &'a Bodies,
        kit: &Kit,
        test: &Test,
        same_link: impl Fn(&str) -> bool,
    ) -> Result<Placement<'a>, InstrumentError> {
        let at = test.pivot.at;
        let [lowest, highest] = kit.pivot_stand.height_mm;
        let mut known = Vec::new();
        for mount in bodies.mounts.iter().filter(|mount| same_link(&mount.link)) {
            let from = at - mount.middle;
            let height_mm = from.dot(&mount.normal);
            let u = from.dot(&mount.along);
            let v = from.dot(&mount.across());
            let free = Mount { slot_pitch_mm: None, ..mount.clone() };
            if height_mm >= lowest - 1e-6 && height_mm <= highest + 1e-6 && free.holds(u, v, 0.0) {
                return Ok(Placement { mount, height_mm });
            }
            known.push(format!("{} (ball {lowest} to {highest} mm above it)", mount.name));
        }
        let known = if known.is_empty() { "none".to_string() } else { known.join(", ") };
        Err(InstrumentError::NoMount {
            test: test.name.clone(),
            link: test.pivot.link.clone(),
            x: at.x,
            y: at.y,
            z: at.z,
            known,
        })
    }
}

impl<'a> Instrument<'a> {
    /// The instrument of a test on a machine.
    pub fn of(world: &World, bodies: &'a Bodies, kit: &Kit, test: &Test) -> Result<Instrument<'a>, InstrumentError> {
        let chain = world.chain();
        let pivot_link = chain.link(&test.pivot.link);
        let placement = Placement::of(bodies, kit, test, |link| chain.link(link) == pivot_link)?;
        let no_spindle = |reason: String| InstrumentError::NoSpindle { test: test.name.clone(), reason };
        let spindle = bodies.spindle.as_ref().ok_or_else(|| {
            no_spindle("the machine file has no 'spindle'; add its link, nose and direction".to_string())
        })?;
        let (Some(pivot_link), Some(spindle_link)) = (pivot_link, chain.link(&test.spindle_ball.link)) else {
            return Err(no_spindle("a ball is on a link that the machine has not".into()));
        };
        if chain.link(&spindle.link) != Some(spindle_link) {
            return Err(no_spindle(format!(
                "the spindle ball is on link {}, the spindle on {}",
                test.spindle_ball.link, spindle.link
            )));
        }
        let (pivot_frame, spindle_frame) = (world.frame(pivot_link), world.frame(spindle_link));
        let bar_frame = world.frame_count();
        let (pivot, ball) = (test.pivot.at, test.spindle_ball.at);
        let normal = placement.mount.normal;
        let foot = pivot - normal * placement.height_mm;
        let bar = &kit.bar;
        let length = test.bar_length_mm.unwrap_or(bar.length_mm);
        let known = kit.lengths_mm();
        if !known.iter().any(|&made| (made - length).abs() <= bar.half_stroke_mm) {
            let known: Vec<String> = known.iter().map(|made| made.to_string()).collect();
            let known = format!("{} mm, ± {} mm stroke", known.join(" "), bar.half_stroke_mm);
            return Err(InstrumentError::NoBar {
                test: test.name.clone(),
                found: length,
                kit: kit.name.clone(),
                known,
            });
        }
        let along = |s: f64| Vector3::new(0.0, 0.0, s);
        let mut parts = vec![
            Part::new("pivot ball", pivot_frame, Convex::ball(pivot, bar.ball_radius_mm)),
            Part::new("spindle ball", spindle_frame, Convex::ball(ball, bar.ball_radius_mm)),
            Part::new("bar", bar_frame, Convex::capsule(along(0.0), along(length), bar.neck_radius_mm)),
        ];
        let mut bar_parts = vec![2];
        // the rounded ends of the thick part stay behind the necks
        let (from, to) = (bar.neck_length_mm + bar.radius_mm, length - bar.neck_length_mm - bar.radius_mm);
        if to > from {
            bar_parts.push(parts.len());
            parts.push(Part::new("bar", bar_frame, Convex::capsule(along(from), along(to), bar.radius_mm)));
        }
        let cup = &kit.pivot_cup;
        let rim = pivot - normal * cup.rim_below_ball_mm;
        let below = rim - normal * cup.height_mm;
        let pivot_cup = parts.len();
        parts.push(Part::new("pivot cup", pivot_frame, Convex::cylinder(rim, below, cup.radius_mm)));
        let stand = &kit.pivot_stand;
        let base_top = foot + normal * stand.base_height_mm;
        let mut stand_parts = vec![parts.len()];
        parts.push(Part::new("pivot base", pivot_frame, Convex::cylinder(foot, base_top, stand.base_radius_mm)));
        if (below - foot).dot(&normal) > stand.base_height_mm {
            stand_parts.push(parts.len());
            parts.push(Part::new("pivot stem", pivot_frame, Convex::cylinder(base_top, below, cup.stem_radius_mm)));
        }
        let gauge_mm = (spindle.nose - ball).dot(&spindle.direction);
        let aside = ball - (spindle.nose - spindle.direction * gauge_mm);
        let up = spindle.direction;
        let spindle_cup = parts.len();
        let looks = if aside.norm() < 1e-6 { -up } else { fixture_look(world, test, &aside.normalize(), &up) };
        let cup = &kit.spindle_cup;
        let rim = ball - looks * cup.rim_below_ball_mm;
        let back = rim - looks * cup.height_mm;
        parts.push(Part::new("spindle cup", spindle_frame, Convex::cylinder(rim, back, cup.radius_mm)));
        // of a fixture the shank alone is in the spindle
        let mut stem_parts = Vec::new();
        if aside.norm() < 1e-6 {
            if gauge_mm < cup.rim_below_ball_mm + cup.height_mm {
                return Err(no_spindle(format!(
                    "the spindle ball is {gauge_mm:.3} mm in front of the nose, which leaves no room for its cup ({} mm)",
                    cup.rim_below_ball_mm + cup.height_mm
                )));
            }
            stem_parts.push(parts.len());
            let stem = Convex::cylinder(back, spindle.nose, cup.stem_radius_mm);
            parts.push(Part::new("spindle stem", spindle_frame, stem));
        } else {
            let fixture = kit.fixture.as_ref().ok_or_else(|| {
                no_spindle(format!("the spindle ball is off the tool axis and the kit '{}' has no fixture", kit.name))
            })?;
            // the flat bar passes behind the cup
            let arm_end = back - looks * fixture.arm_radius_mm;
            let root = spindle.nose - up * (spindle.nose - arm_end).dot(&up);
            if (spindle.nose - root).dot(&up) < 0.0 {
                return Err(no_spindle(format!(
                    "the fixture does not fit: the ball is {gauge_mm:.3} mm in front of the nose"
                )));
            }
            let arm = Convex::capsule(root, arm_end, fixture.arm_radius_mm);
            parts.push(Part::new("fixture", spindle_frame, arm));
            stem_parts.push(parts.len());
            let shank = Convex::cylinder(root, spindle.nose, fixture.arm_radius_mm);
            parts.push(Part::new("fixture", spindle_frame, shank));
        }
        let lever_mm = bar.neck_length_mm;
        let cone = |name, frame, axis, half_angle_rad, at_pivot| Cone {
            name,
            frame,
            axis,
            half_angle_rad: half_angle_rad - CONE_MARGIN_RAD,
            at_pivot,
            lever_mm,
        };
        let cones = vec![
            cone("cone of the pivot cup", pivot_frame, normal, kit.pivot_cup.cone_rad, true),
            cone("cone of the spindle cup", spindle_frame, looks, kit.spindle_cup.cone_rad, false),
        ];
        Ok(Instrument {
            stands_on: body_behind(world, pivot_frame, &foot, &normal),
            clamped_by: body_behind(world, spindle_frame, &spindle.nose, &-up),
            placement,
            parts,
            bar: BarEnds { pivot: (pivot_frame, pivot), spindle: (spindle_frame, ball) },
            cones,
            stand_parts,
            stem_parts,
            bar_parts,
            cup_parts: [pivot_cup, spindle_cup],
            ball_parts: [0, 1],
            spindle_cup_looks: looks,
        })
    }

    /// Direction in which the cup at the spindle looks, in R with all axes at zero, unit length.
    pub fn spindle_cup_looks(&self) -> Vector3<f64> {
        self.spindle_cup_looks
    }

    /// The machine with this instrument mounted.
    pub fn scene<'w>(&self, world: &'w World) -> Scene<'w> {
        let pairs = self.pairs(world, |_| true);
        Scene::new(world, self.parts.clone(), pairs, Some(self.bar.clone()), self.cones.clone())
    }

    /// The machine with stand, cups and balls, the bar taken off: what travels from test to test.
    pub fn scene_without_bar<'w>(&self, world: &'w World) -> Scene<'w> {
        let kept: Vec<usize> = (0..self.parts.len()).filter(|part| !self.bar_parts.contains(part)).collect();
        let first = world.parts.len();
        let place = |index: usize| match index.checked_sub(first) {
            None => index,
            Some(part) => first + kept.iter().position(|&other| other == part).unwrap_or_default(),
        };
        let pairs = self.pairs(world, |part| kept.contains(&part));
        let pairs = pairs.into_iter().map(|(one, other)| (place(one), place(other))).collect();
        Scene::new(world, kept.iter().map(|&part| self.parts[part].clone()).collect(), pairs, None, Vec::new())
    }

    /// Pairs of the instrument's parts that are mounted, with the machine and with each other; machine parts count first.
    fn pairs(&self, world: &World, mounted: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
        let first = world.parts.len();
        let mut pairs = Vec::new();
        for part in (0..self.parts.len()).filter(|part| mounted(*part)) {
            let by_design: &[usize] = if self.stand_parts.contains(&part) {
                &self.stands_on
            } else if self.stem_parts.contains(&part) {
                &self.clamped_by
            } else {
                &[]
            };
            let compared = (0..first).filter(|body| !by_design.contains(body));
            pairs.extend(compared.map(|body| (body, first + part)));
        }
        for part in 0..self.parts.len() {
            for other in part + 1..self.parts.len() {
                if mounted(part) && mounted(other) && self.may_meet(part, other) {
                    pairs.push((first + part, first + other));
                }
            }
        }
        pairs
    }

    fn may_meet(&self, one: usize, other: usize) -> bool {
        if self.parts[one].frame == self.parts[other].frame {
            return false;
        }
        let bar = |part: usize| self.bar_parts.contains(&part);
        let held = |part: usize| self.cup_parts.contains(&part) || self.ball_parts.contains(&part);
        !(bar(one) && held(other) || bar(other) && held(one))
    }
}

/// Whether the cup of a fixture looks down the tool or outward: the way that is nearer to the bar in the middle of the test.
fn fixture_look(world: &World, test: &Test, outward: &Vector3<f64>, up: &Vector3<f64>) -> Vector3<f64> {
    let mut q: Vec<f64> =
        (0..world.chain().axis_count()).map(|k| test.positions.get(k).copied().flatten().unwrap_or(0.0)).collect();
    if let Some(Path::Sweep { axis, from, to, .. }) = &test.path {
        q[*axis] = world.chain().joint(*axis).kind.from_file_unit(0.5 * (from + to));
    } else if let Some(recording) = &test.recording {
        for (axis, positions) in recording.axes.iter().zip(&recording.positions) {
            q[*axis] = positions.get(positions.len() / 2).copied().unwrap_or(0.0);
        }
    }
    let Ok((pivot, spindle)) = test.links(world.chain()) else { return -up };
    let geometry = Geometry::nominal(world.chain());
    let bar =
        geometry.point(pivot, &test.pivot.at, &q, None) - geometry.point(spindle, &test.spindle_ball.at, &q, None);
    let in_link = geometry.pose(spindle, &q, None).rotation.tr_mul(&bar);
    if in_link.dot(outward) > in_link.dot(&-up) { *outward } else { -up }
}

/// Parts of the one body of a frame that is nearest to a point of a surface, as far as they lie behind the surface.
fn body_behind(world: &World, frame: usize, at: &Vector3<f64>, outward: &Vector3<f64>) -> Vec<usize> {
    let point = Convex::ball(*at, 0.0);
    let pose = crate::chain::Pose::identity();
    let carried = || (0..world.parts.len()).filter(|&part| world.parts[part].frame == frame);
    let away = |part: usize| super::distance(&world.parts[part].convex, &pose, &point, &pose);
    // of several at the same distance the one that rises least is the surface
    let rises = |part: usize| world.parts[part].convex.farthest_mm(outward) - at.dot(outward);
    let key = |part: usize| ((away(part) / SEAT_MM).ceil(), rises(part));
    let nearest = carried().min_by(|&a, &b| {
        let ((near, low), (other_near, other_low)) = (key(a), key(b));
        near.total_cmp(&other_near).then(low.total_cmp(&other_low))
    });
    let Some(nearest) = nearest else { return Vec::new() };
    let of_body = carried().filter(|&part| world.body_of[part] == world.body_of[nearest]);
    of_body.filter(|&part| part == nearest || rises(part) <= SEAT_MM).collect()
}

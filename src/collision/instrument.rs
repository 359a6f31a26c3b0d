//! The ball bar of one test on a machine: where it is mounted and which of its parts may meet what. Where it stands is the test's.

use std::ops::Range;

use nalgebra::Vector3;

use super::convex::Convex;
use super::scene::{BarEnds, Cone, Scene};
use super::solids::{Nose, bar_solids, stand_solids};
use super::world::{Part, World};
use crate::bodies::{Bodies, Kit, Mount};
use crate::machine::{Machine, SpindleSide};
use crate::session::Test;

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
    /// Base and stem under the pivot cup, by index.
    stand_parts: Range<usize>,
    /// What is clamped in the spindle: of a fixture the shank alone.
    stem_part: usize,
    /// Parts of the bar, by index.
    bar_parts: Range<usize>,
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

/// Where both balls of a test are on the machine.
struct Links<'a> {
    placement: Placement<'a>,
    spindle: &'a SpindleSide,
    pivot_frame: usize,
    spindle_frame: usize,
}

impl<'a> Links<'a> {
    /// The surface under the pivot and the spindle that holds the other ball, when the machine has both.
    fn of(
        world: &World,
        (machine, bodies): (&'a Machine, &'a Bodies),
        kit: &Kit,
        test: &Test,
    ) -> Result<Links<'a>, InstrumentError> {
        let chain = world.chain();
        let pivot_link = chain.link(&test.pivot.link);
        let placement = Placement::of(bodies, kit, test, |link| chain.link(link) == pivot_link)?;
        let spindle = machine.spindle.as_ref().ok_or_else(|| {
            no_spindle(test, "the machine file has no 'spindle'; add its link, nose and direction".to_string())
        })?;
        let (Some(pivot_link), Some(spindle_link)) = (pivot_link, chain.link(&test.spindle_ball.link)) else {
            return Err(no_spindle(test, "a ball is on a link that the machine has not".into()));
        };
        if chain.link(&spindle.link) != Some(spindle_link) {
            let (ball, spindle) = (&test.spindle_ball.link, &spindle.link);
            return Err(no_spindle(test, format!("the spindle ball is on link {ball}, the spindle on {spindle}")));
        }
        Ok(Links { placement, spindle, pivot_frame: world.frame(pivot_link), spindle_frame: world.frame(spindle_link) })
    }
}

/// The refusal of a test whose ball the spindle cannot hold.
fn no_spindle(test: &Test, reason: String) -> InstrumentError {
    InstrumentError::NoSpindle { test: test.name.clone(), reason }
}

/// Length of the bar of a test, mm, when the kit makes it.
fn bar_length_mm(kit: &Kit, test: &Test) -> Result<f64, InstrumentError> {
    let length_mm = test.bar_length_mm.unwrap_or(kit.bar.length_mm);
    let made = kit.lengths_mm();
    if made.iter().any(|&made| (made - length_mm).abs() <= kit.bar.half_stroke_mm) {
        return Ok(length_mm);
    }
    let known: Vec<String> = made.iter().map(|made| made.to_string()).collect();
    Err(InstrumentError::NoBar {
        test: test.name.clone(),
        found: length_mm,
        kit: kit.name.clone(),
        known: format!("{} mm, ± {} mm stroke", known.join(" "), kit.bar.half_stroke_mm),
    })
}

impl<'a> Instrument<'a> {
    /// The instrument of a test on a machine.
    pub fn of(
        world: &World,
        machine: &'a Machine,
        bodies: &'a Bodies,
        kit: &Kit,
        test: &Test,
    ) -> Result<Instrument<'a>, InstrumentError> {
        let Links { placement, spindle, pivot_frame, spindle_frame } = Links::of(world, (machine, bodies), kit, test)?;
        let bar_frame = world.frame_count();
        let (pivot, ball) = (test.pivot.at, test.spindle_ball.at);
        let normal = placement.mount.normal;
        let length_mm = bar_length_mm(kit, test)?;
        let nose = Nose::of(world, test, spindle);
        let held = nose.solids(kit, spindle_frame).map_err(|reason| no_spindle(test, reason))?;
        let mut parts = vec![
            Part::new("pivot ball", pivot_frame, Convex::ball(pivot, kit.bar.ball_radius_mm)),
            Part::new("spindle ball", spindle_frame, Convex::ball(ball, kit.bar.ball_radius_mm)),
        ];
        let mut mounted = |solids: Vec<Part>| {
            let from = parts.len();
            parts.extend(solids);
            from..parts.len()
        };
        let bar_parts = mounted(bar_solids(&kit.bar, bar_frame, length_mm));
        let stand_parts = mounted(stand_solids(kit, pivot_frame, pivot, normal, placement.height_mm));
        let held_parts = mounted(held);
        let lever_mm = kit.bar.neck_length_mm;
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
            cone("cone of the spindle cup", spindle_frame, nose.looks, kit.spindle_cup.cone_rad, false),
        ];
        Ok(Instrument {
            stands_on: body_behind(world, pivot_frame, &(pivot - normal * placement.height_mm), &normal),
            clamped_by: body_behind(world, spindle_frame, &spindle.nose, &-spindle.direction),
            placement,
            parts,
            bar: BarEnds { pivot: (pivot_frame, pivot), spindle: (spindle_frame, ball) },
            cones,
            cup_parts: [stand_parts.start, held_parts.start],
            stand_parts: stand_parts.start + 1..stand_parts.end,
            stem_part: held_parts.end - 1,
            bar_parts,
            ball_parts: [0, 1],
            spindle_cup_looks: nose.looks,
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
            } else if part == self.stem_part {
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

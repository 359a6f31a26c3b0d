//! Solids of a ball bar: bar, stand under the pivot, and what holds the ball at the spindle. Which of them may meet is the instrument's.

use nalgebra::Vector3;

use super::convex::Convex;
use super::world::{Part, World};
use crate::bodies::{Bar, Kit};
use crate::chain::Geometry;
use crate::machine::SpindleSide;
use crate::session::{Path, Test};

/// A ball that is farther from the tool axis than this is held by a fixture, mm.
const ON_AXIS_MM: f64 = 1e-6;

/// The bar on its own frame: its neck through all of it, and the thick part when it is long enough to have one.
pub fn bar_solids(bar: &Bar, frame: usize, length_mm: f64) -> Vec<Part> {
    let along = |s: f64| Vector3::new(0.0, 0.0, s);
    let capsule = |from, to, radius| Part::new("bar", frame, Convex::capsule(along(from), along(to), radius));
    let mut parts = vec![capsule(0.0, length_mm, bar.neck_radius_mm)];
    // the rounded ends of the thick part stay behind the necks
    let (from, to) = (bar.neck_length_mm + bar.radius_mm, length_mm - bar.neck_length_mm - bar.radius_mm);
    if to > from {
        parts.push(capsule(from, to, bar.radius_mm));
    }
    parts
}

/// The pivot's cup, then the base of its stand on the surface below and the stem between both when they do not touch.
pub fn stand_solids(kit: &Kit, frame: usize, pivot: Vector3<f64>, normal: Vector3<f64>, height_mm: f64) -> Vec<Part> {
    let (cup, stand) = (&kit.pivot_cup, &kit.pivot_stand);
    let foot = pivot - normal * height_mm;
    let rim = pivot - normal * cup.rim_below_ball_mm;
    let below = rim - normal * cup.height_mm;
    let base_top = foot + normal * stand.base_height_mm;
    let mut parts = vec![
        Part::new("pivot cup", frame, Convex::cylinder(rim, below, cup.radius_mm)),
        Part::new("pivot base", frame, Convex::cylinder(foot, base_top, stand.base_radius_mm)),
    ];
    if (below - foot).dot(&normal) > stand.base_height_mm {
        parts.push(Part::new("pivot stem", frame, Convex::cylinder(base_top, below, cup.stem_radius_mm)));
    }
    parts
}

/// The spindle's nose with the ball that it holds.
pub struct Nose<'a> {
    spindle: &'a SpindleSide,
    ball: Vector3<f64>,
    /// Ball in front of the nose, along the tool axis, mm.
    gauge_mm: f64,
    is_on_axis: bool,
    /// Direction in which the cup looks, in R with all axes at zero, unit length.
    pub looks: Vector3<f64>,
}

impl<'a> Nose<'a> {
    /// The nose as a test uses it.
    pub fn of(world: &World, test: &Test, spindle: &'a SpindleSide) -> Nose<'a> {
        let ball = test.spindle_ball.at;
        let up = spindle.direction;
        let gauge_mm = (spindle.nose - ball).dot(&up);
        let aside = ball - (spindle.nose - up * gauge_mm);
        let is_on_axis = aside.norm() < ON_AXIS_MM;
        let looks = if is_on_axis { -up } else { fixture_look(world, test, &aside.normalize(), &up) };
        Nose { spindle, ball, gauge_mm, is_on_axis, looks }
    }

    /// The cup, then what holds it; last the part that is clamped in the spindle. `Err` says why it does not fit.
    pub fn solids(&self, kit: &Kit, frame: usize) -> Result<Vec<Part>, String> {
        let cup = &kit.spindle_cup;
        let rim = self.ball - self.looks * cup.rim_below_ball_mm;
        let back = rim - self.looks * cup.height_mm;
        let mut parts = vec![Part::new("spindle cup", frame, Convex::cylinder(rim, back, cup.radius_mm))];
        if self.is_on_axis {
            parts.push(self.stem(kit, frame, back)?);
        } else {
            parts.extend(self.fixture(kit, frame, back)?);
        }
        Ok(parts)
    }

    /// The stem between the nose and the back of a cup on the tool axis.
    fn stem(&self, kit: &Kit, frame: usize, back: Vector3<f64>) -> Result<Part, String> {
        let cup = &kit.spindle_cup;
        let cup_mm = cup.rim_below_ball_mm + cup.height_mm;
        if self.gauge_mm < cup_mm {
            return Err(format!(
                "the spindle ball is {:.3} mm in front of the nose, which leaves no room for its cup ({cup_mm} mm)",
                self.gauge_mm
            ));
        }
        Ok(Part::new("spindle stem", frame, Convex::cylinder(back, self.spindle.nose, cup.stem_radius_mm)))
    }

    /// Arm and shank of the fixture behind a cup off the tool axis; the shank alone is in the spindle.
    fn fixture(&self, kit: &Kit, frame: usize, back: Vector3<f64>) -> Result<[Part; 2], String> {
        let fixture = kit.fixture.as_ref().ok_or_else(|| {
            format!("the spindle ball is off the tool axis and the kit '{}' has no fixture", kit.name)
        })?;
        let (nose, up) = (self.spindle.nose, self.spindle.direction);
        // the flat bar passes behind the cup
        let arm_end = back - self.looks * fixture.arm_radius_mm;
        let root = nose - up * (nose - arm_end).dot(&up);
        if (nose - root).dot(&up) < 0.0 {
            return Err(format!("the fixture does not fit: the ball is {:.3} mm in front of the nose", self.gauge_mm));
        }
        let arm = Convex::capsule(root, arm_end, fixture.arm_radius_mm);
        let shank = Convex::cylinder(root, nose, fixture.arm_radius_mm);
        Ok([Part::new("fixture", frame, arm), Part::new("fixture", frame, shank)])
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
    let Ok(links) = test.links(world.chain()) else { return -up };
    let geometry = Geometry::nominal(world.chain());
    let to_pivot = -test.bar(&geometry, links, &q);
    let in_link = geometry.pose(links.1, &q, None).rotation.tr_mul(&to_pivot);
    if in_link.dot(outward) > in_link.dot(&-up) { *outward } else { -up }
}

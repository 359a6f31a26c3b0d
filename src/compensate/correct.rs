//! Axis positions of the erring machine near programmed ones, for an ideal tool pose. It knows no programs.

use nalgebra::{Matrix2, Vector2, Vector3};

use super::command::{Positions, slide_step};
use super::memory::{Brackets, Memories, Search};
use crate::inverse::{AxisInWorkpiece, Kinematics, Tool, ToolPose};

/// Nearer to a singular direction than this, rad (two degrees), the turn that corrects the tool's direction is held back:
/// there it grows as 1/sin of the angle, and at the direction itself no small turn helps.
pub const POLE_ZONE_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Newton steps; errors of a machine need three.
const MOST_STEPS: usize = 12;
/// The same where ways of axes count: halving a bracket of 100 µm to a nanometre takes some twenty.
const MOST_STEPS_OF_WAYS: usize = 60;
/// The tip is met within this for a command to be right, mm.
const NEAR_MM: f64 = 1e-5;
/// Tip and direction meet the ideal ones within this, mm and rad.
const MET_MM: f64 = 1e-9;
const MET_RAD: f64 = 1e-12;

/// Corrected positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corrected {
    pub positions: Positions,
    /// Angle by which the tool's direction stays off, rad.
    pub off_rad: f64,
    /// The tip is where it ought to be; of what the way of the axes has left no command may be right.
    pub is_met: bool,
}

/// The erring machine.
#[derive(Debug, Clone)]
pub struct Corrector<'a> {
    actual: Kinematics<'a>,
    sliding: [usize; 3],
    turning: Vec<usize>,
    /// What the way of the axes has left.
    pub(super) memories: Memories,
    scratch: Vec<AxisInWorkpiece>,
}

impl<'a> Corrector<'a> {
    /// A machine with three slides and at most two rotary axes, by index.
    pub fn new(actual: Kinematics<'a>, sliding: [usize; 3], turning: &[usize]) -> Corrector<'a> {
        Corrector { actual, sliding, turning: turning.to_vec(), memories: Memories::default(), scratch: Vec::new() }
    }

    /// Another tool in the spindle.
    pub fn take_tool(&mut self, tool: Tool) {
        self.actual = self.actual.with_tool(tool);
    }

    /// The tool of the erring machine that is driven from where it stands to positions.
    pub fn pose(&self, positions: &Positions) -> ToolPose {
        let positions = (positions, &positions[..self.actual.machine().axes.len()]);
        if self.memories.is_empty() {
            return self.actual.pose(positions.1);
        }
        let mut motion = self.motion(positions.1);
        self.memories.add_driven(positions.0, &mut motion);
        self.actual.pose_with(positions.1, Some(&motion))
    }

    /// Component errors by the position, by axis.
    fn motion(&self, positions: &[f64]) -> Vec<[f64; 6]> {
        self.actual.component_errors(positions).unwrap_or_else(|| vec![[0.0; 6]; positions.len()])
    }

    /// Positions near `programmed` at which the erring machine's tool stands as `ideal`.
    ///
    /// What the way itself changes is found in a second search: the first one tells which way each axis has to go.
    pub fn correct(&mut self, ideal: &ToolPose, programmed: &Positions) -> Corrected {
        let first = self.search(ideal, programmed, programmed, Search::Past);
        let machine = self.actual.machine();
        if self.memories.is_empty() || !self.memories.ask(machine, &first.positions) {
            return first;
        }
        let mut second = self.search(ideal, programmed, &first.positions, Search::Settled);
        self.memories.keep_waiting(&mut second.positions);
        second
    }

    /// Newton steps of slides and turns together, from a start. The turns stay near the programmed ones: with the direction's
    /// derivatives `c = k × d` they minimise `|C t − b|² + λ t²`, λ = 0 outside the zone of singular directions.
    fn search(&mut self, ideal: &ToolPose, programmed: &Positions, start: &Positions, search: Search) -> Corrected {
        let count = self.actual.machine().axes.len();
        let mut positions = *start;
        let mut off_rad = 0.0;
        let mut search = search;
        let (mut is_met, most_steps, mut brackets) = match search {
            Search::Past => (true, MOST_STEPS, Brackets::default()),
            _ => (false, MOST_STEPS_OF_WAYS, self.memories.brackets(start)),
        };
        for step in 0..most_steps {
            let mut motion = self.actual.component_errors(&positions[..count]);
            if !self.memories.is_empty() {
                self.memories.add(search, &positions, motion.get_or_insert_with(|| vec![[0.0; 6]; count]));
            }
            let pose = self.actual.pose_and_axes(&positions[..count], motion.as_deref(), &mut self.scratch);
            let lacking = ideal.tip_mm - pose.tip_mm;
            let off = ideal.axis - pose.axis;
            off_rad = off.norm();
            let turned = self.turns(&positions, programmed, &pose.axis, &off);
            let most = turned.iter().fold(0.0f64, |most, turn| most.max(turn.abs()));
            is_met |= search == Search::Way && lacking.norm() < NEAR_MM;
            if step > 0 && lacking.norm() < MET_MM && (off_rad < MET_RAD || most < MET_RAD) {
                break;
            }
            let before = positions;
            let mut rest = lacking;
            for (&axis, turn) in self.turning.iter().zip(turned.iter()) {
                rest -= self.scratch[axis].moves(&pose.tip_mm) * *turn;
                let share = self.memories.share(search, axis, &before);
                positions[axis] = brackets.next(search, axis, before[axis], (*turn, share));
            }
            let slides = slide_step(&self.scratch, self.sliding, &rest);
            for (&axis, step) in self.sliding.iter().zip(slides.iter()) {
                let share = self.memories.share(search, axis, &before);
                positions[axis] = brackets.next(search, axis, before[axis], (*step, share));
            }
            if search == Search::Settled {
                search = Search::Way;
            }
        }
        Corrected { positions, off_rad, is_met }
    }

    /// Steps of the rotary axes (at most two) that take `off` from the tool's direction.
    fn turns(&self, at: &Positions, programmed: &Positions, direction: &Vector3<f64>, off: &Vector3<f64>) -> [f64; 2] {
        let mut columns = [Vector3::zeros(); 2];
        let mut so_far = Vector2::zeros();
        for (k, &axis) in self.turning.iter().take(2).enumerate() {
            columns[k] = self.scratch[axis].turns(direction);
            so_far[k] = at[axis] - programmed[axis];
        }
        // the whole turn from the programmed position, not the step, is held back
        let wanted = off + columns[0] * so_far[0] + columns[1] * so_far[1];
        let normal = Matrix2::new(
            columns[0].norm_squared(),
            columns[0].dot(&columns[1]),
            columns[0].dot(&columns[1]),
            columns[1].norm_squared(),
        );
        let right = Vector2::new(columns[0].dot(&wanted), columns[1].dot(&wanted));
        let own = normal.symmetric_eigen();
        let mut whole = Vector2::zeros();
        for k in 0..2 {
            let vector = own.eigenvectors.column(k);
            let square = own.eigenvalues[k].max(0.0);
            let sum = square + damping(square);
            if sum > 0.0 {
                whole += vector * (vector.dot(&right) / sum);
            }
        }
        [whole[0] - so_far[0], whole[1] - so_far[1]]
    }
}

/// λ for a squared singular value: none outside the zone, rising smoothly to the zone's square at zero.
fn damping(square: f64) -> f64 {
    let zone = POLE_ZONE_RAD * POLE_ZONE_RAD;
    let share = square / zone;
    if share >= 1.0 { 0.0 } else { zone * (1.0 - share) * (1.0 - share) }
}

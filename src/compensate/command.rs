//! Coordinates of a program to axis positions and back, as the control does it with the nominal machine.

use nalgebra::{Matrix3, Vector3};

use super::modal::LETTERS;
use super::path::Place;
use crate::chain::Chain;
use crate::inverse::{AxisInWorkpiece, Kinematics, Tool, ToolPose};
use crate::machine::{AxisKind, Machine};

/// What X, Y, Z of a program are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinates {
    /// Positions of the slides.
    Axes,
    /// The tool tip in the workpiece: the control works the slides out (tool centre point control).
    Workpiece,
}

/// Positions by axis index, mm and rad; those beyond the machine's axes are zero.
pub type Positions = [f64; 9];

/// The nominal machine as a control knows it.
#[derive(Debug, Clone)]
pub struct Control<'a> {
    pub nominal: Kinematics<'a>,
    pub coordinates: Coordinates,
    /// Axis index by letter.
    pub axis_of: [Option<usize>; 9],
    /// Slides, by index.
    pub sliding: [usize; 3],
    /// Rotary axes, by index.
    pub turning: Vec<usize>,
    /// Machine coordinates of the axes at zero, mm and deg by letter.
    zero: [f64; 9],
    usual_length_mm: Option<f64>,
    /// Tip in the workpiece at coordinates 0 0 0 with the rotary axes at zero, and per coordinate.
    origin: Vector3<f64>,
    ways: Matrix3<f64>,
    ways_back: Matrix3<f64>,
    scratch: Vec<AxisInWorkpiece>,
}

impl<'a> Control<'a> {
    /// The control of a machine; a tool is `usual_length_mm` long while no length is in force.
    pub fn new(
        machine: &'a Machine,
        chain: &'a Chain,
        coordinates: Coordinates,
        usual_length_mm: Option<f64>,
    ) -> Result<Control<'a>, String> {
        let mut axis_of = [None; 9];
        for (index, axis) in machine.axes.iter().enumerate() {
            let letter = LETTERS.iter().position(|letter| axis.name.as_bytes() == [*letter]);
            let letter =
                letter.ok_or_else(|| format!("axis {} has no letter of a program (X Y Z A B C U V W)", axis.name))?;
            axis_of[letter] = Some(index);
        }
        let of_kind = |kind| (0..machine.axes.len()).filter(|&k| machine.axes[k].kind == kind).collect::<Vec<usize>>();
        let turning = of_kind(AxisKind::Rotary);
        let sliding: [usize; 3] = of_kind(AxisKind::Linear).try_into().map_err(|slides: Vec<usize>| {
            format!(
                "the machine has {} slides; programs of three slides and at most two rotary axes are corrected",
                slides.len()
            )
        })?;
        if turning.len() > 2 {
            return Err(format!(
                "the machine has {} rotary axes; programs of at most two are corrected",
                turning.len()
            ));
        }
        let unknown = "which way the tool looks is not known: state spindle: {nose: [x, y, z], direction: [i, j, k]} in the machine file";
        let nose = Tool::of(machine, Some(0.0)).ok_or(unknown)?;
        let usual = Tool::of(machine, usual_length_mm).ok_or(unknown)?;
        let zero =
            std::array::from_fn(|letter| axis_of[letter].and_then(|axis| machine.machine_zero[axis]).unwrap_or(0.0));
        let nominal = Kinematics::nominal(machine, chain, nose);
        let mut control = Control {
            nominal,
            coordinates,
            axis_of,
            sliding,
            turning,
            zero,
            usual_length_mm,
            origin: Vector3::zeros(),
            ways: Matrix3::identity(),
            ways_back: Matrix3::identity(),
            scratch: Vec::new(),
        };
        control.find_origin()?;
        control.nominal = control.nominal.with_tool(usual);
        Ok(control)
    }

    /// The frame of tip coordinates: with the rotary axes at zero they read what the slides read for a tool without length.
    fn find_origin(&mut self) -> Result<(), String> {
        let axes = [0, 1, 2].map(|letter| self.axis_of[letter]);
        let [Some(x), Some(y), Some(z)] = axes else {
            return match self.coordinates {
                Coordinates::Axes => Ok(()),
                Coordinates::Workpiece => {
                    Err("a machine without X, Y and Z has no coordinates of the workpiece".into())
                }
            };
        };
        let mut at: Positions = [0.0; 9];
        for (letter, axis) in [x, y, z].into_iter().enumerate() {
            at[axis] = -self.zero[letter];
        }
        let count = self.count();
        self.origin = self.nominal.pose_and_axes(&at[..count], None, &mut self.scratch).tip_mm;
        self.ways = Matrix3::from_columns(&[x, y, z].map(|axis| self.scratch[axis].direction));
        self.ways_back = self.ways.try_inverse().ok_or("the slides do not span space")?;
        Ok(())
    }

    /// Number of axes.
    pub fn count(&self) -> usize {
        self.nominal.machine().axes.len()
    }

    /// The tool with a length in force, `None` for none: the usual one.
    pub fn tool(&self, length_mm: Option<f64>) -> Tool {
        let length = length_mm.or(self.usual_length_mm);
        // known since the control was made
        Tool::of(self.nominal.machine(), length).unwrap_or(*self.nominal.tool())
    }

    /// Positions of the axes that the control drives to for coordinates; `near` holds a start for the slides.
    pub fn positions(&mut self, place: &Place, near: &Positions) -> Positions {
        let mut positions = *near;
        let machine = self.nominal.machine();
        for (letter, axis) in self.axis_of.iter().enumerate() {
            let Some(axis) = *axis else { continue };
            if self.coordinates == Coordinates::Axes || letter > 2 {
                positions[axis] = machine.axes[axis].kind.from_file_unit(place[letter] - self.zero[letter]);
            }
        }
        if self.coordinates == Coordinates::Workpiece {
            let tip = self.origin + self.ways * Vector3::new(place[0], place[1], place[2]);
            let count = self.count();
            let pose = self.nominal.pose_and_axes(&positions[..count], None, &mut self.scratch);
            let step = slide_step(&self.scratch, self.sliding, &(tip - pose.tip_mm));
            self.sliding.iter().zip(step.iter()).for_each(|(&axis, step)| positions[axis] += step);
        }
        positions
    }

    /// Coordinates by which the control drives to positions.
    pub fn place(&self, positions: &Positions) -> Place {
        let machine = self.nominal.machine();
        let mut place = [0.0; 9];
        for (letter, axis) in self.axis_of.iter().enumerate() {
            let Some(axis) = *axis else { continue };
            place[letter] = machine.axes[axis].kind.to_file_unit(positions[axis]) + self.zero[letter];
        }
        if self.coordinates == Coordinates::Workpiece {
            let tip = self.nominal.pose_with(&positions[..self.count()], None).tip_mm;
            let coordinates = self.ways_back * (tip - self.origin);
            place[..3].copy_from_slice(coordinates.as_slice());
        }
        place
    }

    /// The tool by the nominal machine.
    pub fn ideal(&self, positions: &Positions) -> ToolPose {
        self.nominal.pose_with(&positions[..self.count()], None)
    }
}

/// Steps of three slides that move the tip by a vector; none where they do not span space.
pub fn slide_step(axes: &[AxisInWorkpiece], sliding: [usize; 3], by: &Vector3<f64>) -> Vector3<f64> {
    let ways = Matrix3::from_columns(&sliding.map(|axis| axes[axis].direction));
    ways.try_inverse().map_or_else(Vector3::zeros, |back| back * by)
}

//! Kinematics of an erring machine written for tests alone: products of 4 × 4 matrices as FORMATS.md states them.
//! It shares nothing with the library but the numbers of the machine file.

#![allow(dead_code, reason = "shared by tests of which not all need it")]

use fiveaxis::machine::{AxisKind, ComponentForm, Machine};

pub type Matrix = [[f64; 4]; 4];

pub fn identity() -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))))
}

pub fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

pub fn shift(by: [f64; 3]) -> Matrix {
    let mut matrix = identity();
    (0..3).for_each(|k| matrix[k][3] = by[k]);
    matrix
}

/// Turn about a coordinate direction.
pub fn turn(about: usize, angle: f64) -> Matrix {
    let mut matrix = identity();
    let (i, j) = ((about + 1) % 3, (about + 2) % 3);
    (matrix[i][i], matrix[j][j]) = (angle.cos(), angle.cos());
    (matrix[i][j], matrix[j][i]) = (-angle.sin(), angle.sin());
    matrix
}

/// Turn about a unit vector by a unit quaternion.
pub fn turn_about(u: [f64; 3], angle: f64) -> Matrix {
    let (s, w) = ((0.5 * angle).sin(), (0.5 * angle).cos());
    let [x, y, z] = u.map(|part| part * s);
    let mut matrix = identity();
    matrix[0][..3].copy_from_slice(&[1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)]);
    matrix[1][..3].copy_from_slice(&[2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)]);
    matrix[2][..3].copy_from_slice(&[2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)]);
    matrix
}

pub fn apply(matrix: &Matrix, point: [f64; 3], is_point: bool) -> [f64; 3] {
    let w = if is_point { 1.0 } else { 0.0 };
    std::array::from_fn(|i| (0..3).map(|k| matrix[i][k] * point[k]).sum::<f64>() + matrix[i][3] * w)
}

/// Inverse of a rigid motion.
pub fn back(matrix: &Matrix) -> Matrix {
    let mut inverse = identity();
    for i in 0..3 {
        for j in 0..3 {
            inverse[i][j] = matrix[j][i];
        }
        inverse[i][3] = -(0..3).map(|k| matrix[k][i] * matrix[k][3]).sum::<f64>();
    }
    inverse
}

/// Tx·Ty·Tz·Rx·Ry·Rz.
fn small(e: &[f64; 6]) -> Matrix {
    if e[3..] == [0.0; 3] {
        return shift([e[0], e[1], e[2]]);
    }
    [turn(0, e[3]), turn(1, e[4]), turn(2, e[5])].iter().fold(shift([e[0], e[1], e[2]]), |sum, next| times(&sum, next))
}

fn form(form: &ComponentForm, q: f64) -> f64 {
    match form {
        ComponentForm::Polynomial(c) => c.iter().enumerate().map(|(k, c)| c * q.powi(k as i32 + 1)).sum(),
        ComponentForm::Fourier(list) => {
            list.iter().map(|h| h.cosine * ((h.frequency * q).cos() - 1.0) + h.sine * (h.frequency * q).sin()).sum()
        }
        ComponentForm::Table { position, value } => {
            let n = position.len();
            if q <= position[0] {
                return value[0];
            }
            if q >= position[n - 1] {
                return value[n - 1];
            }
            let k = (0..n - 1).find(|&k| q < position[k + 1]).expect("inside");
            value[k] + (value[k + 1] - value[k]) * (q - position[k]) / (position[k + 1] - position[k])
        }
    }
}

/// The machine, erring or as drawn.
pub struct Plain<'a> {
    pub machine: &'a Machine,
    pub errs: bool,
    /// Tip and direction from the tip into the spindle, in R with all axes at zero.
    pub tip: [f64; 3],
    pub axis: [f64; 3],
}

impl Plain<'_> {
    fn joint(&self, index: usize, q: f64) -> Matrix {
        let axis = &self.machine.axes[index];
        let workpiece = index < self.machine.code.workpiece_side.len();
        let iso = self.machine.directions == Some(fiveaxis::machine::Directions::Iso841);
        let sign = if (workpiece && iso) != axis.reversed { -1.0 } else { 1.0 };
        let u: [f64; 3] = axis.direction.into();
        let o: [f64; 3] = axis.origin.into();
        let (e, mut m) = (if self.errs { axis.location_errors } else { [0.0; 6] }, [0.0; 6]);
        if self.errs {
            for error in &axis.component_errors {
                m[error.component.index()] += form(&error.form, q);
            }
        }
        // o + M·(x − o)
        let about = |inner: &Matrix| {
            let shifted = apply(inner, o, false);
            let mut about = *inner;
            (0..3).for_each(|k| about[k][3] += o[k] - shifted[k]);
            about
        };
        match axis.kind {
            AxisKind::Rotary => about(&times(&times(&small(&e), &small(&m)), &turn_about(u, sign * q))),
            AxisKind::Linear => {
                let turned = apply(&small(&[0.0, 0.0, 0.0, e[3], e[4], e[5]]), u, false);
                let way = shift([0, 1, 2].map(|k| e[k] + turned[k] * sign * q));
                times(&way, &about(&small(&m)))
            }
        }
    }

    /// Tip and direction in the workpiece; positions in mm and rad by axis index.
    pub fn tool(&self, q: &[f64]) -> ([f64; 3], [f64; 3]) {
        let workpiece = self.machine.code.workpiece_side.len();
        let branch = |axes: Vec<usize>| axes.into_iter().fold(identity(), |sum, k| times(&sum, &self.joint(k, q[k])));
        let w = branch((0..workpiece).rev().collect());
        let t = branch((workpiece..q.len()).collect());
        let seen = times(&back(&w), &t);
        (apply(&seen, self.tip, true), apply(&seen, self.axis, false))
    }
}

impl Plain<'_> {
    /// A ball on a link (an axis, `b`, `w` or `t`) in the bed's frame.
    pub fn ball(&self, link: &str, at: [f64; 3], q: &[f64]) -> [f64; 3] {
        let workpiece = self.machine.code.workpiece_side.len();
        let axes: Vec<usize> = match (link, self.machine.axis_index(link)) {
            ("w", _) => (0..workpiece).rev().collect(),
            ("t", _) => (workpiece..q.len()).collect(),
            (_, Some(axis)) if axis < workpiece => (axis..workpiece).rev().collect(),
            (_, Some(axis)) => (workpiece..=axis).collect(),
            _ => Vec::new(),
        };
        apply(&axes.into_iter().fold(identity(), |sum, k| times(&sum, &self.joint(k, q[k]))), at, true)
    }
}

pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

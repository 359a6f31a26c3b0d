//! The true motion of a C600U's two balls, by unit quaternions; not the library's forward model, and shares no code with it.

/// A rigid motion `p ↦ turn · p · turn* + shift_mm`.
#[derive(Clone, Copy)]
pub struct Motion {
    turn: [f64; 4],
    shift_mm: [f64; 3],
}

impl Motion {
    /// Turning about a coordinate axis (0 x, 1 y, 2 z) through the origin, right-handed.
    pub fn turn(axis: usize, angle_rad: f64) -> Motion {
        let mut turn = [(angle_rad / 2.0).cos(), 0.0, 0.0, 0.0];
        turn[axis + 1] = (angle_rad / 2.0).sin();
        Motion { turn, shift_mm: [0.0; 3] }
    }

    pub fn shift(shift_mm: [f64; 3]) -> Motion {
        Motion { turn: [1.0, 0.0, 0.0, 0.0], shift_mm }
    }

    /// `self` after `inner`: the product `self · inner` read from the bed outward.
    pub fn carrying(self, inner: Motion) -> Motion {
        Motion { turn: product(self.turn, inner.turn), shift_mm: self.of_point(inner.shift_mm) }
    }

    pub fn of_point(self, point_mm: [f64; 3]) -> [f64; 3] {
        let [w, x, y, z] = self.turn;
        let pure = [0.0, point_mm[0], point_mm[1], point_mm[2]];
        let turned = product(product(self.turn, pure), [w, -x, -y, -z]);
        std::array::from_fn(|k| turned[k + 1] + self.shift_mm[k])
    }
}

/// Hamilton product.
fn product(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ]
}

/// Where a rotary axis really is: `Tx·Ty·Tz·Rx·Ry·Rz` about the nominal A∩C intersection.
#[derive(Clone, Copy, Default)]
pub struct AxisLocation {
    pub shift_mm: [f64; 3],
    pub tilt_rad: [f64; 3],
}

impl AxisLocation {
    fn motion(self) -> Motion {
        let tilts = (0..3).map(|k| Motion::turn(k, self.tilt_rad[k]));
        tilts.fold(Motion::shift(self.shift_mm), Motion::carrying)
    }
}

/// The tilting rotary table, A on the bed and C on A; the linear axes carry the spindle and are perfect here.
#[derive(Clone, Copy, Default)]
pub struct Trunnion {
    pub a: AxisLocation,
    pub c: AxisLocation,
}

impl Trunnion {
    /// Place of a ball carried by the C table, `E_A · Rx(a) · E_C · Rz(c) · p`.
    pub fn table_ball_mm(&self, a_deg: f64, c_deg: f64, point_mm: [f64; 3]) -> [f64; 3] {
        let tilted = self.a.motion().carrying(Motion::turn(0, a_deg.to_radians()));
        let turned = self.c.motion().carrying(Motion::turn(2, c_deg.to_radians()));
        tilted.carrying(turned).of_point(point_mm)
    }

    /// Place of a ball beside the C table on the tilting table, `E_A · Rx(a) · p`.
    pub fn tilting_ball_mm(&self, a_deg: f64, point_mm: [f64; 3]) -> [f64; 3] {
        self.a.motion().carrying(Motion::turn(0, a_deg.to_radians())).of_point(point_mm)
    }
}

pub fn distance_mm(a: [f64; 3], b: [f64; 3]) -> f64 {
    let square: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
    square.sqrt()
}

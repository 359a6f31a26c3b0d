//! Ball-to-ball distance of a five-axis machine by unit quaternions; knows nothing of time, tests, noise or files.

/// Number of axes of every machine drawn here.
pub const AXES: usize = 5;
/// A point or direction in the reference frame, mm.
pub type V3 = [f64; 3];
/// Translation in mm and rotation in rad of a small motion.
pub type Motion = [f64; 6];

pub fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn scale(a: V3, k: f64) -> V3 {
    [a[0] * k, a[1] * k, a[2] * k]
}

pub fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn norm(a: V3) -> f64 {
    dot(a, a).sqrt()
}

pub fn unit(a: V3) -> V3 {
    scale(a, 1.0 / norm(a))
}

/// Unit quaternion; turns vectors actively, right-handed.
#[derive(Clone, Copy)]
pub struct Quaternion {
    w: f64,
    v: V3,
}

impl Quaternion {
    pub fn about(direction: V3, angle_rad: f64) -> Self {
        let (s, c) = (angle_rad / 2.0).sin_cos();
        Quaternion { w: c, v: scale(direction, s) }
    }

    pub fn turn(self, x: V3) -> V3 {
        let t = scale(cross(self.v, x), 2.0);
        add(add(x, scale(t, self.w)), cross(self.v, t))
    }

    /// Turns about x, then y, then z written from left to right: `Rx·Ry·Rz`.
    pub fn xyz(angles_rad: V3) -> Self {
        let [a, b, c] = angles_rad;
        Self::about([1.0, 0.0, 0.0], a).times(Self::about([0.0, 1.0, 0.0], b)).times(Self::about([0.0, 0.0, 1.0], c))
    }

    fn times(self, o: Self) -> Self {
        let v = add(add(scale(o.v, self.w), scale(self.v, o.w)), cross(self.v, o.v));
        Quaternion { w: self.w * o.w - dot(self.v, o.v), v }
    }
}

/// One axis: a slide along, or a joint about, a line fixed in the reference frame.
#[derive(Clone, Debug)]
pub struct Joint {
    pub name: String,
    pub rotary: bool,
    pub direction: V3,
    pub origin: V3,
    pub range: (f64, f64),
    /// The controller counts against the right-handed motion.
    pub reversed: bool,
}

/// Axes of both branches, each listed from the bed outward by index into `joints`.
#[derive(Clone, Debug)]
pub struct Machine {
    pub name: String,
    pub code: String,
    pub joints: Vec<Joint>,
    pub work: Vec<usize>,
    pub tool: Vec<usize>,
}

/// What carries a ball: the bed or the part behind an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Link {
    Bed,
    Axis(usize),
}

/// A ball centre, given with all axes at zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    pub link: Link,
    pub at: V3,
}

/// Everything that moves the balls at one instant beside the commanded positions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disturbance {
    /// Added to an axis's own position, mm or deg.
    pub own: [f64; AXES],
    /// Component errors per axis in the carrier's directions about its origin.
    pub motion: [Motion; AXES],
    /// Added to the ball places, mm in the carrying link's directions.
    pub pivot: V3,
    pub ball: V3,
    /// Added to the reading, mm.
    pub length: f64,
}

/// Location errors per axis, mm and rad.
pub type Location = [Motion; AXES];

impl Machine {
    /// Axes between the bed and a link, from the bed outward.
    pub fn branch(&self, link: Link) -> &[usize] {
        let Link::Axis(axis) = link else { return &[] };
        for branch in [&self.work, &self.tool] {
            if let Some(end) = branch.iter().position(|&j| j == axis) {
                return &branch[..=end];
            }
        }
        &[]
    }

    pub fn axis(&self, name: &str) -> usize {
        self.joints.iter().position(|j| j.name == name).unwrap_or(0)
    }

    pub fn on_tool_side(&self, axis: usize) -> bool {
        self.tool.contains(&axis)
    }

    /// Where a ball is: rotary axes act as `E·M·J`, linear ones as `E·J·M`, E turning only the slide's direction.
    pub fn place(&self, ball: Ball, offset: V3, q: &[f64; AXES], location: &Location, d: &Disturbance) -> V3 {
        let mut x = add(ball.at, offset);
        for &j in self.branch(ball.link).iter().rev() {
            x = self.carry(j, x, q[j] + d.own[j], &location[j], &d.motion[j]);
        }
        x
    }

    fn carry(&self, j: usize, x: V3, position: f64, e: &Motion, m: &Motion) -> V3 {
        let joint = &self.joints[j];
        let q = if joint.reversed { -position } else { position };
        let o = joint.origin;
        if joint.rotary {
            let turned = Quaternion::about(joint.direction, q.to_radians()).turn(sub(x, o));
            let moved = small(turned, m);
            let placed = Quaternion::xyz([e[3], e[4], e[5]]).turn(moved);
            add(o, add([e[0], e[1], e[2]], placed))
        } else {
            let moved = small(sub(x, o), m);
            let along = Quaternion::xyz([e[3], e[4], e[5]]).turn(scale(joint.direction, q));
            add(add(o, moved), add(along, [e[0], e[1], e[2]]))
        }
    }

    /// Linear axis positions that put the spindle ball at `relative` mm from the pivot, rotary axes standing at `q`.
    /// Slides sit nearer the bed than joints on every machine drawn here, so they move a ball by plain translation.
    pub fn slides_for(&self, pivot: Ball, ball: Ball, q: &mut [f64; AXES], relative: V3) {
        for (j, joint) in self.joints.iter().enumerate() {
            if !joint.rotary {
                q[j] = 0.0;
            }
        }
        let still = Disturbance::default();
        let exact = [[0.0; 6]; AXES];
        let now = sub(self.place(ball, [0.0; 3], q, &exact, &still), self.place(pivot, [0.0; 3], q, &exact, &still));
        let need = sub(relative, now);
        for (j, joint) in self.joints.iter().enumerate().filter(|(_, joint)| !joint.rotary) {
            let along = dot(need, joint.direction);
            let against = self.on_tool_side(j) == joint.reversed;
            q[j] = if against { -along } else { along };
        }
    }
}

/// Exact rotation by the vector `m[3..]` followed by the translation `m[..3]`.
fn small(x: V3, m: &Motion) -> V3 {
    let angle = norm([m[3], m[4], m[5]]);
    let turned =
        if angle == 0.0 { x } else { Quaternion::about([m[3] / angle, m[4] / angle, m[5] / angle], angle).turn(x) };
    add(turned, [m[0], m[1], m[2]])
}

/// True places of the balls of one test.
#[derive(Clone, Copy)]
pub struct Setup {
    pub pivot: Ball,
    pub pivot_offset: V3,
    pub ball: Ball,
    pub ball_offset: V3,
}

/// Distance between the ball centres, mm.
pub fn distance(machine: &Machine, location: &Location, setup: &Setup, q: &[f64; AXES], d: &Disturbance) -> f64 {
    let p = machine.place(setup.pivot, add(setup.pivot_offset, d.pivot), q, location, d);
    let s = machine.place(setup.ball, add(setup.ball_offset, d.ball), q, location, d);
    norm(sub(p, s)) + d.length
}

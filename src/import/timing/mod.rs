//! Where along its run the machine is at a time: rest, ramp, even pace, ramp, rest, and back. Times only, no positions.

pub(super) mod bend;
pub(super) mod lag;

use bend::Bend;
use lag::Lag;

/// Time constants after which nothing is left of a change of speed.
const TIME_CONSTANTS_TO_REST: f64 = 15.0;
/// Nodes, in time constants, and weights of Gauss and Laguerre's rule: exact for cubics.
const LAGUERRE: [(f64, f64); 2] =
    [(0.585_786_437_626_905, 0.853_553_390_593_273_8), (3.414_213_562_373_095, 0.146_446_609_406_726_2)];
/// Shortest ramp, s: none would divide by nothing.
const SHORTEST_S: f64 = 1e-9;

/// When a capture's two directions ran, in the gauge's time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// Begin of motion in each direction, s: of its command, later by the lag, which delays whatever is steady as a clock does.
    pub start_s: [f64; 2],
    /// Speed over the programmed feed, of each direction.
    pub paces: [f64; 2],
    /// Time in which the control comes to speed, and to rest, s.
    pub ramp_s: f64,
    /// Time constant of the servos' lag, s.
    pub lag_s: f64,
    /// How each direction is uneven on the way.
    pub bends: [Bend; 2],
}

impl Timing {
    /// Mean speed over the programmed feed.
    pub fn pace(&self) -> f64 {
        0.5 * (self.paces[0] + self.paces[1])
    }

    /// Paces at the end of the first direction's run and at the begin of the second's: of one feed and one override.
    pub(super) fn meeting_paces(&self, run_s: f64) -> [f64; 2] {
        let [first, second] = [0, 1].map(|k| {
            let whole_s = run_s / self.paces[k];
            let before = run_s * self.bends[k].before(whole_s);
            [before, before * self.bends[k].ratio]
        });
        [first[1], second[0]]
    }

    /// When a direction comes to rest, s, for a run of `run_s` at the programmed feed.
    pub fn ends_s(&self, direction: usize, run_s: f64) -> f64 {
        self.start_s[direction] + self.moving_s(direction, run_s)
    }

    /// How long a direction moves, s, for a run of `run_s` at the programmed feed.
    pub fn moving_s(&self, direction: usize, run_s: f64) -> f64 {
        run_s / self.paces[direction] + self.ramp_s
    }

    /// The same runs at other paces and with another ramp, each with its middle where it was.
    pub(super) fn about_its_middles(&self, run_s: f64, paces: [f64; 2], ramp_s: f64) -> Timing {
        let mut other = Timing { paces, ramp_s, ..*self };
        for direction in 0..2 {
            let longer_s = other.moving_s(direction, run_s) - self.moving_s(direction, run_s);
            other.start_s[direction] -= 0.5 * longer_s;
        }
        other
    }

    /// Programmed time gone `since_s` after a direction began to move, s: the speed rises evenly over the ramp, is even, and
    /// falls evenly; the axes lag.
    pub fn gone_s(&self, direction: usize, since_s: f64, run_s: f64) -> f64 {
        let even_s = self.evenly_gone_s(direction, since_s, run_s);
        if self.bends[direction] == Bend::NONE {
            return even_s;
        }
        run_s * self.bends[direction].gone(even_s / run_s, run_s / self.paces[direction])
    }

    /// The same of an even run.
    fn evenly_gone_s(&self, direction: usize, since_s: f64, run_s: f64) -> f64 {
        if self.lag_s < Lag::NONE_S {
            return self.commanded_s(direction, since_s, run_s);
        }
        // x = c − τẋ
        self.commanded_s(direction, since_s + self.lag_s, run_s) - self.lag_s * self.speed(direction, since_s, run_s)
    }

    /// Speed of the lagging axes over the programmed feed, `since_s` after a direction began to move.
    pub(super) fn speed(&self, direction: usize, since_s: f64, run_s: f64) -> f64 {
        let (whole, pace, ramp) = (self.moving_s(direction, run_s), self.paces[direction], self.ramp_s.max(SHORTEST_S));
        let since_s = since_s + self.lag_s;
        if since_s > ramp + TIME_CONSTANTS_TO_REST * self.lag_s && since_s < whole - ramp {
            return pace;
        }
        let rising = |from_s: f64| Lag(self.lag_s).of_rising(since_s - from_s);
        pace / ramp * (rising(0.0) - rising(ramp) - rising(whole - ramp) + rising(whole))
    }

    /// Square of that speed as it lags once more, with the same time constant: what lagging axes cut off a circle follows it so
    /// (`ρ + τρ′ = ½(τφ′)²` for a radius less by the share ρ at the angle φ). The mean over past times by Gauss and Laguerre.
    pub(super) fn lagging_square(&self, direction: usize, since_s: f64, run_s: f64) -> f64 {
        let past = |(constants, weight): (f64, f64)| {
            weight * self.speed(direction, since_s - constants * self.lag_s, run_s).powi(2)
        };
        LAGUERRE.map(past).iter().sum()
    }

    /// Programmed time gone as the control commands it, without a lag.
    fn commanded_s(&self, direction: usize, since_s: f64, run_s: f64) -> f64 {
        let whole = self.moving_s(direction, run_s);
        let pace = self.paces[direction];
        let ramp = self.ramp_s.max(SHORTEST_S);
        if since_s <= 0.0 {
            0.0
        } else if since_s >= whole {
            run_s
        } else if since_s < ramp {
            0.5 * pace * since_s * since_s / ramp
        } else if since_s > whole - ramp {
            run_s - 0.5 * pace * (whole - since_s).powi(2) / ramp
        } else {
            pace * (since_s - 0.5 * ramp)
        }
    }

    /// Place along the first direction's run, programmed s, and the sense of the last motion: 0 before any.
    pub fn place_s(&self, time_s: f64, run_s: f64) -> (f64, f64) {
        // a command leads its delayed begin by the lag
        let [first_s, second_s] = self.start_s.map(|start_s| start_s - self.lag_s);
        if time_s > second_s {
            (run_s - self.gone_s(1, time_s - self.start_s[1], run_s), -1.0)
        } else {
            (self.gone_s(0, time_s - self.start_s[0], run_s), if time_s > first_s { 1.0 } else { 0.0 })
        }
    }

    /// Time at which a direction has gone so far, s; the inverse of [`Timing::gone_s`] where the pace is even.
    pub fn time_at(&self, direction: usize, gone_s: f64, run_s: f64) -> f64 {
        let whole = self.moving_s(direction, run_s);
        let pace = self.paces[direction];
        let ramp_way = 0.5 * pace * self.ramp_s;
        let gone_s = run_s * self.bends[direction].even(gone_s / run_s, run_s / pace);
        let since = if gone_s < ramp_way {
            (2.0 * gone_s.max(0.0) * self.ramp_s / pace).sqrt()
        } else if gone_s > run_s - ramp_way {
            whole - (2.0 * (run_s - gone_s).max(0.0) * self.ramp_s / pace).sqrt()
        } else {
            gone_s / pace + 0.5 * self.ramp_s
        };
        self.start_s[direction] + since
    }
}

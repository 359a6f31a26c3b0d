//! What the marks of a program tell of a capture: when its two runs began and ended. They are found in `marks`.

/// Readings so near to a mark are hidden with it, s: ramps and filters round its ends.
const EDGE_S: f64 = 0.03;

/// What the marks tell of a capture's two runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    /// When each direction began to move and came to rest, s: as commanded, later by the lag.
    pub runs_s: [[f64; 2]; 2],
    /// Standard deviation of each of these, s.
    pub run_sigma_s: [[f64; 2]; 2],
    /// By how much longer the first run took than the second, with its standard deviation, s.
    pub longer_s: Option<[f64; 2]>,
    /// The same where one of them was held, or its feed changed, on the way.
    pub stopped_s: Option<f64>,
    /// Speed of the marks over their programmed feed, with its standard deviation.
    pub pace: f64,
    pub pace_sigma: f64,
    /// Time constant of the servos' lag with its standard deviation, s, and how long after a mark's end the lagging axes still move the bar.
    pub lag_s: f64,
    pub lag_sigma_s: f64,
    pub tail_s: f64,
    /// Rest between the two directions' marks, s.
    pub gap_s: f64,
    /// How many marks are in the readings, and when the fourth from the end begins, s.
    pub found: usize,
    pub last_four_s: f64,
    /// Begin and end of each mark, s: readings there are none of a run's.
    pub marks_s: [[f64; 2]; 4],
    /// How much longer the bar got at each mark, mm; NaN where readings of one of its levels are missing.
    pub moves_mm: [f64; 4],
}

impl Seen {
    /// By direction: how much longer the bar got at the marks before and after its run, mm, where both were read.
    pub fn by_direction_mm(&self) -> [Option<[f64; 2]>; 2] {
        let [before, after, before_second, after_second] = self.moves_mm;
        let is_read = |moves: &[f64; 2]| moves.iter().all(|mm| mm.is_finite());
        [[before, after], [before_second, after_second]].map(|moves| Some(moves).filter(is_read))
    }

    /// True for times at which a mark is read.
    pub fn hide(&self, time_s: f64) -> bool {
        self.marks_s.iter().any(|[from, to]| (from - EDGE_S..=to + self.tail_s.max(EDGE_S)).contains(&time_s))
    }
}

//! Short moves along the bar by which a program marks in the readings when its runs begin and end. How long they are is the plan's.

/// The marks of a test: out and back before and after each direction, with rests whose times are known.
///
/// A direction is: out, hold, back, rest, the run, rest, out, hold, back; between the two directions lies the gap. Without the
/// rests a look-ahead would begin a mark while the run still slows down. What a control adds to each rest cancels: it moves
/// what is taken for the begin of a run by as much as it lengthens what is taken for its ramps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marks {
    /// How much longer the bar gets, mm; shorter where negative.
    pub move_mm: f64,
    /// Speed of the move, mm/min.
    pub feed_mm_per_min: f64,
    /// How long the bar stays so, s.
    pub hold_s: f64,
    /// Rest between a mark and the run, s.
    pub rest_s: f64,
    /// Rest between the last mark of one direction and the first of the other, s: it tells the tests of a plan apart.
    pub gap_s: f64,
    /// How much longer the bar got at the marks before and after the run, mm, where a capture shows it.
    pub seen_mm: Option<[f64; 2]>,
}

impl Marks {
    /// Programmed time of a move out or back, s.
    pub fn move_s(&self) -> f64 {
        self.move_mm.abs() / self.feed_mm_per_min * 60.0
    }
}

/// Times from the first to the last of some readings in even steps, s, where at least one reading lies within `before_s` and `after_s` of them:
/// however sparse readings are, a search costs no more than they do. `next_s` is the first reading at or after a time.
pub fn times_beside_readings(
    [first_s, last_s]: [f64; 2],
    step_s: f64,
    [before_s, after_s]: [f64; 2],
    next_s: impl Fn(f64) -> Option<f64>,
) -> impl Iterator<Item = f64> {
    let steps = move |time_s: f64| ((time_s - first_s) / step_s).ceil();
    let beside = move |step: f64| {
        let time_s = first_s + step_s * step;
        let next_s = next_s(time_s - before_s).filter(|_| time_s <= last_s)?;
        // readings begin behind this step: the first one that they reach
        Some(if next_s > time_s + after_s { steps(next_s - after_s).max(step + 1.0) } else { step })
    };
    let first = beside(0.0);
    std::iter::successors(first, move |step| beside(step + 1.0)).map(move |step| first_s + step_s * step)
}

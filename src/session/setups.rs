//! Which tests share a pivot, a spindle ball or a bar, and so an unknown placement error; the errors themselves are fitted elsewhere.

use super::ball::{Ball, Zero};
use super::test::{Session, Test};
use crate::readings::Kind;

/// A physical setup that several tests share.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// Name for people: `pivot on C at (0, 100, 0)`.
    pub label: String,
    /// Index of the first test that uses it.
    pub first_test: usize,
    /// Prior standard deviation per coordinate (balls) or of the length (bars), mm.
    pub spread_mm: f64,
    /// How a bar's zero was set; balls have none to set and say `Calibrated`.
    pub zero: Zero,
    /// Prior standard deviation of a turn of its axes about each direction of R, rad; `None` for what has none or stands exactly.
    pub turn_rad: Option<f64>,
}

/// How little is assumed of a place that no one states the spread of, mm and rad: it is a start from the readings, and these are without
/// influence wherever readings speak.
pub(crate) const UNKNOWN_MM: f64 = 100.0;
pub(crate) const UNKNOWN_RAD: f64 = 0.1;

/// Places of which a session knows less than this are looked for by the readings, mm.
pub(super) const LOOKED_FOR_MM: f64 = 0.5 * UNKNOWN_MM;

impl Setup {
    /// Whether its place is looked for by the readings, so that its spread is that of the search.
    pub fn is_looked_for(&self) -> bool {
        self.spread_mm > LOOKED_FOR_MM
    }
}

/// All setups of a session and, for each test, which ones it uses.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Setups {
    pub pivots: Vec<Setup>,
    pub spindle_balls: Vec<Setup>,
    pub bars: Vec<Setup>,
    /// Index into `pivots`, by test.
    pub pivot_of: Vec<usize>,
    /// Index into `pivots` of the second end of a known distance of two sockets, by test; `None` for all others.
    pub second_pivot_of: Vec<Option<usize>>,
    /// Index into `spindle_balls`, by test; none of them for a known distance of two sockets.
    pub spindle_ball_of: Vec<usize>,
    /// Index into `bars`, by test; `None` for an absolute length gauge.
    pub bar_of: Vec<Option<usize>>,
}

/// Places closer than this are one place, mm.
const SAME_PLACE_MM: f64 = 1e-6;

impl Setups {
    /// Groups the tests of a session by their setups.
    pub fn of(session: &Session) -> Setups {
        let mut setups = Setups::default();
        for (index, test) in session.tests.iter().enumerate() {
            let pivot = group(
                &mut setups.pivots,
                index,
                |first| {
                    let first = &session.tests[first];
                    share_ball((first, &first.pivot), (test, &test.pivot))
                },
                || {
                    let spread_mm = test.pivot.spread_mm.unwrap_or(session.spread.pivot_mm);
                    let turn_rad = test.reading.part().and_then(|part| part.instrument_turn_rad);
                    (ball_label(role(test, "pivot"), &test.pivot), spread_mm, Zero::Calibrated, turn_rad)
                },
            );
            setups.pivot_of.push(pivot);
            if test.reading.is_gap() {
                let is_second = |first: &Test| share_ball((first, &first.pivot), (test, &test.spindle_ball));
                let second = setups.pivots.iter().position(|setup| is_second(&session.tests[setup.first_test]));
                setups.second_pivot_of.push(second);
                setups.spindle_ball_of.push(usize::MAX);
                setups.bar_of.push(None);
                continue;
            }
            setups.second_pivot_of.push(None);
            let ball = &test.spindle_ball;
            let spindle = group(
                &mut setups.spindle_balls,
                index,
                |first| {
                    let first = &session.tests[first];
                    share_ball((first, &first.spindle_ball), (test, ball))
                },
                || {
                    let spread_mm = ball.spread_mm.unwrap_or(session.spread.spindle_ball_mm);
                    let turn_rad = test.reading.part().and_then(|part| part.target_turn_rad);
                    (ball_label(role(test, "spindle ball"), ball), spread_mm, Zero::Calibrated, turn_rad)
                },
            );
            setups.spindle_ball_of.push(spindle);
            let bar = test.bar_length_mm.map(|length| {
                group(
                    &mut setups.bars,
                    index,
                    |first| same_bar(&session.tests[first], test),
                    || (bar_label(length, test), test.zero.spread_mm(session.spread.bar_length_mm), test.zero, None),
                )
            });
            setups.bar_of.push(bar);
        }
        setups
    }
}

/// Index of the setup for which `same` holds, or of a new one.
fn group(
    list: &mut Vec<Setup>,
    test: usize,
    same: impl Fn(usize) -> bool,
    describe: impl FnOnce() -> (String, f64, Zero, Option<f64>),
) -> usize {
    if let Some(index) = list.iter().position(|setup| same(setup.first_test)) {
        return index;
    }
    let (label, spread_mm, zero, turn_rad) = describe();
    let alike =
        list.iter().filter(|setup| setup.label == label || setup.label.starts_with(&format!("{label}, no. "))).count();
    let label = if alike == 0 { label } else { format!("{label}, no. {}", alike + 1) };
    list.push(Setup { label, first_test: test, spread_mm, zero, turn_rad });
    list.len() - 1
}

/// Whether a ball of one test and a ball of another are one mounting of one ball; indexing the spindle mounts nothing anew. Balls with one
/// place are not one where different instruments see them: a reflector is no ball in a socket and a gauge no pivot, unless a tag says so.
fn share_ball((one_test, one): (&Test, &Ball), (other_test, other): (&Test, &Ball)) -> bool {
    // points and poses are readings of one tracker
    let seen_by = |test: &Test| match test.reading.part().map(|part| part.kind) {
        Some(Kind::Pose) => Some(Kind::Point),
        kind => kind,
    };
    let is_one_place = one.link == other.link && one.setup == other.setup && (one.at - other.at).norm() < SAME_PLACE_MM;
    is_one_place && (other.setup.is_some() || seen_by(one_test) == seen_by(other_test))
}

/// One bar with one zero: a zero set by hand is another than the calibrated one.
fn same_bar(one: &Test, other: &Test) -> bool {
    match (one.bar_length_mm, other.bar_length_mm) {
        (Some(a), Some(b)) => {
            (a - b).abs() < SAME_PLACE_MM && one.bar_setup == other.bar_setup && one.zero == other.zero
        }
        _ => false,
    }
}

/// What stands at the place of a test's ball.
fn role(test: &Test, of_a_bar: &'static str) -> &'static str {
    match (test.reading.part().map(|part| part.kind), of_a_bar) {
        (None, _) => of_a_bar,
        (Some(Kind::SamePoint), "pivot") => "socket",
        (Some(_), "pivot") => "instrument",
        (Some(Kind::SamePoint), _) => "ball",
        (Some(_), _) => "target",
    }
}

fn ball_label(role: &str, ball: &Ball) -> String {
    if !["pivot", "spindle ball"].contains(&role) {
        // its place may stem from a search and have many digits
        let tag = ball.setup.as_ref().map(|tag| format!(" ({tag})")).unwrap_or_default();
        return format!("{role} on {}{tag}", ball.link);
    }
    let tag = ball.setup.as_ref().map(|tag| format!(" ({tag})")).unwrap_or_default();
    // a tenth of a micrometre: places that a fit saved have all digits
    let [x, y, z] = [ball.at.x, ball.at.y, ball.at.z].map(|mm| (mm * 1e4).round() / 1e4 + 0.0);
    format!("{role} on {} at ({x}, {y}, {z}){tag}", ball.link)
}

fn bar_label(length_mm: f64, test: &Test) -> String {
    let tag = test.bar_setup.as_ref().map(|tag| format!(" ({tag})")).unwrap_or_default();
    let zero = if test.zero == Zero::Free { ", free zero" } else { "" };
    format!("bar {length_mm}{tag}{zero}")
}

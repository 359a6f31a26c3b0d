//! The test that shows an effect where a session does not.

use crate::machine::{AxisKind, Place};
use crate::session::{Session, Test};

/// Tests that show causes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShowingTest {
    /// Poses of an arm from either side.
    EitherSide,
    /// Poses of an arm over a joint's whole range.
    WholeRange,
    /// Sweeps of an arm's joint at two speeds.
    TwoSpeeds,
    /// A rotary axis with slides that follow tangentially.
    Tangential,
    /// A rotary axis with slides that follow radially and axially.
    Radial,
    /// With and without payload.
    Payload,
    /// Planar circles.
    Circles,
    RepeatAtEnd,
    BallTurned,
    NoRunUp,
    TwoFeeds,
    BothWays,
    /// Said by the effect itself.
    Said(&'static str),
}

/// The test that shows an effect: at a joint of an arm, at a rotary axis of a machine, anywhere else.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShownBy {
    pub arm: Option<ShowingTest>,
    pub rotary: Option<ShowingTest>,
    pub other: ShowingTest,
}

impl ShownBy {
    /// The test at a place, in words; where a session has it already, what it lacks.
    pub fn words(&self, session: &Session, place: Place) -> String {
        let machine = &session.machine;
        // an arm has no linear axes that could follow
        let is_arm = machine.axes.iter().all(|axis| axis.kind == AxisKind::Rotary);
        let axis = place.axis().map(|axis| &machine.axes[axis]);
        let at_arm = self.arm.filter(|_| is_arm && axis.is_some());
        let at_rotary = self.rotary.filter(|_| axis.is_some_and(|axis| axis.kind == AxisKind::Rotary));
        let test = at_arm.or(at_rotary).unwrap_or(self.other);
        match (test, place.axis()) {
            (ShowingTest::RepeatAtEnd, _) if ends_as_it_began(session) => {
                "the first test again between the others, nothing remounted".into()
            }
            (ShowingTest::Circles, Some(index)) if has_circles_at_two_feeds(session, index) => format!(
                "planar circles with {} about a pivot elsewhere: at another height, and on another side of the table",
                machine.axes[index].name
            ),
            _ => test.words(axis.map(|axis| axis.name.as_str())),
        }
    }
}

/// Whether the last test repeats the first.
fn ends_as_it_began(session: &Session) -> bool {
    let began = |test: &&Test| test.started_at_s;
    let first = session.tests.iter().min_by(|a, b| began(a).total_cmp(&began(b)));
    let last = session.tests.iter().max_by(|a, b| began(a).total_cmp(&began(b)));
    first.zip(last).is_some_and(|(first, last)| first.name != last.name && last.is_repeat_of(first))
}

/// Whether a slide moves in circles both ways and at two feeds.
fn has_circles_at_two_feeds(session: &Session, slide: usize) -> bool {
    let is_linear = |axis: &usize| session.machine.axes[*axis].kind == AxisKind::Linear;
    let is_circle = |test: &&Test| {
        let moving = test.recording.as_ref().map_or(&[][..], |recording| &recording.axes);
        moving.len() == 2 && moving.iter().all(is_linear) && moving.contains(&slide)
    };
    let feeds: Vec<Option<f64>> = session.tests.iter().filter(is_circle).map(|test| test.feed_mm_per_min).collect();
    feeds.len() > 2 && feeds.iter().any(|feed| *feed != feeds[0])
}

impl ShowingTest {
    /// In words; tests of an axis need one.
    fn words(self, axis: Option<&str>) -> String {
        match (self, axis) {
            (ShowingTest::EitherSide, Some(name)) => format!("the same poses with {name} arriving from either side"),
            (ShowingTest::WholeRange, Some(name)) => {
                format!("poses over the whole range of {name}, the other joints standing still")
            }
            (ShowingTest::TwoSpeeds, Some(name)) => {
                format!("sweeps of {name} in both directions and at two speeds, read in time")
            }
            (ShowingTest::Tangential, Some(name)) => {
                format!("{name} swept both ways with the linear axes following tangentially")
            }
            (ShowingTest::Radial, Some(name)) => {
                format!(
                    "{name} swept both ways with the linear axes following radially and axially, ball high above the table"
                )
            }
            (ShowingTest::Payload, Some(name)) => {
                format!("{name} over its whole range with and without payload, nothing remounted")
            }
            (ShowingTest::Circles, Some(name)) => {
                format!("planar circles with {name} in both directions and at two feeds")
            }
            (ShowingTest::RepeatAtEnd, _) => "the first test again at the end, nothing remounted".into(),
            (ShowingTest::BallTurned, _) => "the first test again with the ball turned in its cup".into(),
            (ShowingTest::NoRunUp, _) => {
                "a sweep in which the bar turns in that cup, read from the start without run-up".into()
            }
            (ShowingTest::TwoFeeds, _) => "a sweep with an off-centre ball at two feeds in both directions".into(),
            (ShowingTest::Said(words), _) => words.into(),
            _ => "the first test again in both directions".into(),
        }
    }
}

//! The ball that an effect concerns, named by its link and its place there. What becomes of it is the effect's own.

use nalgebra::Vector3;

use super::contract::{DefaultValue, Parameter, ParameterUnit, list, word};
use crate::machine::{Effect, ParameterValue};
use crate::session::Ball;

/// Places closer than this are one place, mm: an effect's file has them to some digits. Setups of a session are told apart by less.
pub(super) const SAME_PLACE_MM: f64 = 1e-3;

/// The parameter that names the link, and the one that names the place.
pub(super) const fn parameters(link: &'static str, at: &'static str) -> [Parameter; 2] {
    let place = Parameter {
        name: "at",
        unit: ParameterUnit::Plain,
        count: 3,
        default: DefaultValue::Absent,
        bounds: (-1e6, 1e6),
        meaning: at,
    };
    [Parameter::word("link", &[], DefaultValue::Absent, link), place]
}

/// What an effect says of the ball that it concerns.
pub struct NamedBall<'e> {
    /// Place on its link, mm.
    pub at: Option<Vector3<f64>>,
    pub link: Option<&'e str>,
}

impl<'e> NamedBall<'e> {
    /// The ball that an effect names; neither link nor place where it names none.
    pub fn of(effect: &'e Effect) -> NamedBall<'e> {
        let at = match list(effect, "at") {
            [x, y, z] => Some(Vector3::new(*x, *y, *z)),
            _ => None,
        };
        NamedBall { at, link: word(effect, "link") }
    }

    /// True for a ball of that link and place; for every ball where none is named.
    pub fn is(&self, ball: &Ball) -> bool {
        self.at.is_none_or(|at| (ball.at - at).norm() < SAME_PLACE_MM) && self.link.is_none_or(|link| ball.link == link)
    }
}

/// The effect with the name of a ball.
pub(super) fn naming(effect: Effect, ball: &Ball) -> Effect {
    effect.with("link", ParameterValue::Word(ball.link.clone())).with("at", place(ball))
}

/// Names the place to which a named ball has come, mm on its link.
pub fn name_place(effect: &mut Effect, ball: &Ball) {
    effect.set("at", place(ball));
}

fn place(ball: &Ball) -> ParameterValue {
    ParameterValue::List(ball.at.iter().copied().collect())
}

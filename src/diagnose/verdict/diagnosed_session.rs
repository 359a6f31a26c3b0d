//! A session as diagnosed: effects in its machine, errors and places of balls and bars fitted beside them. It searches nothing.

use super::diagnosis::{DiagnoseError, Diagnosis};
use crate::chain::Chain;
use crate::effects::{Context, EffectError, NamedBall, Profile, kind, name_place};
use crate::identify::{self, Problem, fitted_session};
use crate::machine::{Effect, Place};
use crate::session::{Ball, Session, Setups, Test};

/// The session whose simulation predicts its recordings.
///
/// Effects were found with first-order columns. Here they act through the exact model at the sizes found, and location
/// errors, ball places and bars are fitted once more beside them, so that what is second order in an effect does not
/// stay in the prediction.
pub fn as_found(session: &Session, diagnosis: &Diagnosis) -> Result<Session, DiagnoseError> {
    let mut explained = session.clone();
    explained.machine.effects.extend(diagnosis.effects());
    let chain = Chain::of(&explained.machine);
    let setups = Setups::of(&explained);
    let problem = Problem::new(&explained, &chain, &setups, diagnosis.unknowns.clone())?;
    let fit = identify::fit(&problem)?;
    let mut found = fitted_session(&explained, &fit);
    for effect in &mut found.machine.effects {
        follow_ball(effect, session, &found.tests);
    }
    found.machine.effects = sized_anew(&explained, &found)?;
    Ok(found)
}

/// The effects of a fitted session, each as in [`same_course`].
fn sized_anew(explained: &Session, found: &Session) -> Result<Vec<Effect>, DiagnoseError> {
    let (stated_chain, fitted_chain) = (Chain::of(&explained.machine), Chain::of(&found.machine));
    let (stated, fitted) = (Context::of(explained, &stated_chain)?, Context::of(found, &fitted_chain)?);
    let effects = explained.machine.effects.iter().zip(&found.machine.effects);
    Ok(effects
        .map(|(before, after)| same_course(before, after, (&stated, &fitted)))
        .collect::<Result<_, EffectError>>()?)
}

/// An effect with the size by which it does, with balls and sensors where they were fitted, what it did where they were stated.
fn same_course(before: &Effect, after: &Effect, (stated, fitted): (&Context, &Context)) -> Result<Effect, EffectError> {
    let Some(kind) = kind(&after.kind) else { return Ok(after.clone()) };
    let (one, other) = (kind.shape(stated, before)?, kind.shape(fitted, after)?);
    let ([one], [other]) = (one.as_slice(), other.as_slice()) else { return Ok(after.clone()) };
    let product =
        |a: &Profile, b: &Profile| a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum::<f64>();
    let share = product(one, other) / product(other, other);
    let mut effect = after.clone();
    if share.is_finite() && share > 0.0 {
        effect.sizes.iter_mut().for_each(|size| size.value *= share);
    }
    Ok(effect)
}

/// A slip names the ball concerned by its place: that must be the fitted place when the ball has one.
fn follow_ball(effect: &mut Effect, stated: &Session, fitted: &[Test]) {
    let ball: fn(&Test) -> &Ball = match effect.place {
        Place::Pivot => |test| &test.pivot,
        Place::SpindleBall => |test| &test.spindle_ball,
        _ => return,
    };
    let named = NamedBall::of(effect);
    if named.at.is_none() {
        return;
    }
    if let Some(index) = stated.tests.iter().position(|test| named.is(ball(test))) {
        name_place(effect, ball(&fitted[index]));
    }
}

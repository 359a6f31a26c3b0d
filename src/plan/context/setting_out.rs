//! The context of a plan from what was asked for, and an evaluation over it. Refuses what leaves nothing to plan.

use super::error::PlanError;
use super::evaluation::Evaluation;
use super::finer::Finer;
use super::method::Method;
use super::observing::observability;
use super::plan_context::PlanContext;
use super::settings::Settings;
use crate::bodies::{Bodies, Kit};
use crate::chain::{Chain, Geometry};
use crate::collision::World;
use crate::machine::Machine;
use crate::plan::information::unknowns::Unknowns;
use crate::plan::places::ball_places::Offer;
use crate::plan::places::candidates::candidates_at;
use crate::plan::reach::approach::Parking;
use crate::plan::reach::out_of_reach;

/// Works with what a plan is made from.
pub(crate) fn with_evaluation<T>(
    machine: &Machine,
    bodies: &Bodies,
    kit: &Kit,
    settings: &Settings,
    work: impl for<'a> FnOnce(Evaluation<'a>) -> Result<T, PlanError>,
) -> Result<T, PlanError> {
    let chain = Chain::of(machine);
    let whole_world = World::new(&chain, bodies).map_err(PlanError::Bodies)?;
    whole_world.refuse_overlaps(machine).map_err(PlanError::Bodies)?;
    whole_world.refuse_always_near(machine, settings.margin_mm).map_err(PlanError::Bodies)?;
    let world = whole_world.without_settled_pairs(machine, settings.margin_mm);
    let offer = match settings.method {
        None => Offer::Spread,
        Some(Method::Chapter5) => Offer::Common,
        Some(_) => Offer::Level,
    };
    let all = candidates_at(machine, bodies, kit, &settings.avoid, &settings.coupled, offer);
    out_of_reach::refuse(machine, bodies, kit, &all)?;
    let finer = Finer::new();
    let unknowns = match settings.coupled.circles {
        true => Unknowns::with_squareness(machine, settings.uncertainty),
        false => Unknowns::of(machine, settings.uncertainty),
    };
    let context = PlanContext {
        machine,
        bodies,
        kit,
        settings,
        geometry: Geometry::nominal(&chain),
        world: &world,
        whole_world: &whole_world,
        unknowns,
        all: &all,
        finer: &finer,
        parking: Parking::of(machine, &settings.avoid),
    };
    let mut evaluation = Evaluation::of(&context);
    evaluation.observability = observability(&evaluation);
    work(evaluation)
}

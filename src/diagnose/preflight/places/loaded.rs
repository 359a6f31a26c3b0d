//! What loads on the joints of an arm leave of a residual: the rival of an instrument that was moved. It finds no cause.
//!
//! Where a series of poses turns an arm over, its weight pulls the other way from some row on, as if the instrument stood elsewhere
//! from there.

use crate::chain::Chain;
use crate::diagnose::model::linear_model::LinearModel;
use crate::diagnose::model::regression::Regression;
use crate::diagnose::noise::pose_noise::white_by_class;
use crate::diagnose::selection::screening::candidates::families;
use crate::diagnose::selection::screening::screen::screen;
use crate::diagnose::selection::screening::screening_grid::ScreeningGrid;
use crate::effects::{CandidateFamily, Context, Driver, kind};
use crate::identify::{Fit, Problem};
use crate::session::{Session, Setups};

/// Share of the residual's squares that is left beside the one load that explains most; `None` where no load shows.
pub(super) fn left_by_a_load(session: &Session, fit: &Fit) -> Option<f64> {
    let (chain, setups) = (Chain::of(&session.machine), Setups::of(session));
    let problem = Problem::new(session, &chain, &setups, fit.unknowns.clone()).ok()?;
    let context = Context::of(session, &chain).ok()?;
    let mut model = LinearModel::new(&context, &problem, &fit.values(), fit.kept_rows());
    let mut loads = families(&model);
    loads.retain(is_load);
    model.prepare(loads.iter().flat_map(|family| &family.outlets));
    let grid = ScreeningGrid::of(&model, &loads);
    let noise = white_by_class(&model, &model.residual_mm, 1.0);
    let regression = Regression::new(&model, &noise, &[], &model.kept);
    let misfit = regression.misfit;
    let candidates = screen(&[regression.clone(), regression], &loads, &grid);
    let explained = candidates.iter().map(|candidate| candidate.judgement.chi2).reduce(f64::max)?;
    Some(1.0 - explained / misfit.max(f64::MIN_POSITIVE))
}

fn is_load(family: &CandidateFamily) -> bool {
    kind(family.kind).is_some_and(|kind| matches!(kind.driver, Driver::Load | Driver::Gravity))
}

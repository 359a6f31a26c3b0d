//! A session on all rows and on averaged ones, ready for a search. It searches nothing.

use super::screening::candidates::families;
use super::screening::screening_grid::{ScreeningGrid, terms_by_shape};
use super::selected::Resolutions;
use crate::diagnose::model::decimate::thin;
use crate::diagnose::model::linear_model::LinearModel;
use crate::effects::{CandidateFamily, Context};
use crate::session::MotionError;

/// Does something with a session at both resolutions and with all that may be in it.
pub(crate) fn at_two_resolutions<R>(
    mut fine: LinearModel,
    act: impl FnOnce(&Resolutions, &[CandidateFamily]) -> R,
) -> Result<R, MotionError> {
    let (problem, session) = (fine.problem, fine.context.session());
    let families = families(&fine);
    let outlets = || families.iter().flat_map(|family| &family.outlets);
    fine.prepare(outlets());
    fine.set_together(terms_by_shape(&session.machine, &families));
    let (thinned, groups) = thin(session, &fine.kept);
    let context = Context::of(&thinned, problem.chain)?;
    let mut coarse = fine.thinned(&context, &groups);
    coarse.prepare(outlets());
    let cells = ScreeningGrid::of(&coarse, &families);
    Ok(act(&Resolutions { fine: &fine, coarse: &coarse, cells: &cells }, &families))
}

//! Shapes of the slow candidates worked out once: every stage and every fold of a search looks at the same ones. No data.

use std::sync::Arc;

use rayon::prelude::*;

use super::candidates::family_terms;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::effects::CandidateFamily;
use crate::effects::{Profile, kind};
use crate::machine::Effect;

/// A candidate shape with its functions at every row.
pub struct Cell<'f> {
    pub effect: &'f Effect,
    pub terms: Vec<Term>,
    pub profiles: Arc<Vec<Profile>>,
}

/// Cells of every family that is judged on averaged rows; fast families have none.
pub struct ScreeningGrid<'f> {
    by_family: Vec<Vec<Cell<'f>>>,
}

impl<'f> ScreeningGrid<'f> {
    /// Shapes over the rows of `coarse`. Families that differ in outlets alone share them.
    pub fn of(coarse: &LinearModel, families: &'f [CandidateFamily]) -> ScreeningGrid<'f> {
        let mut distinct: Vec<&Effect> = Vec::new();
        let slow = |family: &&CandidateFamily| !family.fast;
        for effect in families.iter().filter(slow).flat_map(|family| &family.grid) {
            // families with the same shapes follow each other closely
            if !distinct.iter().rev().any(|other| *other == effect) {
                distinct.push(effect);
            }
        }
        let shapes: Vec<Option<Arc<Vec<Profile>>>> = distinct
            .par_iter()
            .map(|effect| kind(&effect.kind)?.shape(coarse.context, effect).ok().map(Arc::new))
            .collect();
        let machine = coarse.context.machine();
        let cells = |family: &'f CandidateFamily| -> Vec<Cell<'f>> {
            let grid = family.grid.iter().filter(|_| !family.fast);
            grid.filter_map(|effect| {
                let index = distinct.iter().position(|other| *other == effect)?;
                let profiles = shapes[index].clone()?;
                Some(Cell { effect, terms: family_terms(machine, family, effect, coarse.tests()), profiles })
            })
            .collect()
        };
        ScreeningGrid { by_family: families.iter().map(cells).collect() }
    }

    /// Cells of a family.
    pub fn of_family(&self, family: usize) -> &[Cell<'f>] {
        &self.by_family[family]
    }
}

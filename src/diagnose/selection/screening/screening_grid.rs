//! Shapes of the slow candidates worked out once: every stage and every fold of a search looks at the same ones. No data.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::candidates::family_terms;
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::model::shapes::name;
use crate::effects::CandidateFamily;
use crate::effects::Profile;
use crate::machine::{Effect, Machine};

/// A candidate shape with its functions at every row.
pub struct Cell<'f> {
    pub effect: &'f Effect,
    /// Name of its shape.
    pub name: Arc<str>,
    pub terms: Vec<Term>,
    pub profiles: Arc<Vec<Profile>>,
}

/// By the name of a shape, the terms of all families that have it: most families differ in outlets alone, and share what is
/// worked out for their columns.
pub fn terms_by_shape(machine: &Machine, families: &[CandidateFamily]) -> HashMap<String, Vec<Term>> {
    let mut by_shape: HashMap<String, Vec<Term>> = HashMap::new();
    // amplitudes of single tests are many
    for family in families.iter().filter(|family| family.by_test.is_empty()) {
        for effect in &family.grid {
            let all = by_shape.entry(name(effect)).or_default();
            for term in family_terms(machine, family, effect) {
                if !all.contains(&term) {
                    all.push(term);
                }
            }
        }
    }
    by_shape
}

/// Cells of every family that is judged on averaged rows; fast families have none.
pub struct ScreeningGrid<'f> {
    by_family: Vec<Vec<Cell<'f>>>,
}

impl<'f> ScreeningGrid<'f> {
    /// Shapes over the rows of `coarse`. Families that differ in outlets alone share them.
    pub fn of(coarse: &LinearModel, families: &'f [CandidateFamily]) -> ScreeningGrid<'f> {
        let mut distinct: Vec<(&Effect, Arc<str>)> = Vec::new();
        let mut places: HashMap<Arc<str>, usize> = HashMap::new();
        let slow = |family: &&CandidateFamily| !family.fast;
        for effect in families.iter().filter(slow).flat_map(|family| &family.grid) {
            let name: Arc<str> = name(effect).into();
            if !places.contains_key(&name) {
                places.insert(name.clone(), distinct.len());
                distinct.push((effect, name));
            }
        }
        let shapes: Vec<Option<Arc<Vec<Profile>>>> =
            distinct.par_iter().map(|(effect, _)| coarse.profiles(effect).ok()).collect();
        let machine = coarse.context.machine();
        let cells = |family: &'f CandidateFamily| -> Vec<Cell<'f>> {
            let grid = family.grid.iter().filter(|_| !family.fast);
            grid.filter_map(|effect| {
                let index = *places.get(name(effect).as_str())?;
                let (profiles, name) = (shapes[index].clone()?, distinct[index].1.clone());
                Some(Cell { effect, name, terms: family_terms(machine, family, effect), profiles })
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

//! Short tests with what is mounted that would show what a session cannot: counted before they are run. It looks at no residual.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::detection_limits::{AXIS_SENSE, Unseen, unseen_of};
use crate::diagnose::findings::proposals::{Layout, Longer, Proposal, proposals};
use crate::diagnose::model::linear_model::{LinearModel, Term};
use crate::diagnose::model::products::Products;
use crate::diagnose::model::shapes::name;
use crate::diagnose::model::whitened::WhitenedData;
use crate::diagnose::selection::screening::candidates::families_of_design;
use crate::effects::CandidateFamily;
use crate::machine::Effect;

/// A test that would show some of the unseen causes.
#[derive(Debug, Clone, PartialEq)]
pub struct UncoveringTest {
    pub says: String,
    /// Time on the machine, minutes.
    pub minutes: f64,
    /// Causes that it shows beside the tests named before it, by their place in the list of unseen causes.
    pub uncovers: Vec<usize>,
}

/// Tests named at most: a short list is run, a long one is not.
const MOST_TESTS: usize = 3;

/// Tests that show most of what is unseen, the one that shows most first, each counted with those before it.
pub fn uncovering_tests(layout: &Layout, unseen: &[Unseen]) -> Vec<UncoveringTest> {
    let proposals = proposals(layout.session, &[]);
    layout.with(&proposals, |longer| Some(greedy(longer, &proposals, unseen))).unwrap_or_default()
}

fn greedy(longer: &mut Longer, proposals: &[Proposal], unseen: &[Unseen]) -> Vec<UncoveringTest> {
    let families = families_of_design(&longer.model);
    longer.model.prepare(families.iter().flat_map(|family| &family.outlets));
    let design = Design::of(longer);
    let mut run: Vec<usize> = Vec::new();
    let mut hidden: Vec<usize> = (0..unseen.len()).collect();
    let mut named = Vec::new();
    while named.len() < MOST_TESTS {
        let open: Vec<usize> = (0..proposals.len()).filter(|index| !run.contains(index)).collect();
        let shown_by = |&index: &usize| {
            let with: Vec<usize> = run.iter().copied().chain([index]).collect();
            (index, shown(&design, &families, &with, unseen, &hidden))
        };
        let counted: Vec<(usize, Vec<usize>)> = open.par_iter().map(shown_by).collect();
        let minutes = |index: usize| proposals[index].minutes();
        let best =
            counted.into_iter().max_by(|a, b| a.1.len().cmp(&b.1.len()).then(minutes(b.0).total_cmp(&minutes(a.0))));
        let Some((index, uncovers)) = best.filter(|(_, uncovers)| !uncovers.is_empty()) else { break };
        hidden.retain(|cause| !uncovers.contains(cause));
        run.push(index);
        named.push(UncoveringTest { says: proposals[index].says.clone(), minutes: minutes(index), uncovers });
    }
    named
}

/// Which of the hidden causes show when these proposals are run.
fn shown(
    design: &Design,
    families: &[CandidateFamily],
    run: &[usize],
    unseen: &[Unseen],
    hidden: &[usize],
) -> Vec<usize> {
    let covariance = design.covariance(run);
    let still = unseen_of(design.model, families, &|effect, terms| design.information(run, &covariance, effect, terms));
    let is_hidden = |cause: &Unseen| {
        still.iter().filter(|other| other.matters).map(|other| &other.unseen.cause).any(|other| {
            other.effect == cause.cause.effect
                && other.place == cause.cause.place
                && other.components.iter().any(|component| cause.cause.components.contains(component))
        })
    };
    // no length tells the sense of an axis as looking does
    let by_looking = |cause: &Unseen| cause.cause.effect == AXIS_SENSE;
    hidden.iter().copied().filter(|&k| !by_looking(&unseen[k]) && !is_hidden(&unseen[k])).collect()
}

/// A session with proposed tests: what they say of columns is summed once for the tests that were run and for each proposal.
struct Design<'l, 'a> {
    model: &'l LinearModel<'a>,
    whitened: WhitenedData<'l, 'a>,
    groups: Vec<Range<usize>>,
    /// By group: products of the unknowns with each other.
    normals: Vec<DMatrix<f64>>,
    /// By the name of a shape and its terms: their products by group.
    known: Mutex<HashMap<String, Vec<KnownTerms>>>,
}

/// Terms with the products of their columns by group.
type KnownTerms = (Vec<Term>, Arc<Vec<Products>>);

impl<'l, 'a> Design<'l, 'a> {
    fn of(longer: &'l Longer<'a>) -> Design<'l, 'a> {
        let whitened = WhitenedData::new(&longer.model, &longer.noise, &longer.model.kept);
        let groups = longer.groups();
        let normals = groups.iter().map(|tests| whitened.normal_in(tests.clone())).collect();
        Design { model: &longer.model, whitened, groups, normals, known: Mutex::default() }
    }

    /// The groups that take part when these proposals are run.
    fn taking_part<'r>(run: &'r [usize]) -> impl Iterator<Item = usize> + 'r {
        std::iter::once(0).chain(run.iter().map(|proposal| proposal + 1))
    }

    /// Covariance of the unknowns, in units of their priors, when these proposals are run.
    fn covariance(&self, run: &[usize]) -> Option<DMatrix<f64>> {
        let count = self.model.problem.unknowns.len();
        let mut normal = DMatrix::identity(count, count);
        Self::taking_part(run).for_each(|group| normal += &self.normals[group]);
        normal.cholesky().map(|factor| factor.inverse())
    }

    /// What the readings would say of the terms of an effect beside the unknowns, one by one.
    fn information(
        &self,
        run: &[usize],
        covariance: &Option<DMatrix<f64>>,
        effect: &Effect,
        terms: &[Term],
    ) -> Option<Vec<f64>> {
        let products = self.products(effect, terms)?;
        let covariance = covariance.as_ref()?;
        let of_term = |k: usize| {
            let groups = || Self::taking_part(run).map(|group| &products[group]);
            let raw: f64 = groups().map(|products| products.square(k)).sum();
            let mut cross = DVector::zeros(covariance.nrows());
            groups().for_each(|products| cross += products.cross.column(k));
            let left = raw - cross.dot(&(covariance * &cross));
            // what rounding leaves of a column that the unknowns explain wholly is nothing
            if left < ROUNDING * raw { 0.0 } else { left }
        };
        Some((0..terms.len()).map(of_term).collect())
    }

    /// Products of the columns of terms by group.
    fn products(&self, effect: &Effect, terms: &[Term]) -> Option<Arc<Vec<Products>>> {
        let name = name(effect);
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let same =
            |list: &Vec<KnownTerms>| list.iter().find(|(own, _)| own == terms).map(|(_, products)| products.clone());
        if let Some(products) = known().get(&name).and_then(same) {
            return Some(products);
        }
        let columns = self.model.columns(effect, terms).ok()?;
        let of_group = |tests: &Range<usize>| self.whitened.products_in(tests.clone(), &columns, &[1.0]);
        let products: Arc<Vec<Products>> = Arc::new(self.groups.iter().map(of_group).collect());
        known().entry(name).or_default().push((terms.to_vec(), products.clone()));
        Some(products)
    }
}

/// Share of a column's information that is rounding.
const ROUNDING: f64 = 1e-9;

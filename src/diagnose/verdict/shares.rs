//! What the readings are made of: how much each location error, ball, bar and finding adds to them, ranked. Nothing is fitted.

use super::explanation::Explanation;
use crate::diagnose::model::linear_model::LinearModel;
use crate::identify::Quantity;
use crate::machine::{Component, ErrorName};
use crate::session::Setups;
use crate::statistics::rms;

/// Part of the readings that one cause makes.
#[derive(Debug, Clone, PartialEq)]
pub struct ShareOfReadings {
    /// One source, or several of which the readings tell only what they do together: traces of the same form, or places and location errors
    /// that stand for each other.
    pub sources: Vec<Source>,
    /// Root mean square over the readings that take part, µm.
    pub rms_um: f64,
    /// Its mean square over the sum of all mean squares. Parts may cancel each other, so that this ranks and does not add up to
    /// what was read.
    pub share: f64,
}

/// What makes a part of the readings.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A location error, by name.
    Location(String),
    /// A ball or a bar elsewhere or longer than stated, by label.
    Setup(String),
    /// Other unknowns of the fit: what an instrument or the linear axes may be off.
    Other,
    /// A finding, by number from 0.
    Finding(usize),
    /// What nothing explains.
    Rest,
}

/// Parts of the readings, the largest first.
pub fn shares_of_readings(model: &LinearModel, setups: &Setups, told: &Explanation) -> Vec<ShareOfReadings> {
    let machine = model.context.machine();
    let location =
        |axis: usize, component: Component| ErrorName::location(component, &machine.axes[axis].name).to_string();
    let mut parts: Vec<(Source, Vec<Vec<f64>>)> = Vec::new();
    let covariance = told.regression.covariance();
    let mut untold: Vec<Source> = Vec::new();
    for (k, unknown) in model.problem.unknowns.iter().enumerate() {
        let source = match unknown.quantity {
            Quantity::Location { axis, component } => Source::Location(location(axis, component)),
            Quantity::Pivot { setup, .. } => Source::Setup(setups.pivots[setup].label.clone()),
            Quantity::SpindleBall { setup, .. } => Source::Setup(setups.spindle_balls[setup].label.clone()),
            Quantity::Bar { setup } => Source::Setup(setups.bars[setup].label.clone()),
            _ => Source::Other,
        };
        // in units of the prior: where the fit stands, and what the findings have changed
        let amplitude = model.beyond[k] + unknown.prior_mean / unknown.prior_sigma + told.regression.nuisance(k);
        if source != Source::Other && covariance[(k, k)] > MOST_VARIANCE_LEFT && !untold.contains(&source) {
            untold.push(source.clone());
        }
        let index = part_of(&mut parts, source, model);
        for (sum, columns) in parts[index].1.iter_mut().zip(model.nuisance.iter()) {
            sum.iter_mut().zip(columns.column(k).iter()).for_each(|(sum, column)| *sum += column * amplitude);
        }
    }
    for (number, finding) in told.findings.iter().enumerate() {
        let index = part_of(&mut parts, Source::Finding(number), model);
        for &column in &finding.columns {
            let amplitude = told.regression.accepted(column);
            let by_test = &told.columns[column].column.by_test;
            for (sum, rows) in parts[index].1.iter_mut().zip(by_test.iter()) {
                sum.iter_mut().zip(rows).for_each(|(sum, row)| *sum += row * amplitude);
            }
        }
    }
    parts.push((Source::Rest, told.left_mm.clone()));
    ranked(model, together(as_one(parts, &untold)))
}

/// Share of its prior variance that is left of a place or a location error which the readings tell by itself: half its spread.
const MOST_VARIANCE_LEFT: f64 = 0.25;

/// Places and location errors that the readings tell together alone, as one part: how a fit divides it among them is for the priors to say.
fn as_one(parts: Vec<(Source, Vec<Vec<f64>>)>, untold: &[Source]) -> Vec<Part> {
    let (open, told): (Vec<_>, Vec<_>) = parts.into_iter().partition(|(source, _)| untold.contains(source));
    let mut open = open.into_iter();
    let mut list: Vec<Part> = Vec::new();
    if let Some((source, rows)) = open.next() {
        let mut all = (vec![source], rows);
        for (source, rows) in open {
            all.0.push(source);
            all.1.iter_mut().flatten().zip(rows.iter().flatten()).for_each(|(sum, row)| *sum += row);
        }
        list.push(all);
    }
    list.extend(told.into_iter().map(|(source, rows)| (vec![source], rows)));
    list
}

/// A source with the part of the readings that it makes, by test.
type Part = (Vec<Source>, Vec<Vec<f64>>);

/// Squared cosine from which two traces have the same form: less than a thousandth of one is not the other's.
const SAME_FORM: f64 = 0.999;

/// Parts of the same form as one.
fn together(parts: Vec<Part>) -> Vec<Part> {
    let dot = |one: &[Vec<f64>], other: &[Vec<f64>]| -> f64 {
        one.iter().flatten().zip(other.iter().flatten()).map(|(a, b)| a * b).sum()
    };
    let mut list: Vec<Part> = Vec::new();
    for (own_sources, rows) in parts {
        let own = dot(&rows, &rows);
        let same = list.iter_mut().find(|(sources, known)| {
            let (across, theirs) = (dot(&rows, known), dot(known, known));
            !sources.contains(&Source::Rest)
                && !own_sources.contains(&Source::Rest)
                && across * across > SAME_FORM * own * theirs
                && own * theirs > 0.0
        });
        match same {
            Some((sources, known)) => {
                sources.extend(own_sources);
                known.iter_mut().flatten().zip(rows.iter().flatten()).for_each(|(sum, row)| *sum += row);
            }
            None => list.push((own_sources, rows)),
        }
    }
    list
}

/// Place of a source in the list, with zeros where it is new.
fn part_of(parts: &mut Vec<(Source, Vec<Vec<f64>>)>, source: Source, model: &LinearModel) -> usize {
    parts.iter().position(|(known, _)| *known == source).unwrap_or_else(|| {
        parts.push((source, model.residual_mm.iter().map(|rows| vec![0.0; rows.len()]).collect()));
        parts.len() - 1
    })
}

fn ranked(model: &LinearModel, parts: Vec<Part>) -> Vec<ShareOfReadings> {
    let rms_um = |by_test: &[Vec<f64>]| {
        let rows = by_test.iter().zip(&model.kept).flat_map(|(rows, kept)| rows.iter().zip(kept));
        1e3 * rms(rows.filter(|(_, kept)| **kept).map(|(value, _)| *value))
    };
    let mut list: Vec<ShareOfReadings> = parts
        .into_iter()
        .map(|(sources, rows)| ShareOfReadings { sources, rms_um: rms_um(&rows), share: 0.0 })
        .collect();
    list.retain(|part| part.rms_um.is_finite());
    let all: f64 = list.iter().map(|part| part.rms_um.powi(2)).sum();
    list.iter_mut().for_each(|part| part.share = if all > 0.0 { part.rms_um.powi(2) / all } else { 0.0 });
    list.sort_by(|a, b| b.rms_um.total_cmp(&a.rms_um));
    list
}

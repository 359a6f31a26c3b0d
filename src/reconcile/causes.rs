//! What could set claims of one machine apart: assumptions read otherwise, and physics that the reductions leave out.
//!
//! An assumption has no size: with it the stated errors of one claim read otherwise, `y → G⁻¹ y`, G what the machine's errors
//! become when the session was as assumed and the reduction as stated. Physics has a size, fitted; a size beyond what a
//! workshop knows excludes it.

use nalgebra::{DMatrix, DVector};

use super::budget::{moved, places};
use super::design::{Design, Group};
use super::error::ReconcileError;
use crate::chain::Branch;
use crate::effects::{ROTARY_ERROR_MOTION, STRAIGHTNESS, THERMAL_GROWTH};
use crate::machine::{AxisKind, Component, Effect, ErrorName, Outlet, ParameterValue, Place};
use crate::session::Session;
use crate::units::UM_PER_MM;

/// What a cause is, for words.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// The bar read one circle wrongly by a wave of the angle.
    Bar { group: usize, coordinate: usize },
    /// The two circles of an axis lie on it the other way round.
    LeverSign { axis: usize },
    /// Their distance is a multiple of what was taken.
    LeverLength { axis: usize, factor: f64 },
    /// The ball carried stood on the other side of the axis.
    PivotSide { axis: usize },
    /// D was taken as 50√2 in place of 50√5 mm.
    PrintedD,
    /// The outer tilt stands in the inner one, or was taken out with the other sign.
    OuterTilt { outer: ErrorName, inner: ErrorName, left_in: f64 },
    /// Both balls stood elsewhere along the axis.
    PlaceAlong { axis: usize },
    /// The part that carries the spindle ball grew with the warmth of the session.
    Growth { axis: usize, coordinate: usize },
    /// The spindle ball stood otherwise from a circle on.
    Seat { from_group: usize, coordinate: usize },
    /// The axis moved along itself once a turn.
    AxialMotion { axis: usize, is_sine: bool },
    /// A guideway is bent where it stands in some circles.
    WornGuideway { axis: usize, centre_mm: f64, coordinate: usize },
}

/// One cause with what it does.
#[derive(Debug, Clone)]
pub struct Cause {
    pub kind: Kind,
    /// Index of the claim in which it acts; `None`: it is the machine's and acts in all.
    pub claim: Option<usize>,
    /// Largest plausible size in `unit`; `None`: an assumption, which has no size.
    pub limit: Option<f64>,
    pub unit: &'static str,
    /// By claim: what the errors change by per unit of size, or the matrix `G⁻¹ − 1` for an assumption.
    pub effect: Vec<Change>,
}

/// What a cause does to the errors of one claim.
#[derive(Debug, Clone)]
pub enum Change {
    None,
    PerUnit(DVector<f64>),
    /// Of the stated errors themselves.
    Restated(DMatrix<f64>),
}

/// Time constant of a spindle's growth, s: half an hour is usual, and the warm-up of 20 min leaves a third of it.
const GROWTH_S: f64 = 1800.0;
/// Largest growth after warm-up, seat of a magnetic cup, axial motion, dent of a guideway, µm; the bar by its maker.
const GROWTH_UM: f64 = 30.0;
const SEAT_UM: f64 = 10.0;
const AXIAL_UM: f64 = 10.0;
const WORN_UM: f64 = 10.0;
const BAR_UM: f64 = 1.0;
/// Width of a worn place, mm: as the balls' carriage is long.
const WORN_MM: f64 = 160.0;
/// How far a place along the axis that is not printed can lie from the one assumed, mm.
const PLACE_MM: f64 = 300.0;
/// Places of a slide closer than this are one, mm.
const SAME_PLACE_MM: f64 = 20.0;
/// Step with which a place is moved to see what that does, mm.
const PLACE_STEP_MM: f64 = 10.0;
/// What eq. 3.13 prints for √5, over it.
const PRINTED_D: f64 = 0.632_455_532_033_675_9;

/// Every cause known, for these designs.
pub fn causes(designs: &[Design]) -> Result<Vec<Cause>, ReconcileError> {
    let mut list = Vec::new();
    for (claim, design) in designs.iter().enumerate() {
        let mut of_claim: Vec<(Kind, Option<f64>, &'static str, Change)> = Vec::new();
        readings(design, &mut of_claim)?;
        assumptions(design, &mut of_claim);
        physics_of_a_session(design, &mut of_claim);
        list.extend(of_claim.into_iter().map(|(kind, limit, unit, change)| {
            let mut effect = vec![Change::None; designs.len()];
            effect[claim] = change;
            Cause { kind, claim: Some(claim), limit, unit, effect }
        }));
    }
    let same_machine =
        designs.windows(2).all(|pair| pair[0].session.machine.axis_names() == pair[1].session.machine.axis_names());
    if same_machine {
        list.extend(physics_of_the_machine(designs));
    }
    Ok(list)
}

type List = Vec<(Kind, Option<f64>, &'static str, Change)>;

fn readings(design: &Design, list: &mut List) -> Result<(), ReconcileError> {
    for group in 0..design.groups.len() {
        for coordinate in 0..2 {
            let change = Change::PerUnit(design.response_of_circle(group, coordinate, 1.0)?);
            list.push((Kind::Bar { group, coordinate }, Some(BAR_UM), "um", change));
        }
    }
    Ok(())
}

/// Assumptions that the design allows to be otherwise; one whose reading determines nothing is left out.
fn assumptions(design: &Design, list: &mut List) {
    let mut axes: Vec<usize> = design.groups.iter().map(|group| group.axis).collect();
    axes.sort_unstable();
    axes.dedup();
    let own = |axis: usize| move |group: &Group| group.axis == axis;
    let mut restate = |kind: Kind, actual: Session, declared: &Session| {
        if let Some(change) = restated(design, &actual, declared) {
            list.push((kind, None, "", Change::Restated(change)));
        }
    };
    let session = &design.session;
    for &axis in &axes {
        let along = |factor: f64| {
            design.with_balls_along(session, |group| match own(axis)(group) {
                true => [(factor - 1.0) * group.at_mm, (factor - 1.0) * (group.at_mm + group.reach_mm)],
                false => [0.0; 2],
            })
        };
        restate(Kind::LeverSign { axis }, along(-1.0), session);
        let two_places = design.groups.iter().filter(|group| own(axis)(group)).all(|group| group.reach_mm.abs() < 1.0);
        for factor in if two_places { &[0.5, 2.0][..] } else { &[] } {
            restate(Kind::LeverLength { axis, factor: *factor }, along(*factor), session);
        }
        restate(Kind::PivotSide { axis }, design.with_pivot_opposite(axis), session);
    }
    if design.groups.iter().any(|group| group.reach_mm.abs() > 1.0) {
        let printed = design.with_balls_along(session, |group| [group.reach_mm * (1.0 - PRINTED_D), 0.0]);
        restate(Kind::PrintedD, session.clone(), &printed);
    }
    for (outer, inner) in carried_tilts(design) {
        for left_in in [1.0, 2.0] {
            let mut change = DMatrix::zeros(design.names.len(), design.names.len());
            let place = |name: &ErrorName| design.names.iter().position(|other| other == name).unwrap_or(0);
            change[(place(&inner), place(&outer))] = -left_in;
            let kind = Kind::OuterTilt { outer: outer.clone(), inner: inner.clone(), left_in };
            list.push((kind, None, "", Change::Restated(change)));
        }
    }
    for &axis in &axes {
        let step =
            design.with_balls_along(session, |group| if own(axis)(group) { [PLACE_STEP_MM; 2] } else { [0.0; 2] });
        if let Some(change) = restated(design, &step, session) {
            list.push((Kind::PlaceAlong { axis }, Some(PLACE_MM), "mm", Change::Restated(change / PLACE_STEP_MM)));
        }
    }
}

/// Pairs of tilts of which a test of the inner axis sees the sum.
fn carried_tilts(design: &Design) -> Vec<(ErrorName, ErrorName)> {
    let machine = &design.session.machine;
    let rotary = |axis: &&usize| machine.axes[**axis].kind == AxisKind::Rotary;
    let table: Vec<usize> = design.chain.branch(Branch::Workpiece).iter().filter(rotary).copied().collect();
    let [outer, inner] = table[..] else { return Vec::new() };
    let stated = |component: Component, axis: usize| {
        let name = ErrorName::location(component, &machine.axes[axis].name);
        design.names.contains(&name).then_some(name)
    };
    let tilts = Component::ALL.into_iter().filter(|component| component.is_angle());
    tilts.filter_map(|tilt| Some((stated(tilt, outer)?, stated(tilt, inner)?))).collect()
}

/// `G⁻¹ − 1`; `None` where the reduction fails or does not tell the errors.
fn restated(design: &Design, actual: &Session, declared: &Session) -> Option<DMatrix<f64>> {
    let count = design.names.len();
    let base = design.response_as(actual, declared).ok()?;
    let mut matrix = DMatrix::zeros(count, count);
    for k in 0..count {
        let unit = DVector::from_fn(count, |row, _| f64::from(row == k));
        let response = design.response_as(&design.with_errors(actual, &unit), declared).ok()? - &base;
        matrix.set_column(k, &response);
    }
    let inverse = matrix.try_inverse()?;
    let change = inverse - DMatrix::identity(count, count);
    // an assumption that reads the same is none
    (change.iter().all(|value| value.is_finite()) && change.amax() > 1e-3).then_some(change)
}

/// The effect of the catalogue that a cause is, 1 µm of it; `None` for a cause of another kind.
pub fn effect_of(design: &Design, kind: &Kind) -> Option<Effect> {
    let micron = 1.0 / UM_PER_MM;
    match *kind {
        Kind::Growth { axis, coordinate } => {
            Some(
                Effect::new(THERMAL_GROWTH.name, Place::Axis(axis))
                    .with("tau", ParameterValue::List(vec![GROWTH_S]))
                    .size(Outlet::Motion { axis, component: Component::ALL[coordinate] }, "growth1", micron),
            )
        }
        Kind::AxialMotion { axis, is_sine } => {
            let component = Component::ALL[design.session.machine.axes[axis].coordinate_direction()?];
            Some(
                Effect::new(ROTARY_ERROR_MOTION.name, Place::Axis(axis))
                    .with("orders", ParameterValue::List(vec![1.0]))
                    .size(Outlet::Motion { axis, component }, if is_sine { "sin1" } else { "cos1" }, micron),
            )
        }
        Kind::WornGuideway { axis, centre_mm, coordinate } => Some(
            Effect::new(STRAIGHTNESS.name, Place::Axis(axis))
                .with("centre", ParameterValue::Number(centre_mm))
                .with("width", ParameterValue::Number(WORN_MM))
                .size(Outlet::Motion { axis, component: Component::ALL[coordinate] }, "bump", micron),
        ),
        _ => None,
    }
}

fn physics_of_a_session(design: &Design, list: &mut List) {
    let machine = &design.session.machine;
    let slide =
        design.chain.branch(Branch::Tool).iter().rev().find(|axis| machine.axes[**axis].kind == AxisKind::Linear);
    if let Some(&axis) = slide {
        for kind in (0..3).map(|coordinate| Kind::Growth { axis, coordinate }) {
            if let Some(change) = of_effect(design, &kind) {
                list.push((kind, Some(GROWTH_UM), "um", change));
            }
        }
    }
    for from_group in 1..design.groups.len() {
        let later: Vec<usize> =
            design.groups[from_group..].iter().flat_map(|group| &group.tests).map(|(test, _)| *test).collect();
        for coordinate in 0..3 {
            if let Ok(response) = design.response(&moved(design, &later, coordinate)) {
                let change = Change::PerUnit(response);
                list.push((Kind::Seat { from_group, coordinate }, Some(SEAT_UM), "um", change));
            }
        }
    }
}

fn of_effect(design: &Design, kind: &Kind) -> Option<Change> {
    let mut session = design.session.clone();
    session.machine.effects.push(effect_of(design, kind)?);
    let is_finite = |response: &DVector<f64>| response.iter().all(|value| value.is_finite());
    design.response(&session).ok().filter(is_finite).map(Change::PerUnit)
}

fn physics_of_the_machine(designs: &[Design]) -> Vec<Cause> {
    let Some(first) = designs.first() else { return Vec::new() };
    let mut found: Vec<(Kind, f64)> = Vec::new();
    for (axis, of_axis) in first.session.machine.axes.iter().enumerate() {
        let Some(own) = of_axis.coordinate_direction() else { continue };
        let stands = match of_axis.kind {
            AxisKind::Rotary => {
                found.extend([true, false].map(|is_sine| (Kind::AxialMotion { axis, is_sine }, AXIAL_UM)));
                continue;
            }
            AxisKind::Linear => stands_at(designs, axis),
        };
        // a slide that stands in one place alone shows no dent
        for centre_mm in stands.iter().filter(|_| stands.len() > 1) {
            let across = (0..3).filter(|coordinate| *coordinate != own);
            let kind = |coordinate| Kind::WornGuideway { axis, centre_mm: *centre_mm, coordinate };
            found.extend(across.map(|coordinate| (kind(coordinate), WORN_UM)));
        }
    }
    let cause = |(kind, limit): (Kind, f64)| {
        let all: Option<Vec<Change>> = designs.iter().map(|design| of_effect(design, &kind)).collect();
        Some(Cause { kind, claim: None, limit: Some(limit), unit: "um", effect: all? })
    };
    found.into_iter().filter_map(cause).collect()
}

/// Where a slide stands in the circles of all designs, mm.
fn stands_at(designs: &[Design], axis: usize) -> Vec<f64> {
    let mut all: Vec<f64> = Vec::new();
    for design in designs {
        for place in places(design) {
            let at = design.session.tests[place[0]].positions.get(axis).copied().flatten();
            let Some(at) = at else { continue };
            if all.iter().all(|other| (other - at).abs() > SAME_PLACE_MM) {
                all.push(at);
            }
        }
    }
    all.sort_by(f64::total_cmp);
    all
}

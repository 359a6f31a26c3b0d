//! What a session cannot show: the smallest size of every cause that its recordings would reveal. It looks at no residual.

use crate::diagnose::cause::Cause;
use crate::diagnose::fault_kind::FaultKind;
use crate::diagnose::model::linear_model::{Column, LinearModel, Term};
use crate::diagnose::selection::naming::{cause_of, unit};
use crate::diagnose::selection::screening::candidates::{family_terms, terms};
use crate::effects::CandidateFamily;
use crate::effects::{self, CYCLIC_ERROR, Driver, KINDS, Kind, ROTARY_ERROR_MOTION, Signature, UNKNOWN, is_a, kind};
use crate::identify::{Fit, FitError, turned_senses};
use crate::machine::{Effect, Machine, Outlet, ParameterValue, Place};
use crate::session::Session;
use crate::units::Measure;

/// A cause that may be there unseen.
#[derive(Debug, Clone, PartialEq)]
pub struct Unseen {
    pub cause: Cause,
    /// Smallest size with a χ² of 50 beside everything else in the fit, display units; `None`: no size shows.
    pub smallest: Option<f64>,
    pub unit: &'static str,
    /// A test that would show it.
    pub test: String,
}

/// A cause that may be there unseen, with the form in which it was looked for.
pub(crate) struct Hidden<'f> {
    pub(crate) unseen: Unseen,
    pub(crate) form: Option<HiddenForm<'f>>,
    /// It may be there at sizes that matter: these are listed.
    pub(crate) matters: bool,
}

/// The form of a cause through one outlet.
pub(crate) struct HiddenForm<'f> {
    pub(crate) effect: Effect,
    pub(crate) terms: Vec<Term>,
    pub(crate) family: &'f CandidateFamily,
    /// Sizes from which it matters, display units.
    pub(crate) notable: f64,
}

impl Hidden<'_> {
    /// One that no single form stands for.
    fn shapeless(unseen: Unseen) -> Hidden<'static> {
        Hidden { unseen, form: None, matters: true }
    }
}

/// Name of the cause in which an axis moves the other way than the machine file says; the mistake in the files has the same.
pub const AXIS_SENSE: &str = FaultKind::AxisSign.name();

/// χ² from which a cause counts as visible: what the search demands, with the cost of shapes.
const LEAST_CHI2: f64 = 50.0;

/// Smallest size that shows where a size of one has so much information; `None`: no size does.
fn smallest(information: f64) -> Option<f64> {
    (information > 1e-12).then(|| (LEAST_CHI2 / information).sqrt())
}

/// Smallest size, µm or arcsec, from which a motion counts as hidden in any form: named forms have bounds of their own.
const HIDES_ANY_FORM: f64 = 20.0;

fn notable(kind: &Kind, is_angle: bool) -> f64 {
    if is_angle { kind.notable.angle } else { kind.notable.length }
}

/// Causes with the smallest size of each that the session shows; `information` tells what the readings say of an effect's terms, one
/// by one.
pub(crate) fn unseen_causes<'f>(
    model: &LinearModel,
    families: &'f [CandidateFamily],
    information: impl Fn(&[Column]) -> Vec<f64>,
) -> Vec<Hidden<'f>> {
    unseen_of(model, families, &|effect, terms| Some(information(&model.columns(effect, terms).ok()?)))
}

/// What the readings say of an effect's terms, one by one, in display units to the power of −2.
pub(super) type Information<'i> = dyn Fn(&Effect, &[Term]) -> Option<Vec<f64>> + 'i;

/// The same by terms.
pub(super) fn unseen_of<'f>(
    model: &LinearModel,
    families: &'f [CandidateFamily],
    information: &Information,
) -> Vec<Hidden<'f>> {
    let machine = model.context.machine();
    let mut list: Vec<Hidden> = Vec::new();
    let mut seen: Vec<(&str, Place, Outlet, Option<&ParameterValue>)> = Vec::new();
    for family in families {
        let Some(kind) = kind(family.kind).filter(|kind| kind.unseen == effects::Unseen::Listed) else { continue };
        let Some(effect) = family.grid.get(family.grid.len() / 2) else { continue };
        if effect.parameter("of").is_some() {
            // what another axis drives shows as little as play of the place's own motion, which is listed
            continue;
        }
        let terms = family_terms(machine, family, effect);
        let own = family.outlets.iter().filter(|outlet| !matches!(outlet, Outlet::SlidesAcceleration { .. }));
        for outlet in own {
            // every bar has a calibration of its own, beside the growth of all
            let key = (family.kind, family.place, *outlet, effect.parameter("bar"));
            if seen.contains(&key) {
                continue;
            }
            seen.push(key);
            let own: Vec<Term> = terms.iter().filter(|term| term.outlet == *outlet).copied().collect();
            let Some(shown) = information(effect, &own) else { continue };
            let smallest = smallest(shown.into_iter().fold(0.0, f64::max));
            let measure = own.first().map(|term| term.measure);
            let is_angle = measure == Some(crate::units::Measure::Angle);
            let notable = notable(kind, is_angle);
            let mut cause = cause_of(machine, effect, std::slice::from_ref(outlet));
            // of several bars each has a length
            if let Some(ParameterValue::Number(length)) = effect.parameter("bar") {
                cause.components = vec![format!("bar {length}")];
            }
            let unseen = Unseen {
                cause,
                smallest: smallest.filter(|value| *value < 1e5),
                unit: measure.map_or("um", unit),
                test: kind.shown_by.words(model.context.session(), family.place),
            };
            let form = Some(HiddenForm { effect: effect.clone(), terms: own, family, notable });
            let matters = smallest.is_none_or(|smallest| smallest > notable);
            list.push(Hidden { unseen, form, matters });
            if !matters && kind.signature == Signature::ErrorMotion && is_axial(machine, outlet) {
                list.extend(unseen_once_a_turn(model, family, outlet, information));
            }
        }
    }
    unseen_slips(model, families, information, &mut list);
    unseen_of_any_form(model, families, information, &mut list);
    unmoved(model.context.session(), families, &mut list);
    list
}

/// Axes whose sense could be turned in the machine file without a worse fit.
pub fn unseen_senses(session: &Session, fit: &Fit) -> Result<Vec<Unseen>, FitError> {
    let untold = turned_senses(session, fit)?.into_iter().filter(|sense| !sense.is_told());
    let blind = untold.map(|sense| {
        let name = sense.named(&session.machine);
        Unseen {
            cause: Cause {
                effect: AXIS_SENSE.into(),
                driver: Driver::Constant,
                components: sense.axes.iter().map(|&axis| session.machine.axes[axis].name.clone()).collect(),
                place: name,
            },
            smallest: None,
            unit: "",
            test: sense.how_to_tell(session),
        }
    });
    Ok(blind.collect())
}

/// True for motion along a rotary axis's own line.
fn is_axial(machine: &Machine, outlet: &Outlet) -> bool {
    let Outlet::Motion { axis, component } = *outlet else { return false };
    !component.is_angle() && machine.axes[axis].own_component().direction_index() == component.direction_index()
}

/// Motion along a rotary axis once a turn: to a bar that sweeps a cone it looks like a tilt of the axis, whatever higher
/// orders show.
fn unseen_once_a_turn<'f>(
    model: &LinearModel,
    family: &'f CandidateFamily,
    outlet: &Outlet,
    information: &Information,
) -> Option<Hidden<'f>> {
    let machine = model.context.machine();
    let effect = Effect::new(ROTARY_ERROR_MOTION.name, family.place).with("orders", ParameterValue::List(vec![1.0]));
    let terms = terms(machine, &effect, std::slice::from_ref(outlet));
    let shown = information(&effect, &terms)?;
    let weakest = shown.into_iter().fold(f64::INFINITY, f64::min);
    let smallest = smallest(weakest);
    let notable = notable(&ROTARY_ERROR_MOTION, false);
    smallest.is_none_or(|smallest| smallest > notable).then(|| Hidden {
        unseen: Unseen {
            cause: cause_of(machine, &effect, std::slice::from_ref(outlet)),
            smallest: smallest.filter(|value| *value < 1e5),
            unit: "um",
            test: "once a turn only: the short bar with its balls where the extended bar had the standing one"
                .to_string(),
        },
        form: Some(HiddenForm { effect, terms, family, notable }),
        matters: true,
    })
}

/// Slips of a ball between two tests that the session does not show, at the least visible moment.
fn unseen_slips<'f>(
    model: &LinearModel,
    families: &'f [CandidateFamily],
    information: &Information,
    list: &mut Vec<Hidden<'f>>,
) {
    let machine = model.context.machine();
    let tests = &model.context.session().tests;
    let runs_at =
        |time: f64| (0..tests.len()).any(|k| (tests[k].started_at_s..=model.context.ends_at_s(k)).contains(&time));
    for kind in KINDS.iter().filter(|kind| kind.unseen == effects::Unseen::ByMoment) {
        // by term: its family, the effect and the information at the moment that shows it least
        let mut least: Vec<(Term, &CandidateFamily, &Effect, f64)> = Vec::new();
        for family in families.iter().filter(|family| family.kind == kind.name) {
            let between = family.grid.iter().filter(
                |effect| matches!(effect.parameter("time"), Some(ParameterValue::Number(time)) if !runs_at(*time)),
            );
            for effect in between {
                let terms = family_terms(machine, family, effect);
                let Some(shown) = information(effect, &terms) else { continue };
                for (term, own) in terms.iter().zip(shown) {
                    match least.iter_mut().find(|(known, ..)| known.outlet == term.outlet) {
                        Some(least) if own < least.3 => *least = (*term, family, effect, own),
                        Some(_) => {}
                        None => least.push((*term, family, effect, own)),
                    }
                }
            }
        }
        for (term, family, effect, shown) in least {
            let smallest = smallest(shown);
            let notable = notable(kind, false);
            if smallest.is_none_or(|smallest| smallest > notable) {
                let unseen = Unseen {
                    cause: cause_of(machine, effect, &[term.outlet]),
                    smallest: smallest.filter(|value| *value < 1e5),
                    unit: "um",
                    test: kind.shown_by.words(model.context.session(), effect.place),
                };
                let form = Some(HiddenForm { effect: effect.clone(), terms: vec![term], family, notable });
                list.push(Hidden { unseen, form, matters: true });
            }
        }
    }
}

/// Motions over the travel of an axis that the session does not show whatever their form: the lengths of
/// an axis together, and its angles.
fn unseen_of_any_form(
    model: &LinearModel,
    families: &[CandidateFamily],
    information: &Information,
    list: &mut Vec<Hidden>,
) {
    let machine = model.context.machine();
    let mut seen: Vec<Outlet> = Vec::new();
    // by place and measure: outlets and the smallest size that shows through any of them
    let mut hidden: Vec<(&Effect, Measure, Vec<Outlet>, Option<f64>)> = Vec::new();
    for family in
        families.iter().filter(|family| is_a(family.kind, Signature::FreeCurve) && family.place.axis().is_some())
    {
        let Some(effect) = family.grid.first().filter(|effect| effect.tests.is_none()) else { continue };
        for outlet in &family.outlets {
            if seen.contains(outlet) {
                continue;
            }
            seen.push(*outlet);
            let measure = outlet.measure(machine);
            let own = terms(machine, effect, std::slice::from_ref(outlet));
            let Some(shown) = information(effect, &own) else { continue };
            let smallest = smallest(shown.into_iter().fold(0.0, f64::max));
            let smallest = smallest.filter(|value| *value < 1e5);
            if smallest.is_some_and(|smallest| smallest <= HIDES_ANY_FORM) {
                continue;
            }
            let own = hidden.iter_mut().find(|(of, kind, ..)| of.place == effect.place && *kind == measure);
            match own {
                Some((.., outlets, least)) => {
                    outlets.push(*outlet);
                    *least = least.iter().copied().chain(smallest).min_by(f64::total_cmp);
                }
                None => hidden.push((effect, measure, vec![*outlet], smallest)),
            }
        }
    }
    list.extend(hidden.into_iter().map(|(effect, measure, outlets, smallest)| {
        // its own motion shows along its turning or travel only
        let own = effect.place.axis().map(|axis| Outlet::own(machine, axis));
        let is_own = outlets.iter().all(|outlet| Some(*outlet) == own);
        Hidden::shapeless(Unseen {
            cause: cause_of(machine, effect, &outlets),
            smallest,
            unit: unit(measure),
            test: (if is_own { CYCLIC_ERROR.shown_by } else { UNKNOWN.shown_by })
                .words(model.context.session(), effect.place),
        })
    }));
}

/// Causes of axes that never moved, for which there is no family at all.
fn unmoved(session: &Session, families: &[CandidateFamily], list: &mut Vec<Hidden>) {
    let machine = &session.machine;
    for axis in 0..machine.axes.len() {
        let place = Place::Axis(axis);
        for kind in KINDS.iter().filter(|kind| kind.unmoved.contains(&machine.axes[axis].kind)) {
            if families.iter().any(|family| family.kind == kind.name && family.place == place) {
                continue;
            }
            let outlets = (kind.outlets)(machine, place);
            let effect = Effect::new(kind.name, place);
            let Some(outlet) = outlets.first() else { continue };
            list.push(Hidden::shapeless(Unseen {
                cause: cause_of(machine, &effect, &outlets),
                smallest: None,
                unit: unit((kind.measure)(machine, outlet, "")),
                test: kind.shown_by.words(session, place),
            }));
        }
    }
}

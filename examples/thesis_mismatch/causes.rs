//! Physics that a session of the thesis's designs may leave out, as effects of workshop size. It simulates nothing.

use fiveaxis::machine::{Effect, ErrorName, Machine, Outlet, ParameterValue, Place};
use fiveaxis::units::{ARCSEC_PER_RAD, UM_PER_MM};

/// What one more recording can show the cause; see `designs`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extension {
    /// The first test and the first C test again at the end, nothing remounted.
    RepeatAtEnd,
    /// Chapter 4, and the short bar with both balls moved to where the extended test has its spindle ball.
    ShortAtDistance,
    /// Planar circles XY and XZ at two places of X, beside chapter 6.
    PlanarCircles,
}

/// How the cause enters the simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Nature {
    Nothing,
    /// An effect of the catalogue: its name, place, outlets with the function and the size (µm or arcsec).
    Effect {
        kind: &'static str,
        place: &'static str,
        sizes: &'static [(&'static str, &'static str, f64)],
    },
    /// Pivots stand so many times their drawn error off.
    CarelessPivots(f64),
}

/// One cause.
#[derive(Debug, Clone, Copy)]
pub struct LeftOut {
    pub name: &'static str,
    /// Size as the table prints it, µm or arcsec.
    pub size: f64,
    pub unit: &'static str,
    pub nature: Nature,
    pub extension: Option<Extension>,
}

const fn cause(
    name: &'static str,
    size: f64,
    unit: &'static str,
    nature: Nature,
    extension: Option<Extension>,
) -> LeftOut {
    LeftOut { name, size, unit, nature, extension }
}

const fn effect(
    kind: &'static str,
    place: &'static str,
    sizes: &'static [(&'static str, &'static str, f64)],
) -> Nature {
    Nature::Effect { kind, place, sizes }
}

/// Time constant of a spindle's growth, s.
const GROWTH_S: f64 = 1800.0;
/// Half travels of the C600U's X and Z, mm, over which a bow has its height.
const HALF_TRAVEL_MM: [(&str, f64); 2] = [("X", 300.0), ("Z", 225.0)];
/// A worn place: its centre and width on X, mm.
const WORN_MM: (f64, f64) = (-112.0, 160.0);

/// The causes tried, the empty one first.
pub const CAUSES: [LeftOut; 14] = [
    cause("nothing", 0.0, "um", Nature::Nothing, None),
    cause(
        "spindle grows down (EZZ)",
        15.0,
        "um",
        effect("thermal-growth", "Z", &[("EZZ", "growth1", 15.0)]),
        Some(Extension::RepeatAtEnd),
    ),
    cause(
        "head moves sideways as it warms (EYZ)",
        10.0,
        "um",
        effect("thermal-growth", "Z", &[("EYZ", "growth1", 10.0)]),
        Some(Extension::RepeatAtEnd),
    ),
    cause(
        "spindle ball seats anew at the first change",
        4.0,
        "um",
        effect("ball-slip", "spindle-ball", &[("y", "", 2.4), ("z", "", 3.2)]),
        Some(Extension::RepeatAtEnd),
    ),
    cause(
        "C moves along its axis once a turn (EZC)",
        3.0,
        "um",
        effect("rotary-error-motion", "C", &[("EZC", "sin1", 3.0)]),
        Some(Extension::ShortAtDistance),
    ),
    cause(
        "A moves along its axis as it tilts (EXA)",
        5.0,
        "um",
        effect("rotary-error-motion", "A", &[("EXA", "sin1", 5.0)]),
        Some(Extension::ShortAtDistance),
    ),
    cause(
        "A's own axis tilts as it turns (EBA)",
        3.0,
        "arcsec",
        effect("rotary-error-motion", "A", &[("EBA", "sin2", 3.0)]),
        Some(Extension::ShortAtDistance),
    ),
    cause(
        "A runs out across its axis (EZA)",
        4.0,
        "um",
        effect("rotary-error-motion", "A", &[("EZA", "sin2", 4.0)]),
        Some(Extension::ShortAtDistance),
    ),
    cause(
        "table sags as A tilts (EZA)",
        8.0,
        "um",
        effect("gravity-sag", "A", &[("EZA", "y", 8.0)]),
        Some(Extension::ShortAtDistance),
    ),
    cause(
        "X slide bowed (EZX)",
        10.0,
        "um",
        effect("straightness", "X", &[("EZX", "degree2", 10.0)]),
        Some(Extension::PlanarCircles),
    ),
    cause(
        "X guideway worn at −112 mm (EYX)",
        5.0,
        "um",
        effect("straightness", "X", &[("EYX", "bump", 5.0)]),
        Some(Extension::PlanarCircles),
    ),
    cause(
        "Z slide not square to X (EB0Z)",
        20.0,
        "arcsec",
        effect("squareness", "Z", &[("EB0Z", "", 20.0)]),
        Some(Extension::PlanarCircles),
    ),
    cause("pivots off five times the stated spread", 100.0, "um", Nature::CarelessPivots(5.0), None),
    cause("extended bar calibrated wrongly", 10.0, "um", effect("bar-length", "bar", &[("length", "", 10.0)]), None),
];

/// Seed of everything drawn for the cause with this index.
pub fn seed_of(index: usize) -> u64 {
    2014 + 100 * index as u64
}

impl LeftOut {
    /// The effect on a machine; `slip_at_s` is the session time of the first change of bar or place.
    pub fn effect(&self, machine: &Machine, slip_at_s: f64) -> Result<Option<Effect>, String> {
        let Nature::Effect { kind, place, sizes } = self.nature else { return Ok(None) };
        let others = Place::OTHERS.iter().find(|(name, _)| *name == place).map(|(_, place)| *place);
        let at = others.or_else(|| machine.axis_index(place).map(Place::Axis));
        let at = at.ok_or_else(|| format!("no place {place}"))?;
        let mut effect = Effect::new(kind, at);
        let functions = sizes.iter().map(|(_, function, _)| *function);
        for function in functions {
            let number = ParameterValue::Number;
            let list = |value| ParameterValue::List(vec![value]);
            let half_travel = HALF_TRAVEL_MM.iter().find(|(name, _)| *name == place).map_or(1.0, |(_, half)| *half);
            match (kind, function) {
                ("thermal-growth", _) => effect.set("tau", list(GROWTH_S)),
                ("ball-slip", _) => effect.set("time", number(slip_at_s)),
                ("rotary-error-motion", "sin1") => effect.set("orders", list(1.0)),
                ("rotary-error-motion", _) => effect.set("orders", list(2.0)),
                ("straightness", "bump") => {
                    effect.set("centre", number(WORN_MM.0));
                    effect.set("width", number(WORN_MM.1));
                }
                ("straightness", _) => {
                    effect.set("degrees", list(2.0));
                    effect.set("half_travel", number(half_travel));
                }
                ("bar-length", _) => effect.set("bar", number(super::designs::EXTENDED_MM)),
                _ => {}
            }
        }
        for (outlet, function, size) in sizes {
            let (outlet, is_angle) = outlet_named(machine, outlet)?;
            let per = if is_angle { ARCSEC_PER_RAD } else { UM_PER_MM };
            effect = effect.size(outlet, function, size / per);
        }
        Ok(Some(effect))
    }

    /// Name in the catalogue, place and components, as a diagnosis names them.
    pub fn truth(&self) -> Option<(&'static str, &'static str, Vec<String>)> {
        let Nature::Effect { kind, place, sizes } = self.nature else { return None };
        let name = |outlet: &str| match outlet {
            "x" | "y" | "z" => format!("spindle-ball-{outlet}"),
            other => other.to_string(),
        };
        Some((kind, place, sizes.iter().map(|(outlet, ..)| name(outlet)).collect()))
    }
}

fn outlet_named(machine: &Machine, name: &str) -> Result<(Outlet, bool), String> {
    match name {
        "x" => return Ok((Outlet::SpindleBall(0), false)),
        "y" => return Ok((Outlet::SpindleBall(1), false)),
        "z" => return Ok((Outlet::SpindleBall(2), false)),
        "length" => return Ok((Outlet::Reading, false)),
        _ => {}
    }
    let error = ErrorName::parse(name, &machine.axis_names()).map_err(|refusal| refusal.to_string())?;
    let axis = machine.axis_index(&error.axis).ok_or_else(|| format!("no axis {}", error.axis))?;
    let component = error.component;
    let outlet =
        if error.is_location { Outlet::Location { axis, component } } else { Outlet::Motion { axis, component } };
    Ok((outlet, component.is_angle()))
}

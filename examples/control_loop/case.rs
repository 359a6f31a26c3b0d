//! The twelve machines and what is concealed in each, beside location errors of both rotary axes.

use fiveaxis::machine::Component;

use crate::physics::{Effect, Law};

/// A machine file and its hidden physics.
pub struct Case {
    /// File in `machines/`.
    pub machine: &'static str,
    /// Name of the cause in the catalogue; `none` without one.
    pub name: &'static str,
    /// In words.
    pub concealed: &'static str,
    pub effect: Option<Effect>,
}

/// One second of arc, rad.
const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;
/// One micrometre, mm.
const UM: f64 = 1e-3;

const fn with(axis: &'static str, component: Component, size: f64, law: Law) -> Option<Effect> {
    Some(Effect { axis, component, size, law })
}

pub const CASES: [Case; 12] = [
    Case { machine: "hermle-c600u", name: "none", concealed: "location errors alone", effect: None },
    Case {
        machine: "table-table-ca-portal",
        name: "rotary-error-motion",
        concealed: "error motion of C, 4 µm twice a turn",
        effect: with("C", Component::EX, 4.0 * UM, Law::Wave { per_turn: 2.0 }),
    },
    Case {
        machine: "table-table-cb-moving-table",
        name: "cyclic-error",
        concealed: "cyclic error of B, 6 arcsec 36 times a turn",
        effect: with("B", Component::EB, 6.0 * ARCSEC, Law::Wave { per_turn: 36.0 }),
    },
    Case {
        machine: "table-head-cb-moving-table-y",
        name: "straightness",
        concealed: "straightness of X, 5 µm bend over 200 mm",
        effect: with("X", Component::EY, 5.0 * UM, Law::Bend { over_mm: 100.0 }),
    },
    Case {
        machine: "table-table-ca-cross-table",
        name: "linear-scale",
        concealed: "scale of Y, 40 µm/m",
        effect: with("Y", Component::EY, 40.0 * UM, Law::PerMetre),
    },
    Case {
        machine: "head-head-ca-overhead-gantry",
        name: "gravity-sag",
        concealed: "sag of A, 8 arcsec by the sine of its tilt",
        effect: with("A", Component::EA, 8.0 * ARCSEC, Law::Wave { per_turn: 1.0 }),
    },
    Case {
        machine: "fig-1-1-table-head-ca",
        name: "rotary-backlash",
        concealed: "lost motion of A, 4 arcsec to each side",
        effect: with("A", Component::EA, 4.0 * ARCSEC, Law::Play { take_up: 0.2 * std::f64::consts::PI / 180.0 }),
    },
    Case {
        machine: "table-table-ca-moving-table-x",
        name: "linear-backlash",
        concealed: "lost motion of X, 2 µm to each side",
        effect: with("X", Component::EX, 2.0 * UM, Law::Play { take_up: 0.2 }),
    },
    Case {
        machine: "fig-1-1-head-head-cb",
        name: "lateral-play",
        concealed: "play of B across, 3 µm to each side",
        effect: with("B", Component::EX, 3.0 * UM, Law::Play { take_up: 0.2 * std::f64::consts::PI / 180.0 }),
    },
    Case {
        machine: "head-head-ca-moving-table",
        name: "thermal-growth",
        concealed: "growth of Z, 15 µm in an exponential of 20 min",
        effect: with("Z", Component::EZ, 15.0 * UM, Law::Growth { minutes: 20.0 }),
    },
    Case {
        machine: "table-head-ba-horizontal",
        name: "cyclic-error",
        concealed: "screw of X, 2 µm once in 10 mm",
        effect: with("X", Component::EX, 2.0 * UM, Law::Screw { lead_mm: 10.0 }),
    },
    Case {
        machine: "fig-1-1-table-table-ca",
        name: "reversal-spike",
        concealed: "reversal spike of Y, 6 µm gone in 2 mm",
        effect: with("Y", Component::EY, 6.0 * UM, Law::Spike { gone_mm: 2.0 }),
    },
];

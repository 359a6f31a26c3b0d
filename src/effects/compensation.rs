//! The control's own table of location errors applied twice, with the wrong sign or not at all. What the table should hold is not known here.

use super::candidates::none;
use super::contract::{
    DefaultValue, Documented, Driver, Kind, Notable, Parameter, ParameterUnit, Signature, Unseen, no_check,
    plain_measure, single_function,
};
use super::showing_test::{ShowingTest, ShownBy};
use crate::machine::{Component, Outlet, Place};

/// A compensation map that acts `factor` times too much; its sizes are the map.
pub static COMPENSATION: Kind = Kind {
    name: "compensation",
    driver: Driver::Constant,
    formula: "location errors += factor * map",
    size_meaning: "entry of the map",
    cause: "kinematic offsets entered in control and post-processor both, or with the wrong sign",
    remedy: "keep one place of compensation; check the sign with one moved test",
    titles: &[("", "A compensation of {place} acts wrongly ({moving})")],
    measures: None,
    notable: Notable { length: 3.0, angle: 3.0 },
    shown_by: ShownBy { arm: None, rotary: None, other: ShowingTest::BothWays },
    unseen: Unseen::Never,
    unmoved: &[],
    form_error: 0.03,
    needs_runs: false,
    signature: Signature::Given,
    candidates: none,
    candidates_of_poses: none,
    documented: Documented {
        place: "`control`",
        components: "location errors of the map",
        functions: "`factor`",
        parameters: "`factor`: 1 applied twice, −2 sign turned",
        unit: "um, arcsec",
    },
    parameters: &[Parameter::number(
        "factor",
        ParameterUnit::Plain,
        DefaultValue::Number(1.0),
        (-10.0, 10.0),
        "how often the map acts too much: 1 applied twice, -2 sign turned, -1 not applied",
    )],
    check: no_check,
    outlets: |machine, place| match place {
        Place::Control => (0..machine.axes.len())
            .flat_map(|axis| Component::ALL.map(|component| Outlet::Location { axis, component }))
            .collect(),
        _ => Vec::new(),
    },
    measure: plain_measure,
    functions: single_function,
    profiles: |context, effect| {
        let factor = COMPENSATION.number(context, effect, "factor");
        Ok(vec![context.profile(|_, _| factor)])
    },
};

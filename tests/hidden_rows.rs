//! Real rows that no fit has seen are predicted, by what examples/hidden_rows measures for docs/real.md.

#[path = "../examples/hidden_rows/rows.rs"]
mod rows;
#[path = "../examples/hidden_rows/sets.rs"]
#[allow(dead_code, reason = "what experts reached is for the table")]
mod sets;

use crate::shared_data;
use rows::{Hidden, Scored, rms, scored};
use sets::{SETS, Set};

fn set(name: &str) -> &'static Set {
    SETS.iter().find(|set| set.name == name).unwrap()
}

/// The first fourth of a set, predicted from the others: with location errors alone, and with what was found, mm.
fn first_part(set: &Set, data: &std::path::Path) -> Option<(Scored, f64, f64)> {
    let part = scored(&set.session(data)?, &Hidden { part: 0, parts: 4, block: set.block });
    let (geometry, found) = (rms(&part.geometry_mm2), rms(&part.found_mm2));
    println!("{}: {geometry:.3} mm by location errors, {found:.3} with {}", set.name, part.found.join(", "));
    Some((part, geometry, found))
}

#[test]
fn a_positioner_is_predicted_where_it_was_not_measured() {
    // the rows are part of the project
    let (part, geometry, found) = first_part(set("positioner"), "".as_ref()).unwrap();
    assert_eq!(part.readings, 150);
    assert!(part.found_mm2.len() >= 35 && part.found_mm2.len() <= 40, "{}", part.found_mm2.len());
    // an expert who knew what to look for reached 0.278 mm on other rows
    assert!(found < 0.20 && found < 0.6 * geometry, "{found} for {geometry}");
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn a_wheel_at_six_speeds_shows_imbalance_and_a_sensor_of_another_scale() {
    let Some(data) = shared_data::folder("real") else { return };
    let Some((part, geometry, found)) = first_part(set("wheel"), &data) else { panic!("no rows of the wheel") };
    // an expert reached 0.019 to 0.029 mm by twelve harmonics of each sensor and the speed squared
    assert!(found < 0.028 && found < 0.3 * geometry, "{found} for {geometry}");
    for effect in ["imbalance", "sensor-gain"] {
        assert!(part.found.iter().any(|name| name.starts_with(effect)), "{:?}", part.found);
    }
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn a_torso_bends_under_both_of_its_arms() {
    let Some(data) = shared_data::folder("real") else { return };
    let Some((part, geometry, found)) = first_part(set("justin"), &data) else { panic!("no rows of Justin") };
    assert!(found < 3.6 && found < 0.5 * geometry, "{found} for {geometry}");
    assert!(part.found.iter().any(|name| name.starts_with("weight-compliance T3")), "{:?}", part.found);
}

#[test]
#[ignore = "takes 10 to 20 s: runs with --include-ignored, as in .ci/run all"]
fn arms_whose_rows_lie_elsewhere_are_predicted() {
    let Some(data) = shared_data::folder("real") else { return };
    for (name, most_mm) in [("iiwa-november", 0.33), ("jaibot", 1.9)] {
        let Some((part, geometry, found)) = first_part(set(name), &data) else { panic!("no rows of {name}") };
        assert!(found < most_mm && found < 0.8 * geometry, "{name}: {found} for {geometry}");
        let is_load = |name: &String| name.starts_with("load-compliance") || name.starts_with("weight-compliance");
        assert!(part.found.iter().any(is_load), "{name}: {:?}", part.found);
    }
}

//! Signs of errors and numbers for a control in words, as a fitter at the machine needs them. It computes no results.

use nalgebra::Vector3;
use serde::Serialize;

use super::number::shown;
use crate::identify::{AxisLine, CentreReading};
use crate::machine::{Component, ErrorName, Machine};
use crate::plan::PlannedTest;
use crate::session::{Follow, Path};
use crate::units::{ARCSEC_PER_RAD, UM_PER_MM};

const LETTERS: [char; 3] = ['x', 'y', 'z'];

/// What a positive location error means on the machine.
pub fn sign_in_words(machine: &Machine, axis: usize, component: Component) -> String {
    let entry = &machine.axes[axis];
    let (name, axis_name) = (ErrorName::location(component, &entry.name), &entry.name);
    let k = component.direction_index();
    let letter = LETTERS[k];
    if entry.zero_position() == Some(component) {
        return format!(
            "{name} > 0: at the reading 0 what {axis_name} carries stands on the positive side {} {letter}",
            if component.is_angle() { "about" } else { "along" }
        );
    }
    if !component.is_angle() {
        return format!(
            "{name} > 0: the line of {axis_name} lies on the +{letter} side of its nominal place, seen from what carries it"
        );
    }
    let (turned, towards) = (LETTERS[(k + 1) % 3], LETTERS[(k + 2) % 3]);
    let what = match entry.kind {
        crate::machine::AxisKind::Rotary => "the line of",
        crate::machine::AxisKind::Linear => "the motion of",
    };
    // e_k × e_along = ± the third direction: that is where the + end of the line goes
    let lean = entry.coordinate_direction().map_or(String::new(), |along| {
        let sign = if along == (k + 1) % 3 { '+' } else { '-' };
        format!(": its +{} end leans towards {sign}{}", LETTERS[along], LETTERS[3 - k - along])
    });
    format!("{name} > 0: {what} {axis_name} is turned right-handed about {letter} ({turned} towards {towards}){lean}")
}

/// Numbers for a control, one entry per rotary axis.
#[derive(Debug, Clone, Serialize)]
pub struct ControlJson {
    pub axis: String,
    /// The axis belongs to the spindle's side.
    pub is_head: bool,
    /// The rotary axis that carries it.
    pub carried_by: Option<String>,
    /// Where the line stands off its nominal place at the zero position, x y z, and its standard deviation.
    pub shift_um: [f64; 3],
    pub shift_sigma_um: [f64; 3],
    /// The same relative to the line of the carrier: the change of the vector between two rotary axes.
    pub from_carrier_um: [f64; 3],
    pub from_carrier_sigma_um: [f64; 3],
    /// Unit vector of the line.
    pub direction: [f64; 3],
    /// Turn of the line about x y z, and its standard deviation.
    pub tilt_arcsec: [f64; 3],
    pub tilt_sigma_arcsec: [f64; 3],
    /// Readings of the linear axes with the spindle over the line.
    pub centre: Vec<CentreJson>,
    /// The data and not priors fix it.
    pub determined: bool,
    /// The same by component x, y, z of the shift and of the shift from the carrier.
    pub shift_determined: [bool; 3],
    pub from_carrier_determined: [bool; 3],
    /// At least one component of the place is determined and told in words.
    pub told: bool,
    /// In words.
    pub says: String,
}

/// A reading of a linear axis.
#[derive(Debug, Clone, Serialize)]
pub struct CentreJson {
    pub axis: String,
    pub reading_mm: f64,
    pub sigma_mm: f64,
    /// A machine coordinate (G53); else counted from the zero of the session.
    pub machine_coordinate: bool,
}

/// A line as numbers and words for a control.
pub fn control_json(machine: &Machine, line: &AxisLine) -> ControlJson {
    let um = |vector: Vector3<f64>| <[f64; 3]>::from(vector * UM_PER_MM);
    let arcsec = |vector: Vector3<f64>| <[f64; 3]>::from(vector * ARCSEC_PER_RAD);
    let name = |axis: usize| machine.axes[axis].name.clone();
    let centre = |reading: &CentreReading| CentreJson {
        axis: name(reading.axis),
        reading_mm: reading.reading_mm,
        sigma_mm: reading.sigma_mm,
        machine_coordinate: reading.is_machine_coordinate,
    };
    ControlJson {
        axis: name(line.axis),
        is_head: line.is_head,
        carried_by: line.carrier.map(name),
        shift_um: um(line.shift_mm),
        shift_sigma_um: um(line.shift_sigma_mm),
        from_carrier_um: um(line.from_carrier_mm),
        from_carrier_sigma_um: um(line.from_carrier_sigma_mm),
        direction: line.direction.into(),
        tilt_arcsec: arcsec(line.tilt_rad),
        tilt_sigma_arcsec: arcsec(line.tilt_sigma_rad),
        centre: line.centre_at.iter().map(centre).collect(),
        determined: line.determined,
        shift_determined: line.shift_determined,
        from_carrier_determined: line.from_carrier_determined,
        told: is_told(machine, line),
        says: control_in_words(machine, line),
    }
}

/// What to enter for a rotary axis.
pub fn control_in_words(machine: &Machine, line: &AxisLine) -> String {
    let entry = &machine.axes[line.axis];
    let open: Vec<usize> =
        (0..3).filter(|&k| entry.coordinate_direction() != Some(k) && !place_determined(line)[k]).collect();
    // of a line that is known in part the known components are told
    let is_open = (0..3).all(|k| entry.coordinate_direction() == Some(k) || open.contains(&k));
    let told: Vec<usize> =
        (0..3).filter(|k| entry.coordinate_direction() != Some(*k) && (is_open || !open.contains(k))).collect();
    let mut says = match (line.carrier, line.is_head) {
        (None, false) => {
            format!(
                "{}: move the table centre in the control by {}",
                entry.name,
                across(&told, line.shift_mm, line.shift_sigma_mm)
            )
        }
        (Some(carrier), _) => format!(
            "{}: add {} to the vector from {} to {}",
            entry.name,
            across(&told, line.from_carrier_mm, line.from_carrier_sigma_mm),
            machine.axes[carrier].name,
            entry.name
        ),
        (None, true) => format!(
            "{}: its line and all that it carries stand off by {}: a zero shift of the linear axes, no vector of the head",
            entry.name,
            across(&told, line.shift_mm, line.shift_sigma_mm)
        ),
    };
    let is_along_told =
        |reading: &&CentreReading| machine.axes[reading.axis].coordinate_direction().is_some_and(|k| told.contains(&k));
    let centre_at: Vec<&CentreReading> = line.centre_at.iter().filter(is_along_told).collect();
    if let [first, ..] = centre_at.as_slice() {
        let readings: Vec<String> = centre_at
            .iter()
            .map(|reading| format!("{} = {:.4}", machine.axes[reading.axis].name, reading.reading_mm))
            .collect();
        let from = if first.is_machine_coordinate { "machine coordinates" } else { "from the zeros of this session" };
        says.push_str(&format!("; the spindle stands over the line at {} mm ({from})", readings.join(", ")));
    }
    let against = centre_at.iter().filter(|reading| reading.counts_against);
    let against: Vec<String> = against
        .filter_map(|reading| {
            let entry = &machine.axes[reading.axis];
            Some(format!("{} counts against {}", entry.name, LETTERS[entry.coordinate_direction()?]))
        })
        .collect();
    if !against.is_empty() {
        says.push_str(&format!(
            "; {}: a parameter that holds readings takes that part with the opposite sign",
            against.join(", ")
        ));
    }
    match (is_open, open.is_empty()) {
        (true, _) => says.push_str("; NOT determined by these recordings: do not enter it"),
        (_, false) => {
            let letters: Vec<String> = open.iter().map(|&k| LETTERS[k].to_string()).collect();
            says.push_str(&format!("; {} is not determined by these recordings", letters.join(" and ")));
        }
        _ => {}
    }
    says
}

/// Which components of the place that is told the recordings fix.
fn place_determined(line: &AxisLine) -> [bool; 3] {
    if line.carrier.is_some() { line.from_carrier_determined } else { line.shift_determined }
}

/// Whether any component of a line's place is determined.
pub fn is_told(machine: &Machine, line: &AxisLine) -> bool {
    let along = machine.axes[line.axis].coordinate_direction();
    (0..3).any(|k| along != Some(k) && place_determined(line)[k])
}

/// `from park (Z 329, A 0, C 0, X 0, Y 0) C -10 and back, by A -23, Y 0, X 100, Z 0 one after the other; back the same way`.
pub fn approach_in_words(planned: &PlannedTest, machine: &Machine) -> String {
    let stands = |axis: usize, q: f64| {
        let q = (machine.axes[axis].kind.to_file_unit(q) * 1e4).round() / 1e4 + 0.0;
        format!("{} {q}", machine.axes[axis].name)
    };
    let approach = &planned.approach;
    let park: Vec<String> = approach.park_order.iter().map(|&axis| stands(axis, approach.park[axis])).collect();
    let legs: Vec<String> = approach.legs.iter().map(|leg| stands(leg.axis, leg.to)).collect();
    let way = match legs.len() {
        0 => "the run starts there".to_string(),
        1 => format!("by {}, back the same way", legs[0]),
        _ => format!("by {} one after the other, back the same way", legs.join(", ")),
    };
    let aside: Vec<String> = approach.asides().map(|leg| stands(leg.axis, leg.to)).collect();
    let aside = if aside.is_empty() { String::new() } else { format!(" {} and back,", aside.join(", ")) };
    format!("from park ({}){aside} {way}; bar off", park.join(", "))
}

/// What moves in a planned test: `C`, `C with X Y following (tangential)`, `circle in ZX, angle`.
pub fn what_moves(planned: &PlannedTest, machine: &Machine) -> String {
    let name = |axis: usize| machine.axes[axis].name.as_str();
    match &planned.test.path {
        Some(Path::Circle { plane, .. }) => format!("circle in {}{}, angle", name(plane.first), name(plane.second)),
        Some(Path::Sweep { axis, follow, .. }) if *follow != Follow::None => {
            let rows = &planned.run;
            let moves = |k: &usize| *k != *axis && rows.iter().any(|row| (row[*k] - rows[0][*k]).abs() > 1e-6);
            let moving: Vec<&str> = (0..machine.axes.len()).filter(moves).map(name).collect();
            format!("{} with {} following ({})", name(*axis), moving.join(" "), follow.name())
        }
        _ => name(planned.axis).to_string(),
    }
}

/// `x -2.9 ± 3.0 µm, y -52.4 ± 0.1 µm`: what stands across a line, mm.
fn across(told: &[usize], value_mm: Vector3<f64>, sigma_mm: Vector3<f64>) -> String {
    let parts: Vec<String> = told
        .iter()
        .map(|&k| {
            let (value, sigma) = shown(value_mm[k] * UM_PER_MM, sigma_mm[k] * UM_PER_MM);
            format!("{} {value} ± {sigma} µm", LETTERS[k])
        })
        .collect();
    parts.join(", ")
}

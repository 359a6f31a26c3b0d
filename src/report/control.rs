//! Parameters of a control as tables, JSON and files. It decides nothing.

use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::control::{Backlash, CompensationTable, Control, LINUXCNC_ROWS, Module, Number, Parameter, What, Worsening};
use crate::effects::{Signature, is_a};
use crate::machine::{AxisKind, Machine};
use crate::report::wording::table::Table;
use crate::units::{ARCSEC_PER_RAD, UM_PER_MM};
use crate::volume::Figures;

/// What is reported.
pub struct ControlReport<'a> {
    pub machine: &'a Machine,
    pub control: Control,
    /// LinuxCNC's module.
    pub module: Option<&'a Module>,
    pub numbers: &'a [Number],
    pub parameters: &'a [Parameter],
    /// Values that the control holds now, by name.
    pub present: &'a [(String, f64)],
    /// Errors over the volume: as the machine is, when the control holds what it can, and how well the fit knows them.
    pub volume: Option<[Figures; 3]>,
    pub tables: Vec<CompensationTable>,
    /// Lost motion of axes.
    pub backlash: Vec<Backlash>,
    /// Component errors without a table, for nothing says over which travel.
    pub without_travel: Vec<String>,
    /// Location errors that slides have, which no list holds: ISO 230-1 name and angle, rad.
    pub squareness: Vec<(String, f64)>,
    /// Names of the effects that depend on more than the position of their axis.
    pub stays: Vec<String>,
    /// What has to be known before anything is entered, in sentences.
    pub notes: Vec<String>,
}

impl ControlReport<'_> {
    /// Whether there is nothing to enter.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty() && self.tables.is_empty() && self.backlash.is_empty()
    }
}

fn control_name(control: Control) -> &'static str {
    match control {
        Control::LinuxCnc => "LinuxCNC",
        Control::Heidenhain => "Heidenhain",
        Control::Sinumerik => "Sinumerik",
        Control::Fanuc => "Fanuc",
    }
}

/// The new value: the present one with the change, or the one that the machine file gives.
fn new_value(report: &ControlReport, parameter: &Parameter) -> Option<f64> {
    let held = report.present.iter().find(|(name, _)| parameter.is_called(name));
    let present = held.map(|(_, value)| value + parameter.change);
    present.or(parameter.value)
}

/// What the control does not take, in words.
fn not_held(report: &ControlReport) -> Vec<String> {
    let mut list = Vec::new();
    if let Some(module) = report.module {
        list.push(format!("{} cannot hold {}", module.name, module.not_held));
    } else if report.control == Control::Sinumerik {
        list.push(
            "directions of the axes, which V1 and V2 or MD24570 and MD24572 can hold: the vectors change with them"
                .into(),
        );
    } else {
        list.push("directions of the axes are not held as vectors".into());
    }
    if report.numbers.iter().any(|number| number.what == What::ZeroShift) {
        list.push(
            "where the first head axis stands is a zero shift: take the workpiece's zero with this machine".into(),
        );
    }
    let open: Vec<String> = report
        .numbers
        .iter()
        .filter(|number| !number.determined && number.what != What::ZeroShift)
        .map(|number| number_name(report.machine, number))
        .collect();
    if !open.is_empty() {
        list.push(format!("not determined by the recordings: {}", open.join(", ")));
    }
    if !report.squareness.is_empty() {
        let angles = report.squareness.iter().map(|(name, rad)| format!("{name} {:.1} arcsec", rad * ARCSEC_PER_RAD));
        let angles = angles.collect::<Vec<_>>().join(", ");
        list.push(format!("squareness of slides, for which controls have functions of their own: {angles}"));
    }
    if !report.without_travel.is_empty() {
        list.push(format!(
            "tables of {}: the machine file states no range of their axis",
            report.without_travel.join(", ")
        ));
    }
    let stays: Vec<&str> =
        report.stays.iter().filter(|kind| !is_a(kind, Signature::Reversal)).map(String::as_str).collect();
    if !stays.is_empty() {
        list.push(format!("what depends on more than the position of an axis: {}", stays.join(", ")));
    }
    let no_zero = |table: &&CompensationTable| {
        table.is_own
            && report.machine.axes[table.axis].kind == AxisKind::Linear
            && report.machine.machine_zero[table.axis].is_none()
    };
    if report.control == Control::LinuxCnc {
        list.extend(report.tables.iter().filter(no_zero).map(|table| {
            format!(
                "{} as a COMP_FILE: its rows are machine coordinates, and the machine file states no machine_zero of {}",
                table.error, report.machine.axes[table.axis].name
            )
        }));
    }
    let too_fine = |table: &&CompensationTable| table.is_own && table.rows.len() > LINUXCNC_ROWS;
    if report.control == Control::LinuxCnc {
        list.extend(report.tables.iter().filter(too_fine).map(|table| {
            format!(
                "{} waves too fast for the {LINUXCNC_ROWS} rows of a COMP_FILE ({} would be needed); 'compensate' takes it",
                table.error,
                table.rows.len()
            )
        }));
    }
    list
}

fn number_name(machine: &Machine, number: &Number) -> String {
    let axis = &machine.axes[number.axis].name;
    let along = ["x", "y", "z"][number.component];
    match number.what {
        What::TableCentre => format!("centre of {axis} {along}"),
        What::Vector { from } => format!("vector from {} to {axis} {along}", machine.axes[from].name),
        What::ZeroShift => format!("zero shift by {axis} {along}"),
        What::Pivot => format!("vector from {axis} to the spindle ball {along}"),
        What::Direction => format!("turn of {axis} about {along}"),
    }
}

/// What to tell when the parameters make the volume worse: by how much, what stays, what to do.
pub fn worsening_note(worsening: &Worsening) -> String {
    let [now, after] = [worsening.now_mm, worsening.after_mm].map(|mm| mm * UM_PER_MM);
    format!(
        "these parameters make the volume worse: {now:.1} µm of the tool tip now, {after:.1} µm with them (95 % of poses). {} stays, which the present values partly cancel by chance. Take that out first, by its table or with 'compensate', or record the tests that show its cause; enter these parameters with it, not alone",
        worsening.stays
    )
}

/// What to know of parameters along slides (by axis index) that count against the tool's way; `None` where there are none.
pub fn counting_note(control: Control, machine: &Machine, against: &[usize]) -> Option<String> {
    let against: Vec<&str> = against.iter().map(|&axis| machine.axes[axis].name.as_str()).collect();
    let is_said = !against.is_empty() && control != Control::LinuxCnc;
    is_said.then(|| {
        format!(
            "by the machine file a positive command of {} moves the tool in the negative sense over the workpiece: parameters along it are \
             given as the control reads it, with the opposite sign of what 'identify' says. Most controls count it the other way (ISO 841): look \
             which way it goes before anything is entered",
            against.join(" and ")
        )
    })
}

/// As text.
pub fn control_text(report: &ControlReport) -> String {
    let mut text = format!("{}: parameters for {}", report.machine.name, control_name(report.control));
    match report.module {
        Some(module) => {
            let _ = writeln!(text, ", module {}\n", module.name);
        }
        None => text.push_str("\n\n"),
    }
    let mut table = Table::new(&["parameter", "add µm", "± sigma", "new value mm", "what it is"]);
    for parameter in report.parameters {
        table.row(vec![
            parameter.name.clone(),
            format!("{:.2}", parameter.change * UM_PER_MM),
            format!("{:.2}", parameter.sigma * UM_PER_MM),
            new_value(report, parameter).map_or_else(String::new, |value| format!("{value:.5}")),
            parameter.meaning.clone(),
        ]);
    }
    match report.parameters.is_empty() {
        true => text.push_str("  the recordings determine no parameter of this control\n"),
        false => text.push_str(&table.text()),
    }
    if !report.backlash.is_empty() {
        text.push_str(&backlash_text(report));
    }
    let not_held = not_held(report);
    if !not_held.is_empty() {
        text.push_str("\nNot in this list:\n");
        for line in not_held {
            let _ = writeln!(text, "  • {line}");
        }
    }
    let enters_more = !report.backlash.is_empty() || !report.tables.is_empty();
    match &report.volume {
        Some(figures) => text.push_str(&volume_text(figures, enters_more || !report.parameters.is_empty())),
        None => text.push_str("\nHow much of the volume's error stays is not told: travels or the spindle are not stated in the machine file.\n"),
    }
    for note in &report.notes {
        let _ = writeln!(text, "Warning: {note}.");
    }
    let (sure, unsure): (Vec<&Parameter>, Vec<&Parameter>) =
        report.parameters.iter().partition(|one| one.change.abs() > one.sigma);
    if !unsure.is_empty() {
        let names: Vec<&str> = unsure.iter().map(|one| one.name.as_str()).collect();
        let _ = writeln!(text, "Within their own sigma, and better left as they are: {}.", names.join("; "));
    }
    if !sure.is_empty() || enters_more {
        text.push_str("Repeat one test after entering: its circle must have become smaller.\n");
    }
    text
}

/// Errors of the tool tip, now and, where something is entered, with it.
fn volume_text([now, after, unsure]: &[Figures; 3], is_entered: bool) -> String {
    let um = |figures: &Figures| format!("{:.1}", figures.position_mm.p95 * UM_PER_MM);
    let arcsec = |figures: &Figures| format!("{:.1}", figures.direction_rad.p95 * ARCSEC_PER_RAD);
    let (tip, direction) = match is_entered {
        true => (
            format!("{} µm now, {} µm with these parameters", um(now), um(after)),
            format!("{} and {}", arcsec(now), arcsec(after)),
        ),
        false => (format!("{} µm", um(now)), arcsec(now)),
    };
    let stays = if is_entered { " What stays, 'compensate' takes out of programs." } else { "" };
    format!(
        "\nTool tip over the travel, zero taken with the axes at zero, 95 % of poses: {tip}; direction {direction} arcsec.\nThe fit knows the tip to {} µm and its direction to {} arcsec.{stays}\n",
        um(unsure),
        arcsec(unsure)
    )
}

/// Lost motion as a table.
fn backlash_text(report: &ControlReport) -> String {
    let mut table = Table::new(&["parameter", "add", "unit", "of it wind-up"]);
    for one in &report.backlash {
        let (width, unit, take_up) = in_file_unit(report.machine, one);
        table.row(vec![
            one.parameter.clone(),
            format!("{width:+.5}"),
            unit.into(),
            match one.windup_share > 0.0 {
                true => format!("{:.0} %, taken up over {take_up:.3} {unit}", 100.0 * one.windup_share),
                false => "none".into(),
            },
        ]);
    }
    let beside = match report.control {
        Control::LinuxCnc => ", and LinuxCNC ignores BACKLASH where the joint has a COMP_FILE: the files here hold it",
        _ => "",
    };
    format!(
        "\nLost motion, the whole width of it:\n\n{}  A control adds it at once as the axis turns back; wind-up needs its travel{beside}.\n",
        table.text()
    )
}

/// Width, unit and travel of wind-up, mm or deg.
fn in_file_unit(machine: &Machine, one: &Backlash) -> (f64, &'static str, f64) {
    let kind = machine.axes[one.axis].kind;
    let unit = match kind {
        AxisKind::Linear => "mm",
        AxisKind::Rotary => "deg",
    };
    (kind.to_file_unit(one.width), unit, kind.to_file_unit(one.take_up))
}

/// Lost motion as a file, with its name: lines of an INI file for LinuxCNC, else CSV.
pub fn backlash_file(report: &ControlReport) -> (&'static str, String) {
    if report.control == Control::LinuxCnc {
        let mut text =
            format!("# {}: lost motion by the fit, to be added to what each joint has\n", plain(&report.machine.name));
        for one in &report.backlash {
            let (width, unit, _) = in_file_unit(report.machine, one);
            let _ =
                writeln!(text, "# [JOINT_n] of {}, {unit}\nBACKLASH = {width:.6}", report.machine.axes[one.axis].name);
        }
        return ("backlash.ini", text);
    }
    let mut text = String::from("axis,parameter,add,unit\n");
    for one in &report.backlash {
        let (width, unit, _) = in_file_unit(report.machine, one);
        let _ = writeln!(text, "{},\"{}\",{width:.6},{unit}", report.machine.axes[one.axis].name, one.parameter);
    }
    ("backlash.csv", text)
}

/// As JSON.
pub fn control_json(report: &ControlReport) -> Value {
    let figures = |figures: &Figures| {
        json!({
            "position_p95_um": figures.position_mm.p95 * UM_PER_MM,
            "position_largest_um": figures.position_mm.largest * UM_PER_MM,
            "direction_p95_arcsec": figures.direction_rad.p95 * ARCSEC_PER_RAD,
        })
    };
    let parameters: Vec<Value> = report
        .parameters
        .iter()
        .map(|one| {
            json!({
                "name": one.name,
                "meaning": one.meaning,
                "add_um": one.change * UM_PER_MM,
                "sigma_um": one.sigma * UM_PER_MM,
                "new_mm": new_value(report, one),
            })
        })
        .collect();
    let numbers: Vec<Value> = report
        .numbers
        .iter()
        .map(|number| {
            let is_angle = number.what == What::Direction;
            let factor = if is_angle { ARCSEC_PER_RAD } else { UM_PER_MM };
            json!({
                "what": number_name(report.machine, number),
                "value": number.change * factor,
                "sigma": number.sigma * factor,
                "unit": if is_angle { "arcsec" } else { "um" },
                "determined": number.determined,
            })
        })
        .collect();
    let backlash: Vec<Value> = report
        .backlash
        .iter()
        .map(|one| {
            let (add, unit, take_up) = in_file_unit(report.machine, one);
            json!({
                "axis": report.machine.axes[one.axis].name,
                "parameter": one.parameter,
                "add": add,
                "unit": unit,
                "windup_share": one.windup_share,
                "take_up": take_up,
            })
        })
        .collect();
    json!({
        "machine": report.machine.name,
        "control": control_name(report.control),
        "module": report.module.map(|module| module.name),
        "parameters": parameters,
        "numbers": numbers,
        "backlash": backlash,
        "not_held": not_held(report),
        "volume_now": report.volume.as_ref().map(|[now, ..]| figures(now)),
        "volume_after": report.volume.as_ref().map(|[_, after, _]| figures(after)),
        "volume_known_to": report.volume.as_ref().map(|[.., unsure]| figures(unsure)),
        "tables": report.tables.iter().map(|table| table.error.clone()).collect::<Vec<_>>(),
    })
}

/// The change list as CSV.
pub fn parameters_csv(report: &ControlReport) -> String {
    let mut text = String::from("parameter,add_mm,sigma_mm,new_mm,meaning\n");
    for one in report.parameters {
        let new = new_value(report, one).map_or_else(String::new, |value| format!("{value:.6}"));
        let _ = writeln!(text, "\"{}\",{:.6},{:.6},{new},\"{}\"", one.name, one.change, one.sigma, one.meaning);
    }
    text
}

/// Lines of a HAL file; pins whose whole value is not known are comments. `None` for other controls.
pub fn parameters_hal(report: &ControlReport) -> Option<String> {
    let module = report.module?;
    let mut text = format!("# {}: pins of {} by the fit, mm\n", plain(&report.machine.name), module.name);
    for one in report.parameters {
        let _ = match new_value(report, one) {
            Some(value) => writeln!(text, "setp {} {value:.6}", one.name),
            None => writeln!(text, "# add {:.6} to {} ({})", one.change, one.name, one.meaning),
        };
    }
    for (pin, value) in &module.pins {
        let full = format!("{}.{pin}", module.name);
        if *pin == "conventional-directions" {
            let _ = writeln!(text, "setp {full} {value}");
        } else if report.parameters.iter().all(|one| one.name != full) && *pin != "z-offset" {
            let _ = writeln!(text, "# {full} stays: the recordings do not determine it");
        }
    }
    Some(text)
}

/// One line of letters that no reader of the file obeys.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

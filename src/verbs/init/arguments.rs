//! Options of `fiveaxis init`, and what is read of their text.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};
use fiveaxis::template::{Inclined, Plane, TableSize};

use crate::verbs::Refusal;
use crate::verbs::options::directions::DirectionsName;

/// Arguments of `init`.
#[derive(Args)]
#[command(
    after_help = "Example: fiveaxis init mill.yaml --code \"[wCAXbYZt]\" --travels 650,520,475 --nose-to-table 110..585 --table 320 --tilt-above-table -60 --range A=-120..30 --directions iso841\nWhat is missing it asks for on a terminal, and asks again after a wrong answer."
)]
pub struct Arguments {
    /// Machine file to write, e.g. mill.yaml
    pub(super) file: PathBuf,
    /// What carries what, from workpiece to tool through the bed b, e.g. "[wCAXbYZt]"
    #[arg(long, conflicts_with = "kind")]
    pub(super) code: Option<String>,
    /// A common code in place of --code
    #[arg(long, value_enum)]
    pub(super) kind: Option<Kind>,
    /// Name of the machine
    #[arg(long)]
    pub(super) name: Option<String>,
    /// Travels of X, Y and Z, mm
    #[arg(long, value_name = "X,Y,Z")]
    pub(super) travels: Option<String>,
    /// Smallest and largest distance between spindle nose and table top, mm
    #[arg(long, value_name = "FROM..TO")]
    pub(super) nose_to_table: Option<String>,
    /// Table, mm: diameter, or width x depth (along X and Y)
    #[arg(long, value_name = "320 or 500x400")]
    pub(super) table: Option<String>,
    /// The rotary axis that is inclined, as in 45 deg heads and tables: deg from the vertical in the plane YZ or ZX (that of its letter where left out), positive with its upper end towards +y or +x
    #[arg(long, value_name = "AXIS=ANGLE[,PLANE]")]
    pub(super) inclined: Option<String>,
    /// Range of a rotary axis, deg (repeatable); not given, ±360 for C, ±100 for A and B and -5..185 for an inclined axis are assumed, and the file says so
    #[arg(long, value_name = "AXIS=FROM..TO", allow_hyphen_values = true)]
    pub(super) range: Vec<String>,
    /// Tilting axis of the table above the table top, mm; below is negative; of an inclined axis where it crosses the vertical
    #[arg(long, allow_negative_numbers = true)]
    pub(super) tilt_above_table: Option<f64>,
    /// From the spindle nose up to the axis about which the head tilts, mm; to an inclined one where it crosses the spindle's line
    #[arg(long, allow_negative_numbers = true)]
    pub(super) pivot_to_nose: Option<f64>,
    /// Diameter of the spindle housing, mm
    #[arg(long, default_value_t = 140.0, allow_negative_numbers = true)]
    pub(super) housing: f64,
    /// An angle plate beside the table, for the tilting axis of a head
    #[arg(long)]
    pub(super) angle_plate: bool,
    /// Sense of the axes: what + does; with --urdf carried, as the description counts, unless given
    #[arg(long, value_enum)]
    pub(super) directions: Option<DirectionsName>,
    /// A robot description (URDF) in place of a data sheet: its axes, ranges and collision geometry
    #[arg(long, value_name = "FILE", conflicts_with_all = ["code", "kind", "travels", "nose_to_table", "range", "inclined", "tilt_above_table", "pivot_to_nose", "angle_plate"])]
    pub(super) urdf: Option<PathBuf>,
    /// URDF: the link that is the bed (default: the root link)
    #[arg(long, requires = "urdf")]
    pub(super) root_link: Option<String>,
    /// URDF: the link that carries the pivot (default: found by name)
    #[arg(long, requires = "urdf")]
    pub(super) workpiece_link: Option<String>,
    /// URDF: the link that carries the spindle ball, its z along the spindle (default: found by name)
    #[arg(long, requires = "urdf")]
    pub(super) tool_link: Option<String>,
    /// Replace a file of that name that fiveaxis did not write, or that was edited
    #[arg(long)]
    pub(super) force: bool,
    /// Print JSON
    #[arg(long)]
    pub(super) json: bool,
}

/// Where the rotary axes are.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Kind {
    /// Both at the table: [wCAYbXZt]
    TableTable,
    /// C at the table, B at the head: [wCXbYZBt]
    TableHead,
    /// Both at the head: [wXbYZCAt]
    HeadHead,
}

impl Kind {
    /// The words of the option, each with its kind.
    pub(super) fn words() -> Vec<(String, Kind)> {
        let named = Kind::value_variants().iter().filter_map(|kind| Some((kind.to_possible_value()?, *kind)));
        named.map(|(word, kind)| (word.get_name().to_string(), kind)).collect()
    }

    pub(super) fn code(self) -> &'static str {
        match self {
            Kind::TableTable => "[wCAYbXZt]",
            Kind::TableHead => "[wCXbYZBt]",
            Kind::HeadHead => "[wXbYZCAt]",
        }
    }
}

pub(super) fn table_size(text: &str) -> Result<TableSize, Refusal> {
    match text.split_once(['x', 'X', '×']) {
        Some((width, depth)) => {
            Ok(TableSize::Rectangle { width: number(width, "--table")?, depth: number(depth, "--table")? })
        }
        None => Ok(TableSize::Disc { diameter: number(text, "--table")? }),
    }
}

pub(super) fn number(text: &str, option: &str) -> Result<f64, Refusal> {
    let value = f64::from_str(text.trim()).ok().filter(|value| value.is_finite());
    value.ok_or_else(|| format!("{option}: '{}' is no number", text.trim()).into())
}

/// Three numbers with commas between.
pub(super) fn three(text: &str, option: &str) -> Result<[f64; 3], Refusal> {
    let found = text.split(',').map(|part| number(part, option)).collect::<Result<Vec<f64>, _>>()?;
    let &[x, y, z] = found.as_slice() else {
        return Err(format!("{option} has {} numbers; three are wanted, for X, Y and Z in mm", found.len()).into());
    };
    Ok([x, y, z])
}

/// `FROM..TO`, the lower end first.
pub(super) fn range(text: &str, option: &str) -> Result<(f64, f64), Refusal> {
    let (from, to) = text
        .split_once("..")
        .ok_or_else(|| format!("{option}: '{text}' is no range; write FROM..TO, e.g. 110..585"))?;
    let (from, to) = (number(from, option)?, number(to, option)?);
    if from >= to {
        return Err(format!("{option}: {from}..{to} runs backwards; the lower end stands first").into());
    }
    Ok((from, to))
}

/// `AXIS=FROM..TO` of a rotary axis, deg.
pub(super) fn named_range(text: &str) -> Result<(String, (f64, f64)), Refusal> {
    let (name, ends) = text
        .split_once('=')
        .ok_or_else(|| format!("--range: '{text}' is not understood; write AXIS=FROM..TO, e.g. A=-120..30"))?;
    let name = name.trim();
    Ok((name.to_string(), range_of(name, ends)?))
}

/// `AXIS=ANGLE` or `AXIS=ANGLE,PLANE`.
pub(super) fn inclined(text: &str) -> Result<Inclined, Refusal> {
    let (name, rest) = text.split_once('=').ok_or_else(|| {
        format!("--inclined: '{text}' is not understood; write AXIS=ANGLE or AXIS=ANGLE,PLANE, e.g. B=45,YZ")
    })?;
    let axis = name.trim().to_string();
    let (angle, plane) = match rest.split_once(',') {
        Some((angle, named)) => (angle, plane(named)?),
        None => (rest, Plane::of_letter(&axis)),
    };
    Ok(Inclined { angle_deg: number(angle, "--inclined")?, axis, plane })
}

/// An upright plane by its letters.
pub(super) fn plane(text: &str) -> Result<Plane, Refusal> {
    let named = text.trim();
    let is_it = |plane: &Plane| {
        let backwards: String = plane.name().chars().rev().collect();
        plane.name().eq_ignore_ascii_case(named) || backwards.eq_ignore_ascii_case(named)
    };
    Plane::ALL.into_iter().find(is_it).ok_or_else(|| {
        format!("--inclined: the plane is '{named}'; allowed are YZ and ZX, which hold the vertical spindle").into()
    })
}

/// Width of a rotary axis's range at least, deg: a turn in radians is narrower.
const LEAST_RANGE_DEG: f64 = 10.0;

/// `FROM..TO` of a rotary axis, deg.
pub(super) fn range_of(name: &str, ends: &str) -> Result<(f64, f64), Refusal> {
    let (from, to) = range(ends, "--range")?;
    if from < -3600.0 || to > 3600.0 || from > 0.0 || to < 0.0 {
        return Err(format!("--range: {name}={from}..{to} deg; a range holds 0 and lies within -3600..3600").into());
    }
    if to - from < LEAST_RANGE_DEG {
        return Err(format!(
            "--range: {name}={from}..{to} is {:.3} deg wide; a rotary axis turns by {LEAST_RANGE_DEG} deg at least, and ranges are in degrees (were these radians, they would be {:.0}..{:.0})",
            to - from,
            from.to_degrees(),
            to.to_degrees()
        )
        .into());
    }
    Ok((from, to))
}

//! One axis: its kind, line, range and error values; the motion itself is the chain's.

use nalgebra::Vector3;

use super::component::ComponentError;
use super::error_name::Component;

/// How an axis moves what it carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisKind {
    /// Slides along its direction; positions in mm.
    Linear,
    /// Turns about its direction through its origin, right-handed; positions in rad inside the library.
    Rotary,
}

impl AxisKind {
    /// Unit of positions in files and output.
    pub fn position_unit(self) -> &'static str {
        match self {
            AxisKind::Linear => "mm",
            AxisKind::Rotary => "deg",
        }
    }

    /// A position in file units (mm or degrees) as held inside the library (mm or rad).
    pub fn from_file_unit(self, value: f64) -> f64 {
        match self {
            AxisKind::Linear => value,
            AxisKind::Rotary => value.to_radians(),
        }
    }

    /// A position held inside the library (mm or rad) in file units (mm or degrees).
    pub fn to_file_unit(self, value: f64) -> f64 {
        match self {
            AxisKind::Linear => value,
            AxisKind::Rotary => value.to_degrees(),
        }
    }
}

/// Kind and direction that a letter implies: X, Y, Z and U, V, W slide, A, B, C turn about them.
pub fn letter_axis(name: &str) -> Option<(AxisKind, Vector3<f64>)> {
    let kind = match name {
        "X" | "Y" | "Z" | "U" | "V" | "W" => AxisKind::Linear,
        "A" | "B" | "C" => AxisKind::Rotary,
        _ => return None,
    };
    let direction = match name {
        "X" | "U" | "A" => Vector3::x(),
        "Y" | "V" | "B" => Vector3::y(),
        _ => Vector3::z(),
    };
    Some((kind, direction))
}

/// One axis of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Name: a letter, or any word for machines without letters.
    pub name: String,
    /// Linear or rotary.
    pub kind: AxisKind,
    /// Unit vector of the motion in R with all axes at zero.
    pub direction: Vector3<f64>,
    /// A point on the axis line in R with all axes at zero, mm; position errors are stated there.
    pub origin: Vector3<f64>,
    /// Travel, lower and upper end, mm or rad.
    pub range: Option<(f64, f64)>,
    /// The control's positive sense is opposite to what the machine's `directions` say.
    pub reversed: bool,
    /// Location errors EX0 EY0 EZ0 (mm) EA0 EB0 EC0 (rad) as known in the machine file.
    pub location_errors: [f64; 6],
    /// Component errors: functions of the axis's own position.
    pub component_errors: Vec<ComponentError>,
}

/// Components of a direction below this are taken as zero when slots are chosen.
const ALONG_COORDINATE: f64 = 1e-9;

impl Axis {
    /// Zero, or the end of the travel that is nearest to it, mm or rad.
    pub fn near_zero(&self) -> f64 {
        self.range.map_or(0.0, |(low, high)| 0f64.clamp(low, high))
    }

    /// Coordinate direction (0, 1, 2) that the axis runs along, `None` when it is inclined.
    pub fn coordinate_direction(&self) -> Option<usize> {
        (0..3).find(|&k| (self.direction[k].abs() - 1.0).abs() < ALONG_COORDINATE)
    }

    /// Coordinates (0, 1, 2) along which a shift moves the line: all but that along which it runs.
    pub fn across(&self) -> impl Iterator<Item = usize> + use<> {
        let along = self.coordinate_direction();
        (0..3).filter(move |&k| along != Some(k))
    }

    /// Components of the location error that an axis of this kind and direction has, zero position left out.
    ///
    /// A rotary axis along a coordinate direction has two position and two orientation errors, a linear one
    /// two orientation errors; an inclined axis has all six (rotary) or the three orientation errors (linear).
    pub fn slots(&self) -> Vec<Component> {
        let along = self.coordinate_direction();
        Component::ALL
            .into_iter()
            .filter(|component| {
                let own = along == Some(component.direction_index());
                match self.kind {
                    AxisKind::Rotary => !own,
                    AxisKind::Linear => component.is_angle() && !own,
                }
            })
            .collect()
    }

    /// Component of the zero position: `EC0` for a C axis, `EX0` for an X axis; `None` when inclined.
    pub fn zero_position(&self) -> Option<Component> {
        self.coordinate_direction().map(|k| match self.kind {
            AxisKind::Linear => Component::ALL[k],
            AxisKind::Rotary => Component::ALL[k + 3],
        })
    }

    /// Component of the axis's own motion: ECC of a C axis, EXX of an X axis. For an inclined axis the
    /// coordinate direction nearest to it.
    pub fn own_component(&self) -> Component {
        let nearest = (0..3).max_by(|&a, &b| self.direction[a].abs().total_cmp(&self.direction[b].abs())).unwrap_or(0);
        match self.kind {
            AxisKind::Linear => Component::ALL[nearest],
            AxisKind::Rotary => Component::ALL[nearest + 3],
        }
    }
}

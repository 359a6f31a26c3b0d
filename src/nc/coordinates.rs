//! What the positions of a program count from: machine coordinates, or work coordinates with the machine file's zero.

use crate::machine::Machine;

/// What positions count from.
#[derive(Debug, Clone, PartialEq)]
pub enum Coordinates {
    /// Machine coordinates; offsets from the machine file's zero by axis, mm or deg.
    Machine(Vec<f64>),
    /// Work coordinates with zero at the machine file's zero.
    Work,
}

impl Coordinates {
    /// Machine coordinates where `machine_zero` is known for every axis.
    pub fn of(machine: &Machine) -> Coordinates {
        machine_offsets(machine).map_or(Coordinates::Work, Coordinates::Machine)
    }

    /// True of machine coordinates.
    pub(super) fn is_machine(&self) -> bool {
        matches!(self, Coordinates::Machine(_))
    }

    /// What the control reads at a position held in mm or rad, mm or deg.
    pub fn reading(&self, machine: &Machine, axis: usize, position: f64) -> f64 {
        machine.axes[axis].kind.to_file_unit(position) + self.offset(axis)
    }

    /// What is added to an axis's position, mm or deg.
    pub(super) fn offset(&self, axis: usize) -> f64 {
        match self {
            Coordinates::Machine(offsets) => offsets[axis],
            Coordinates::Work => 0.0,
        }
    }
}

/// Positions offset from the machine file's zero to what the control reads, by axis; `None` in work coordinates.
pub fn machine_offsets(machine: &Machine) -> Option<Vec<f64>> {
    machine.machine_zero.iter().copied().collect()
}

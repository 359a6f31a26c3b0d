//! The quantities with respect to which lengths are differentiated; the derivatives are in `columns`.

/// A quantity with respect to which a length is differentiated. Axes by index, components EX EY EZ EA EB EC.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Column {
    /// Location error of an axis: mm/mm or mm/rad.
    Location { axis: usize, component: usize },
    /// Component error of the moment, at value zero: mm/mm or mm/rad.
    Motion { axis: usize, component: usize },
    /// Axis position: mm/mm or mm/rad.
    Position { axis: usize },
    /// x, y or z of the pivot ball on its link.
    Pivot(usize),
    /// x, y or z of the spindle ball on its link.
    Spindle(usize),
    /// Spindle ball against a coordinate: its placement error in a spindle indexed by 180°.
    SpindleReversed(usize),
}

//! Shapes of a candidate: judged, refined, averaged, and the courses that they take. It chooses among no causes.

pub(crate) mod judged_shape;
pub(crate) mod shape_average;
pub(crate) mod shape_fit;
pub(crate) mod trajectory;
pub(crate) mod vibration_shape;

//! Machine files: chain, axes, effects, solids. Robots are read in `urdf`.

pub(crate) mod axis;
pub(crate) mod bodies;
mod carried;
pub(crate) mod component_form;
pub(crate) mod effects;
pub(crate) mod linear_axes;
pub(crate) mod machine;
mod spindle;

//! Selected effects as findings: size, place, probability, rivals and the test that would tell them apart.

pub(crate) mod finding;
pub(crate) mod forming;
pub(crate) mod grouping;
pub(crate) mod next_test;
pub(crate) mod proposals;
pub(crate) mod size;
pub(crate) mod standing;
pub(crate) mod vibration_size;

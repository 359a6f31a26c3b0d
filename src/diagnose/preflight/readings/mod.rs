//! Sessions whose readings were changed between gauge and file: scaled, zeroed, put in another order, without their mean or trend. Which of it was done is for others to judge.

pub(crate) mod columns;
pub(crate) mod factors;
pub(crate) mod figures;
pub(crate) mod order;
pub(crate) mod processed;
pub(crate) mod scaled;
pub(crate) mod steps;
pub(crate) mod taken_off;
pub(crate) mod unsigned;

//! What a plan is made from, and what its candidates tell and cost. Nothing is chosen.
//!
//! | file | question |
//! |---|---|
//! | `settings`, `method` | what is a plan asked for? |
//! | `plan_context` | what is it made from? |
//! | `finer`, `added_setups` | which places and setups lie between those that every plan begins with? |
//! | `choice` | what is a choice, and what does it reach? |
//! | `evaluation` | what does a test tell and cost, which of two choices is better? |
//! | `clearing` | is a setup clear, and is there a clear way to it? |
//! | `observing` | what do setups within reach show of each error, whatever stands in the way? |
//! | `setting_out` | how does all this come from what is asked for? |
//! | `error` | why was no plan made? |

pub(crate) mod added_setups;
pub(crate) mod choice;
pub(crate) mod clearing;
pub(crate) mod error;
pub(crate) mod evaluation;
pub(crate) mod finer;
pub(crate) mod method;
pub(crate) mod observing;
pub(crate) mod plan_context;
pub(crate) mod setting_out;
pub(crate) mod settings;

//! Which tests are chosen.
//!
//! | file | question |
//! |---|---|
//! | `under_way` | what is taken by now? |
//! | `circles` | with which circles does a plan begin? |
//! | `pairs` | which two tell together what neither tells alone? |
//! | `greedy` | which tests, one by one? |
//! | `one_pivot` | which tests, all from one pivot setup? |
//! | `free_choice` | which of both? |
//! | `part` | what is the cheapest part of a choice that is as good? |
//! | `refine` | what do places and setups between save of a choice? |
//! | `searches` | which goals are searched for, and which choice is kept? |
//! | `indexed` | which tests pay when the spindle is indexed by 180°? |
//! | `method_tests` | the thesis's chapters 4 to 7 as choices from the same solver |

pub(crate) mod circles;
pub(crate) mod free_choice;
pub(crate) mod greedy;
pub(crate) mod indexed;
pub(crate) mod method_tests;
pub(crate) mod one_pivot;
pub(crate) mod pairs;
pub(crate) mod part;
pub(crate) mod refine;
pub(crate) mod searches;
pub(crate) mod under_way;

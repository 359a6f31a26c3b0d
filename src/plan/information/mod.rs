//! What tests tell of the wanted errors, to first order. It knows no candidates.
//!
//! | file | question |
//! |---|---|
//! | `uncertainty` | which spreads and which noise are taken? |
//! | `block` | what does one test tell, given setup spreads and linear-axis uncertainty? |
//! | `unknowns` | which errors are wanted, and how do rows of a test follow from its setup? |
//! | `posterior` | what is known after some tests? |
//! | `fitted` | what would a fit of their recordings say? |
//! | `observability` | what can lengths show at all? |
//! | `hashing` | how setup quantities are looked up |

pub(crate) mod block;
pub(crate) mod fitted;
pub(crate) mod hashing;
pub(crate) mod observability;
pub(crate) mod posterior;
pub(crate) mod uncertainty;
pub(crate) mod unknowns;

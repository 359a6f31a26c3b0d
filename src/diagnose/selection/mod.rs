//! Which few effects the evidence demands, of all that the catalogue holds. No words, no proof.

pub(crate) mod acceptance;
pub(crate) mod exchange;
pub(crate) mod forward_selection;
mod free_curves;
pub(crate) mod hidden_outliers;
pub(crate) mod joint_fit;
pub(crate) mod limits;
pub(crate) mod naming;
pub(crate) mod pose_search;
pub(crate) mod ranking;
pub(crate) mod screening;
pub(crate) mod search;
pub(crate) mod selected;
pub(crate) mod shapes;
pub(crate) mod two_resolutions;
pub(crate) mod weights;

//! The options of `plan`. What they ask for is read in `settings`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::verbs::options::directions::DirectionsName;

/// Arguments of `plan`.
#[derive(Args)]
#[command(after_help = "Example: fiveaxis plan machines/hermle-c600u.yaml --out plan")]
pub struct Arguments {
    /// Machine file with bodies, mounts and spindle
    pub(crate) machine: PathBuf,
    /// Kit file; the common 100 mm bar with extensions unless given
    #[arg(long)]
    pub(crate) kit: Option<PathBuf>,
    /// Uncertainties to reach, positions and orientations, e.g. 4um,4arcsec
    #[arg(long, value_name = "LENGTH,ANGLE", allow_hyphen_values = true, conflicts_with = "minutes")]
    pub(crate) sigma: Option<String>,
    /// Best plan in this time
    #[arg(long, allow_negative_numbers = true, conflicts_with = "method")]
    pub(crate) minutes: Option<f64>,
    /// Least clearance of every sweep, mm
    #[arg(long, default_value_t = 5.0, allow_negative_numbers = true)]
    pub(crate) margin: f64,
    /// Feed of the moving ball, mm/min
    #[arg(long, default_value_t = 500.0, allow_negative_numbers = true)]
    pub(crate) feed: f64,
    /// Axis region kept out of use, e.g. X=-50..80 (repeatable)
    #[arg(long, value_name = "AXIS=FROM..TO", allow_hyphen_values = true)]
    pub(crate) avoid: Vec<String>,
    /// A method of the thesis in place of the free choice
    #[arg(long, value_enum)]
    pub(crate) method: Option<MethodName>,
    /// Most pivot setups; 1 looks for the one place that does it all
    #[arg(long, value_name = "COUNT", conflicts_with = "method", value_parser = clap::value_parser!(u8).range(1..=20))]
    pub(crate) pivots: Option<u8>,
    /// Ways in which linear axes may follow a rotary axis, or none
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        default_value = "radial,tangential,axial",
        conflicts_with = "method"
    )]
    pub(crate) follow: Vec<FollowName>,
    /// Planar circles too: the squareness of the linear axes is wanted as well
    #[arg(long, conflicts_with = "method")]
    pub(crate) circles: bool,
    /// Run tests again with the spindle indexed by 180°, so that the spindle ball's own placement leaves the positions
    #[arg(long)]
    pub(crate) index_spindle: bool,
    /// The pivot length is wanted too: tests that show the vector from the last head axis to the spindle
    #[arg(long, conflicts_with_all = ["method", "index_spindle"])]
    pub(crate) pivot_length: bool,
    /// Write programs without the short moves along the bar that mark the runs in a capture
    #[arg(long)]
    pub(crate) no_marks: bool,
    /// How the bars' zeros will be set: a free one leaves out what only absolute lengths tell
    #[arg(long, value_enum, default_value_t = ZeroName::Calibrated)]
    pub(crate) zero: ZeroName,
    /// Sense of the axes where the machine file does not state it
    #[arg(long, value_enum)]
    pub(crate) directions: Option<DirectionsName>,
    /// Folder for the session file, setup sheet and NC programs
    #[arg(long)]
    pub(crate) out: Option<PathBuf>,
    /// JSON on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum MethodName {
    Chapter4,
    Chapter5,
    Chapter6,
    Chapter7,
}

#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum ZeroName {
    /// On a calibrator
    Calibrated,
    /// By hand: one unknown offset for every bar
    Free,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
pub(crate) enum FollowName {
    None,
    Radial,
    Tangential,
    Axial,
}

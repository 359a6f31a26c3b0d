//! One test as a session file writes it. What its keys mean is read in `test`, `test_path` and `parts`.

use std::collections::BTreeMap;

use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TestFile {
    pub(crate) name: String,
    pub(crate) recording: Option<String>,
    #[serde(default)]
    pub(crate) started_at: f64,
    pub(crate) bar_length: Option<f64>,
    pub(crate) bar_setup: Option<String>,
    pub(crate) zero: Option<String>,
    pub(crate) bar_error: Option<serde_yaml::Value>,
    pub(crate) pivot: Option<BallFile>,
    pub(crate) spindle_ball: Option<BallFile>,
    pub(crate) readings: Option<String>,
    pub(crate) instrument: Option<FrameFile>,
    pub(crate) socket: Option<FrameFile>,
    pub(crate) target: Option<FrameFile>,
    #[serde(default)]
    pub(crate) columns: BTreeMap<String, String>,
    #[serde(default)]
    pub(crate) positions: BTreeMap<String, f64>,
    #[serde(default)]
    pub(crate) approached: BTreeMap<String, f64>,
    pub(crate) feed: Option<f64>,
    pub(crate) overshoot: Option<f64>,
    pub(crate) marks: Option<MarksFile>,
    pub(crate) sweep: Option<SweepFile>,
    pub(crate) circle: Option<CircleFile>,
}

/// Moves along the bar before and after each direction, with their rests.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MarksFile {
    #[serde(rename = "move")]
    pub(crate) move_mm: f64,
    pub(crate) feed: f64,
    pub(crate) hold: f64,
    pub(crate) rest: f64,
    pub(crate) gap: f64,
    pub(crate) seen: Option<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BallFile {
    pub(crate) link: String,
    pub(crate) at: [f64; 3],
    pub(crate) setup: Option<String>,
    pub(crate) spread: Option<serde_yaml::Value>,
    pub(crate) indexed_about: Option<String>,
}

/// Instrument, socket or target of a test.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FrameFile {
    pub(crate) link: String,
    pub(crate) at: Option<[f64; 3]>,
    /// Its axes as a unit quaternion, w first.
    pub(crate) quaternion: Option<[f64; 4]>,
    /// The direction of a displacement.
    pub(crate) direction: Option<[f64; 3]>,
    pub(crate) setup: Option<String>,
    pub(crate) spread: Option<serde_yaml::Value>,
    pub(crate) turn_spread: Option<serde_yaml::Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SweepFile {
    pub(crate) axis: String,
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) step: Option<f64>,
    #[serde(default)]
    pub(crate) follow: FollowFile,
    pub(crate) length: Option<f64>,
}

#[derive(Deserialize, Default, Clone, Copy)]
#[serde(rename_all = "lowercase")]
pub(crate) enum FollowFile {
    #[default]
    None,
    Radial,
    Tangential,
    Axial,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CircleFile {
    pub(crate) plane: String,
    pub(crate) radius: f64,
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) step: Option<f64>,
}

//! One test as a session file writes it. What its keys mean is read in `test`, `test_path` and `parts`.

use std::collections::BTreeMap;

use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TestFile {
    pub(super) name: String,
    pub(super) recording: Option<String>,
    #[serde(default)]
    pub(super) started_at: f64,
    pub(super) bar_length: Option<f64>,
    pub(super) bar_setup: Option<String>,
    pub(super) zero: Option<String>,
    pub(super) bar_error: Option<serde_yaml::Value>,
    pub(super) pivot: Option<BallFile>,
    pub(super) spindle_ball: Option<BallFile>,
    pub(super) readings: Option<String>,
    pub(super) instrument: Option<FrameFile>,
    pub(super) socket: Option<FrameFile>,
    pub(super) target: Option<FrameFile>,
    #[serde(default)]
    pub(super) columns: BTreeMap<String, String>,
    #[serde(default)]
    pub(super) positions: BTreeMap<String, f64>,
    pub(super) feed: Option<f64>,
    pub(super) overshoot: Option<f64>,
    pub(super) sweep: Option<SweepFile>,
    pub(super) circle: Option<CircleFile>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BallFile {
    pub(super) link: String,
    pub(super) at: [f64; 3],
    pub(super) setup: Option<String>,
    pub(super) spread: Option<serde_yaml::Value>,
    pub(super) indexed_about: Option<String>,
}

/// Instrument, socket or target of a test.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameFile {
    pub(super) link: String,
    pub(super) at: Option<[f64; 3]>,
    /// Its axes as a unit quaternion, w first.
    pub(super) quaternion: Option<[f64; 4]>,
    /// The direction of a displacement.
    pub(super) direction: Option<[f64; 3]>,
    pub(super) setup: Option<String>,
    pub(super) spread: Option<serde_yaml::Value>,
    pub(super) turn_spread: Option<serde_yaml::Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SweepFile {
    pub(super) axis: String,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) step: Option<f64>,
    #[serde(default)]
    pub(super) follow: FollowFile,
}

#[derive(Deserialize, Default, Clone, Copy)]
#[serde(rename_all = "lowercase")]
pub(super) enum FollowFile {
    #[default]
    None,
    Radial,
    Tangential,
    Axial,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CircleFile {
    pub(super) plane: String,
    pub(super) radius: f64,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) step: Option<f64>,
}

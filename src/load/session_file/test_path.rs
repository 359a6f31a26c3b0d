//! Planned paths of a session file: sweeps and circles. Positions along them are computed in the `session` room.

use super::test_file::{FollowFile, TestFile};
use super::test_reader::TestReader;
use crate::load::checked_text::document::Step;
use crate::load::checked_text::limits::ROWS;
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::quantity::finite;
use crate::load::range::outside_range;
use crate::load::rows::STROKE_LIMIT_MM;
use crate::machine::AxisKind;
use crate::session::{CirclePlane, Follow, Path as TestPath};

impl TestReader<'_> {
    /// The path of a test; `None` when the recording says where the axes were.
    pub(crate) fn path(&self, index: usize, raw: &TestFile) -> Result<Option<TestPath>, LoadError> {
        let at = |key| [Step::Key("tests"), Step::Index(index), Step::Key(key)];
        match (&raw.sweep, &raw.circle) {
            (Some(_), Some(_)) => Err(self.document.refuse(&at("circle"), "both sweep and circle are given; keep one")),
            (None, None) => Ok(None),
            (Some(sweep), None) => {
                let axis = self.axis(&at("sweep"), &sweep.axis)?;
                let step = self.step(&at("sweep"), sweep.from, sweep.to, sweep.step)?;
                for end in [sweep.from, sweep.to] {
                    let value = self.machine.axes[axis].kind.from_file_unit(end);
                    if let Some(message) = outside_range(self.machine, axis, value) {
                        return Err(self.document.refuse(&at("sweep"), message));
                    }
                }
                let follow = match sweep.follow {
                    FollowFile::None => Follow::None,
                    FollowFile::Radial => Follow::Radial,
                    FollowFile::Tangential => Follow::Tangential,
                    FollowFile::Axial => Follow::Axial,
                };
                let moved = &self.machine.axes[axis];
                if follow != Follow::None && moved.kind == AxisKind::Linear {
                    let message = format!(
                        "'follow' has the linear axes follow a rotary axis, and {} is linear; leave it out, or name a rotary axis",
                        moved.name
                    );
                    return Err(self.document.refuse(&at("sweep"), message));
                }
                let length_mm = self.kept_mm(&at("sweep"), follow, sweep.length, raw.bar_length)?;
                Ok(Some(TestPath::Sweep { axis, from: sweep.from, to: sweep.to, step, follow, length_mm }))
            }
            (None, Some(circle)) => {
                let step = self.step(&at("circle"), circle.from, circle.to, circle.step)?;
                let plane = self.plane(&at("circle"), &circle.plane)?;
                if finite(self.document, &at("circle"), circle.radius)? <= 0.0 {
                    return Err(self.document.refuse(&at("circle"), "radius is above zero, in mm"));
                }
                Ok(Some(TestPath::Circle { plane, radius_mm: circle.radius, from: circle.from, to: circle.to, step }))
            }
        }
    }

    /// Distance between the balls that following linear axes keep, where the file states it: within the stroke of the test's bar.
    fn kept_mm(
        &self,
        place: &[Step],
        follow: Follow,
        length: Option<f64>,
        bar_mm: Option<f64>,
    ) -> Result<Option<f64>, LoadError> {
        let Some(length_mm) = length else { return Ok(None) };
        let length_mm = finite(self.document, place, length_mm)?;
        let refuse = |message: String| Err(self.document.refuse(place, message));
        match bar_mm {
            _ if follow == Follow::None => refuse(
                "'length' is what following linear axes keep between the balls; leave it out, or say 'follow'".into(),
            ),
            _ if length_mm <= 0.0 => refuse(format!("length is above zero, in mm, and not {length_mm}")),
            Some(bar_mm) if (length_mm - bar_mm).abs() > STROKE_LIMIT_MM => refuse(format!(
                "length is {length_mm} mm where the bar has {bar_mm} mm: it lies within {STROKE_LIMIT_MM} mm of it"
            )),
            _ => Ok(Some(length_mm)),
        }
    }

    fn step(&self, place: &[Step], from: f64, to: f64, step: Option<f64>) -> Result<f64, LoadError> {
        let step = step.unwrap_or(0.5).abs();
        for value in [from, to, step] {
            finite(self.document, place, value)?;
        }
        if step == 0.0 || from == to || ((to - from) / step).abs() > ROWS.most as f64 {
            return Err(self
                .document
                .refuse(place, "from and to differ, step is above zero and gives at most a million samples"));
        }
        Ok(step)
    }

    fn plane(&self, place: &[Step], plane: &str) -> Result<CirclePlane, LoadError> {
        let linear = |letter: Option<char>| {
            let axis = self.machine.axis_index(&letter?.to_string())?;
            (self.machine.axes[axis].kind == AxisKind::Linear).then_some(axis)
        };
        let mut letters = plane.chars();
        match (linear(letters.next()), linear(letters.next()), letters.next()) {
            (Some(first), Some(second), None) if first != second => Ok(CirclePlane { first, second }),
            _ => Err(self
                .document
                .refuse(place, format!("plane '{plane}' does not name two linear axes; write for example XY"))),
        }
    }
}

//! What reading a test needs, and what its keys share: axes by name, positions in their ranges, balls.

use nalgebra::Vector3;

use super::recordings::RecordingReader;
use super::test_file::BallFile;
use crate::chain::Chain;
use crate::load::checked_text::document::{Document, Step};
use crate::load::checked_text::message::LoadError;
use crate::load::checked_text::quantity::{finite, positive_length};
use crate::load::links::known_link;
use crate::load::range::outside_range;
use crate::machine::Machine;
use crate::readings::Kind;
use crate::session::Ball;

/// What reading one test needs.
pub(crate) struct TestReader<'a> {
    pub(crate) document: &'a Document,
    /// Kind of the readings of tests that do not say their own.
    pub(crate) kind: Kind,
    pub(crate) recordings: RecordingReader<'a>,
    pub(crate) machine: &'a Machine,
    pub(crate) chain: &'a Chain,
}

impl TestReader<'_> {
    pub(crate) fn axis(&self, place: &[Step], name: &str) -> Result<usize, LoadError> {
        self.machine.axis_index(name).ok_or_else(|| {
            self.document.refuse(
                place,
                format!("the machine has no axis '{name}'; its axes are {}", self.machine.axis_names().join(" ")),
            )
        })
    }

    pub(crate) fn position(&self, index: usize, axis: usize, value: f64) -> Result<f64, LoadError> {
        let name = &self.machine.axes[axis].name;
        let place = [Step::Key("tests"), Step::Index(index), Step::Key("positions"), Step::Key(name)];
        let value = self.machine.axes[axis].kind.from_file_unit(finite(self.document, &place, value)?);
        match outside_range(self.machine, axis, value) {
            Some(message) => Err(self.document.refuse(&place, message)),
            None => Ok(value),
        }
    }

    pub(crate) fn ball(&self, index: usize, key: &str, raw: &BallFile) -> Result<Ball, LoadError> {
        let place = [Step::Key("tests"), Step::Index(index), Step::Key(key)];
        for value in raw.at {
            finite(self.document, &place, value)?;
        }
        known_link(self.document, self.chain, &place, &raw.link)?;
        let indexed_about = match raw.indexed_about.as_deref() {
            None => None,
            Some(_) if key == "pivot" => {
                return Err(self
                    .document
                    .refuse(&place, "a pivot is not indexed; 'indexed_about' is for the spindle ball"));
            }
            Some("x") => Some(0),
            Some("y") => Some(1),
            Some("z") => Some(2),
            Some(other) => {
                let allowed = "the direction of R along which the spindle lies with all axes at zero: x, y or z";
                return Err(self.document.refuse(&place, format!("indexed_about '{other}' is not {allowed}")));
            }
        };
        Ok(Ball {
            indexed_about,
            link: raw.link.clone(),
            at: Vector3::from(raw.at),
            setup: raw.setup.clone(),
            spread_mm: raw.spread.as_ref().map(|value| positive_length(self.document, &place, value)).transpose()?,
        })
    }
}

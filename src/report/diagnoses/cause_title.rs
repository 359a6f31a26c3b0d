//! What a cause is called: the effect and where it sits, or the fault of the data.

use crate::diagnose::FaultKind;
use crate::effects::kind;

/// The effect and where it sits, without its size: `Lost motion of Y`.
pub fn what(effect: &str, place: &str, components: &[String]) -> String {
    let moving = components.join(" ");
    match kind(effect) {
        Some(kind) => kind.title(place, &moving),
        None => format!("{effect} at {place} ({moving})"),
    }
}

/// The mistake in the files and where it was made: `Data fault: sign of C is turned`.
pub fn what_mistake(kind: FaultKind, place: &str, components: &[String]) -> String {
    let moving = components.join(" ");
    let says = match kind {
        FaultKind::AxisSign => format!("sign of {moving} is turned"),
        FaultKind::AxisSwap => format!("{moving} are exchanged"),
        FaultKind::Unit => format!("unit of {moving}"),
        FaultKind::AngleReversed => format!("angles of {moving} were written from the wrong end"),
        FaultKind::ColumnShifted => format!("positions of {moving} are off"),
        FaultKind::ReadingSign => "deviations have the wrong sign".into(),
        FaultKind::ReadingZero => "readings have a zero of their own".into(),
        FaultKind::ReadingsProcessed => "software took something off the readings".into(),
        FaultKind::ReadingsOrder => "readings stand beside the wrong positions".into(),
        FaultKind::ValuesRounded => "values were rounded".into(),
        FaultKind::BallPlace => format!("{} elsewhere than stated", standing(place)),
        FaultKind::BallLink => format!("{} on another link than stated", standing(place)),
        FaultKind::MountedAnew => format!("{} elsewhere in some tests", standing(place)),
        FaultKind::StandingAxis => format!("{moving} stood elsewhere than stated"),
        FaultKind::BarOther => "the bar is another than stated".into(),
        FaultKind::AxisLine => format!("the line of {moving} lies elsewhere than the machine file says"),
        FaultKind::AxisDirection => format!("{moving} turns about another direction than the machine file says"),
        FaultKind::AxisOrder => format!("{moving} are the wrong way round in the machine's code"),
        FaultKind::FilesExchanged => "recordings stand in each other's tests".into(),
        FaultKind::InstrumentMoved => "the instrument was moved".into(),
        FaultKind::RotationForm => "rotations are in another form than stated".into(),
        FaultKind::SwappedColumns => "columns are exchanged".into(),
        FaultKind::SameRecording => "one recording stands in several tests".into(),
        FaultKind::Direction => "recordings run against the direction of their tests".into(),
        FaultKind::Arc => "a recording covers another arc than its test".into(),
        FaultKind::Dwell => "a dwell was left in a recording".into(),
        FaultKind::ForeignFile => "a recording does not belong to the session".into(),
        FaultKind::DoubledRows => "rows stand twice".into(),
        FaultKind::ReadingsMissing => "most readings of a test are missing".into(),
        FaultKind::BothDirections => "a recording holds both directions".into(),
        FaultKind::GaugeStuck => "the gauge stuck".into(),
        FaultKind::StrokeEnd => "the bar reached the end of its stroke".into(),
        FaultKind::SessionTime => "times of tests contradict each other".into(),
        FaultKind::Feed => "the ball moves at another speed than stated".into(),
        FaultKind::TimeShift => "times are shifted against the positions".into(),
    };
    format!("Data fault: {says}")
}

/// A ball as the subject of a sentence.
fn standing(place: &str) -> &'static str {
    match place {
        "pivot" => "a pivot stands",
        "instrument" => "an instrument stands",
        "target" => "a target stands",
        _ => "the spindle ball stands",
    }
}

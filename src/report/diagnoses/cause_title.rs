//! What a cause is called: the effect and where it sits, or the fault of the data.

use crate::effects::kind;

/// The effect and where it sits, without its size: `Lost motion of Y`.
pub fn what(effect: &str, place: &str, components: &[String]) -> String {
    let moving = components.join(" ");
    if let Some(kind) = kind(effect) {
        return kind.title(place, &moving);
    }
    match effect {
        "axis-sign" => format!("Data fault: sign of {moving} is turned"),
        "axis-swap" => format!("Data fault: {moving} are exchanged"),
        "unit" => format!("Data fault: unit of {moving}"),
        "angle-reversed" => format!("Data fault: angles of {moving} were written from the wrong end"),
        "column-shifted" => format!("Data fault: positions of {moving} are off"),
        "reading-sign" => "Data fault: deviations have the wrong sign".into(),
        "reading-zero" => "Data fault: readings have a zero of their own".into(),
        "readings-processed" => "Data fault: software took something off the readings".into(),
        "readings-order" => "Data fault: readings stand beside the wrong positions".into(),
        "values-rounded" => "Data fault: values were rounded".into(),
        "ball-place" => format!("Data fault: {} elsewhere than stated", standing(place)),
        "ball-link" => format!("Data fault: {} on another link than stated", standing(place)),
        "standing-axis" => format!("Data fault: {moving} stood elsewhere than stated"),
        "bar-other" => "Data fault: the bar is another than stated".into(),
        "axis-line" => format!("Data fault: the line of {moving} lies elsewhere than the machine file says"),
        "axis-direction" => format!("Data fault: {moving} turns about another direction than the machine file says"),
        "axis-order" => format!("Data fault: {moving} are the wrong way round in the machine's code"),
        "files-exchanged" => "Data fault: recordings stand in each other's tests".into(),
        "instrument-moved" => "Data fault: the instrument was moved".into(),
        "rotation-form" => "Data fault: rotations are in another form than stated".into(),
        "swapped-columns" => "Data fault: columns are exchanged".into(),
        "same-recording" => "Data fault: one recording stands in several tests".into(),
        "direction" => "Data fault: recordings run against the direction of their tests".into(),
        "arc" => "Data fault: a recording covers another arc than its test".into(),
        "dwell" => "Data fault: a dwell was left in a recording".into(),
        "foreign-file" => "Data fault: a recording does not belong to the session".into(),
        "doubled-rows" => "Data fault: rows stand twice".into(),
        "readings-missing" => "Data fault: most readings of a test are missing".into(),
        "both-directions" => "Data fault: a recording holds both directions".into(),
        "gauge-stuck" => "Data fault: the gauge stuck".into(),
        "stroke-end" => "Data fault: the bar reached the end of its stroke".into(),
        "session-time" => "Data fault: tests overlap in time".into(),
        "feed" => "Data fault: the ball moves at another speed than stated".into(),
        "time-shift" => "Data fault: times are shifted against the positions".into(),
        other => format!("{other} at {place} ({moving})"),
    }
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

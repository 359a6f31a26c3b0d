//! Dates and times of day as gauges and people write them, to seconds on one scale. It reads no files.

use jiff::civil::{Date, date};

/// A moment on the local clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Day; `None` where none is stated.
    day: Option<Date>,
    /// Since midnight, s.
    of_day_s: f64,
}

/// Seconds of a day.
const DAY_S: f64 = 86400.0;

impl Moment {
    /// The moment that a text states: `2026-11-26T10:15:32`, `26.11.2026 10:15`, `11/26/2026 10:15:32 PM`, `10:15:32`.
    pub fn from_text(text: &str) -> Option<Moment> {
        let (day, of_day_s) = parts(text);
        Some(Moment { day, of_day_s: of_day_s? })
    }

    /// Midnight before the moment that a row's stamp states.
    pub(super) fn midnight_of(stamp: &str) -> Option<Moment> {
        Moment::from_text(stamp).map(|moment| Moment { of_day_s: 0.0, ..moment })
    }

    /// So many seconds before.
    pub(super) fn before(self, seconds: f64) -> Moment {
        Moment { of_day_s: self.of_day_s - seconds, ..self }
    }

    /// Whether it states a day.
    pub fn has_day(&self) -> bool {
        self.day.is_some()
    }

    /// Seconds since the beginning of 1970 where days count, else since midnight.
    pub fn seconds(&self, with_days: bool) -> f64 {
        let days = |day: Date| day.duration_since(date(1970, 1, 1)).as_hours() as f64 / 24.0;
        self.of_day_s + if with_days { self.day.map_or(0.0, days) * DAY_S } else { 0.0 }
    }
}

/// Words of lines and elements that say when a recording began, and of such that say something else.
const WHEN: [&str; 8] = ["date", "datum", "time", "zeit", "start", "begin", "record", "measured"];
const OTHER: [&str; 13] = [
    "calib", "version", "print", "export", "serial", "due", "expir", "modif", "duration", "dauer", "interval", "rate",
    "unit",
];

/// Date and time of day out of what labelled lines state one by one.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Stated {
    day: Option<Date>,
    of_day_s: Option<f64>,
}

impl Stated {
    /// Takes what a text with this label says, if it is about the recording and nothing was said before; whether it says anything.
    pub(super) fn take(&mut self, label: &str, text: &str) -> bool {
        let label = label.to_lowercase();
        let has = |words: &[&str]| words.iter().any(|word| label.contains(word));
        if !has(&WHEN) || has(&OTHER) {
            return false;
        }
        let (day, of_day_s) = parts(text);
        self.day = self.day.or(day);
        self.of_day_s = self.of_day_s.or(of_day_s);
        day.is_some() || of_day_s.is_some()
    }

    pub(super) fn moment(self) -> Option<Moment> {
        Some(Moment { day: self.day, of_day_s: self.of_day_s? })
    }
}

/// First day and first time of day in a text.
fn parts(text: &str) -> (Option<Date>, Option<f64>) {
    let apart = |character: char| character.is_whitespace() || ";,\"=()[]T".contains(character);
    // a decimal comma belongs to its number
    let text: String = text.replace(", ", " ").replace(',', ".").replace('t', "T");
    let words: Vec<&str> = text.split(apart).filter(|word| !word.is_empty()).collect();
    let day = words.iter().find_map(|word| day(word));
    let of_day_s = words.iter().enumerate().find_map(|(k, word)| time_of_day(word, words.get(k + 1).copied()));
    (day, of_day_s)
}

/// `2026-11-26`, `26.11.2026`, `26/11/2026`, `11/26/2026`; the day stands before the month where both may be.
fn day(word: &str) -> Option<Date> {
    let separator = ['-', '.', '/'].into_iter().find(|&separator| word.matches(separator).count() == 2)?;
    let word = word.trim_start_matches(|character: char| !character.is_ascii_digit());
    let texts: Vec<&str> = word.split(separator).collect();
    let [first, second, third] = texts[..] else { return None };
    let number = |text: &str| text.parse::<i16>().ok();
    let (one, two, three) = (number(first)?, number(second)?, number(third)?);
    let (year, month, day) = match (first.len(), third.len()) {
        (4, _) => (one, two, three),
        (_, 4) if separator == '/' && two > 12 => (three, one, two),
        (_, 4) => (three, two, one),
        _ => return None,
    };
    Date::new(year, i8::try_from(month).ok()?, i8::try_from(day).ok()?).ok()
}

/// `10:15`, `10:15:32.5`, with `AM` or `PM` behind or in the next word, s since midnight. A label before it ends in a colon of its own.
fn time_of_day(word: &str, next: Option<&str>) -> Option<f64> {
    let word = word.trim_start_matches(|character: char| !character.is_ascii_digit()).to_lowercase();
    // what follows is a zone
    let word = word.split(['+', 'z']).next()?;
    let is = |half: &str| word.ends_with(half) || next.is_some_and(|next| next.eq_ignore_ascii_case(half));
    let (morning, afternoon) = (is("am"), is("pm"));
    let numbers: Option<Vec<f64>> =
        word.trim_end_matches(['a', 'p', 'm']).split(':').map(|part| part.parse().ok()).collect();
    let (hours, minutes, seconds) = match numbers?[..] {
        [hours, minutes] => (hours, minutes, 0.0),
        [hours, minutes, seconds] => (hours, minutes, seconds),
        _ => return None,
    };
    let hours = match hours {
        hours if morning && hours == 12.0 => 0.0,
        hours if afternoon && hours < 12.0 => hours + 12.0,
        hours => hours,
    };
    let is_clock = hours.fract() == 0.0 && minutes.fract() == 0.0 && hours < 24.0 && minutes < 60.0 && seconds < 60.0;
    (is_clock && hours >= 0.0 && minutes >= 0.0 && seconds >= 0.0).then_some((hours * 60.0 + minutes) * 60.0 + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn since(one: &str, other: &str) -> f64 {
        let [one, other] = [one, other].map(|text| Moment::from_text(text).expect(text));
        assert!(one.has_day() == other.has_day());
        one.seconds(one.has_day()) - other.seconds(one.has_day())
    }

    #[test]
    fn the_usual_ways_to_write_a_moment_are_one() {
        for text in [
            "2026-11-26T10:15:32",
            "2026-11-26 10:15:32Z",
            "Recorded: 26.11.2026, 10:15:32",
            "26/11/2026 10:15:32",
            "11/26/2026 10:15:32 AM",
            "11/26/2026;10:15:32am",
            "2026-11-26T10:15:32+01:00",
            "date=\"26.11.2026\" time=\"10:15:32,0\"",
        ] {
            assert_eq!(since(text, "2026-11-26 10:15:32"), 0.0, "{text}");
        }
        assert_eq!(since("10:15:32.25 PM", "10:15:32.00 AM"), 12.0 * 3600.0 + 0.25);
        assert_eq!(since("12:00 AM", "00:00"), 0.0);
        // over midnight, the end of a month and a leap day
        assert_eq!(since("2026-12-01 00:00:10", "2026-11-30 23:59:50"), 20.0);
        assert_eq!(since("2028-03-01 00:00", "2028-02-28 00:00"), 2.0 * DAY_S);
    }

    #[test]
    fn what_is_no_moment_states_none() {
        for text in
            ["", "version 5.07.2011", "26.11.2026", "2026-02-30", "25:00:00", "10:61", "1:2:3:4", "µm/s", "::", "TTT"]
        {
            assert_eq!(Moment::from_text(text), None, "{text}");
        }
        let mut stated = Stated::default();
        for line in ["Calibration date: 2020-01-01 08:00", "Software version: 1.2.2020", "Test duration: 00:01:05"] {
            stated.take(line, line);
        }
        assert_eq!(stated.moment(), None);
        stated.take("Date: 26.11.2026", "Date: 26.11.2026");
        stated.take("Time: 10:15", "Time: 10:15");
        assert_eq!(stated.moment(), Moment::from_text("2026-11-26 10:15"));
    }
}

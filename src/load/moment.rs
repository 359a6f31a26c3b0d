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
pub(super) const DAY_S: f64 = 86400.0;

impl Moment {
    /// The moment that a text states: `2026-11-26T10:15:32`, `26.11.2026 10:15`, `11/26/2026 10:15:32 PM`, `26 Nov 2026 10:15`, `10:15:32`.
    /// `None` where it states no time of day, or a day that there is not.
    pub fn from_text(text: &str) -> Option<Moment> {
        let parts = parts(text);
        Some(Moment { day: parts.day.ok()?, of_day_s: parts.of_day_s? })
    }

    /// That of a row's stamp: hours, minutes and seconds, on a day that the stamp states, or else the preamble.
    pub(super) fn of_stamp(stamp: &str, preamble: Stated) -> Option<Moment> {
        let clock = stamp.rsplit(['T', ' ']).find(|word| word.contains(':'))?;
        let found = Moment::from_text(stamp).filter(|_| clock.matches(':').count() == 2)?;
        Some(Moment { day: found.day.or(preamble.moment.and_then(|moment| moment.day)).or(preamble.day), ..found })
    }

    /// Whether it states a day.
    pub fn has_day(&self) -> bool {
        self.day.is_some()
    }

    /// Seconds since midnight.
    pub fn seconds_of_day(&self) -> f64 {
        self.of_day_s
    }

    /// Seconds since the beginning of 1970; since midnight where no day is stated.
    pub fn seconds_since_1970(&self) -> f64 {
        let days = |day: Date| day.duration_since(date(1970, 1, 1)).as_hours() as f64 / 24.0;
        self.of_day_s + self.day.map_or(0.0, days) * DAY_S
    }
}

/// Words of a label that say when a recording began.
const WHEN: [&str; 19] = [
    "date",
    "datum",
    "time",
    "zeit",
    "uhrzeit",
    "start",
    "started",
    "begin",
    "began",
    "beginn",
    "recorded",
    "recording",
    "measured",
    "gemessen",
    "timestamp",
    "datetime",
    "messdatum",
    "messzeit",
    "startzeit",
];
/// Beginnings of words of a label that is about something else.
const OTHER: [&str; 26] = [
    "calib", "kalib", "version", "firmware", "software", "build", "print", "export", "serial", "due", "expir", "modif",
    "update", "duration", "dauer", "interval", "rate", "unit", "zone", "timezone", "point", "dwell", "angle", "end",
    "stop", "finish",
];

/// What labelled lines state of the time of a recording.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Stated {
    /// Of the first line that states a day and a time of day.
    moment: Option<Moment>,
    /// Of the first lines that state one of them.
    day: Option<Date>,
    of_day_s: Option<f64>,
}

impl Stated {
    /// Takes what a text says under a label, if it is about the recording and nothing was said before; whether it says anything.
    pub(super) fn take(&mut self, label: &str, text: &str) -> bool {
        if !is_of_recording(label) {
            return false;
        }
        let parts = parts(text);
        // a day that is not understood makes the time beside it one of any day
        let Ok(day) = parts.day else { return false };
        match (day, parts.of_day_s) {
            (Some(_), Some(of_day_s)) => self.moment = self.moment.or(Some(Moment { day, of_day_s })),
            (day, of_day_s) => (self.day, self.of_day_s) = (self.day.or(day), self.of_day_s.or(of_day_s)),
        }
        day.is_some() || parts.of_day_s.is_some()
    }

    /// The same of a line that begins with its label. The line where its label promises a time and its numbers are not understood
    /// as one.
    pub(super) fn take_line<'a>(&mut self, line: &'a str) -> Option<&'a str> {
        let number = line.find(|character: char| character.is_ascii_digit())?;
        let label = &line[..number];
        (!self.take(label, line) && is_of_recording(label)).then_some(line)
    }

    pub(super) fn moment(self) -> Option<Moment> {
        self.moment.or_else(|| Some(Moment { day: self.day, of_day_s: self.of_day_s? }))
    }
}

/// Whether a label is one of the time of a recording.
fn is_of_recording(label: &str) -> bool {
    words_of(label).iter().any(|word| WHEN.contains(&word.as_str())) && !is_of_other(label)
}

/// Whether a label, or the name of what holds it, is about something else: a calibration's date is no recording's.
pub(super) fn is_of_other(label: &str) -> bool {
    words_of(label).iter().any(|word| OTHER.iter().any(|other| word.starts_with(other)))
}

/// Words of a label in small letters, `StartTime` being two.
pub(super) fn words_of(label: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_small = false;
    for character in label.chars() {
        if !character.is_alphabetic() || character.is_uppercase() && was_small {
            words.push(String::new());
        }
        if character.is_alphabetic() {
            words.last_mut().into_iter().for_each(|word| word.extend(character.to_lowercase()));
        }
        was_small = character.is_lowercase();
    }
    words
}

/// What a text states.
struct Parts {
    /// `Err` where something looks like a day and is none that is understood.
    day: Result<Option<Date>, ()>,
    of_day_s: Option<f64>,
}

fn parts(text: &str) -> Parts {
    // a decimal comma belongs to its number
    let text = text.replace(", ", " ").replace(',', ".");
    let apart = |character: char| character.is_whitespace() || ";\"=()[]".contains(character);
    let mut words: Vec<&str> = Vec::new();
    for word in text.split(apart).filter(|word| !word.is_empty()) {
        // a zone is no time
        let is_zone = ["utc", "gmt", "+"].iter().any(|zone| word.to_lowercase().starts_with(zone));
        let is_joined = |at: usize| {
            let beside = |other: Option<char>| other.is_some_and(|other| other.is_ascii_digit());
            beside(word[..at].chars().next_back()) && beside(word[at + 1..].chars().next())
        };
        let joint = word.char_indices().find(|(at, character)| matches!(character, 'T' | 't') && is_joined(*at));
        match joint {
            _ if is_zone => {}
            Some((at, _)) => words.extend([&word[..at], &word[at + 1..]]),
            None => words.push(word),
        }
    }
    let of_day = words.iter().enumerate().find_map(|(k, word)| time_of_day(word, words.get(k + 1).copied()));
    let is_of_halves = of_day.is_some_and(|(_, is_of_halves)| is_of_halves);
    let days: Vec<Result<Date, ()>> =
        words.iter().filter_map(|word| day(word, is_of_halves)).chain(day_by_name(&words)).collect();
    let day = match days.iter().find_map(|day| day.ok()) {
        Some(day) => Ok(Some(day)),
        None if days.is_empty() => Ok(None),
        None => Err(()),
    };
    Parts { day, of_day_s: of_day.map(|(seconds, _)| seconds) }
}

/// `2026-11-26`, `26.11.2026`, `26.11.26`, `26/11/2026`, `11/26/2026`; the day stands before the month where both may be, but for a
/// clock of AM and PM. `None` where the word is no day, an error where it looks like one.
fn day(word: &str, is_of_halves: bool) -> Option<Result<Date, ()>> {
    let separator = ['-', '.', '/'].into_iter().find(|&separator| word.matches(separator).count() == 2)?;
    let texts: Vec<&str> = word.trim_matches(|character: char| !character.is_ascii_digit()).split(separator).collect();
    let is_number = |text: &&str| !text.is_empty() && text.chars().all(|character| character.is_ascii_digit());
    if !texts.iter().all(is_number) {
        return None;
    }
    let numbers: Option<Vec<i16>> = texts.iter().map(|text| text.parse().ok()).collect();
    let Some(numbers) = numbers else { return Some(Err(())) };
    let ([first, _, third], [one, two, three]) = (&texts[..], &numbers[..]) else { return None };
    let (one, two, three) = (*one, *two, *three);
    let is_month_first = separator != '.' && (two > 12 || one <= 12 && is_of_halves);
    let year = if third.len() == 2 && separator != '-' { 2000 + three } else { three };
    let found = match (first.len(), third.len()) {
        (4, 1..=2) => Some((one, two, three)),
        (1..=2, 4) | (1..=2, 2) if year >= 1970 => {
            Some(if is_month_first { (year, one, two) } else { (year, two, one) })
        }
        _ => None,
    };
    let date_of =
        |(year, month, day): (i16, i16, i16)| Date::new(year, i8::try_from(month).ok()?, i8::try_from(day).ok()?).ok();
    Some(found.and_then(date_of).ok_or(()))
}

/// Months by their first three letters, English and German ones.
const MONTHS: [[&str; 2]; 12] = [
    ["jan", "jän"],
    ["feb", "feb"],
    ["mar", "mär"],
    ["apr", "apr"],
    ["may", "mai"],
    ["jun", "jun"],
    ["jul", "jul"],
    ["aug", "aug"],
    ["sep", "sep"],
    ["oct", "okt"],
    ["nov", "nov"],
    ["dec", "dez"],
];

/// `26 Nov 2026`, `Nov 26 23:57:00 2026`, `26. November 2026`.
fn day_by_name(words: &[&str]) -> Option<Result<Date, ()>> {
    let month_of = |word: &str| {
        let word = word.trim_end_matches('.').to_lowercase();
        let start: String = word.chars().take(3).collect();
        let month = MONTHS.iter().position(|names| names.contains(&start.as_str()))?;
        word.chars().all(char::is_alphabetic).then_some(month as i8 + 1)
    };
    let (at, month) = words.iter().enumerate().find_map(|(at, word)| Some((at, month_of(word)?)))?;
    let number = |word: &&str| word.trim_end_matches('.').parse::<i16>().ok();
    let beside = [at.checked_sub(1).and_then(|before| words.get(before)), words.get(at + 1)];
    let day = beside.into_iter().flatten().filter_map(number).find(|day| (1..=31).contains(day))?;
    let year = words.iter().filter_map(number).find(|year| *year >= 1970)?;
    Some(Date::new(year, month, day as i8).map_err(|_| ()))
}

/// `10:15`, `10:15:32.5`, with `AM` or `PM` behind or in the next word, s since midnight, and whether it is a clock of those. A
/// label before it ends in a colon of its own.
fn time_of_day(word: &str, next: Option<&str>) -> Option<(f64, bool)> {
    let word = word.trim_start_matches(|character: char| !character.is_ascii_digit()).to_lowercase();
    // what follows is a zone
    let word = word.split(['+', '-', 'z']).next()?;
    let is = |half: &str| word.ends_with(half) || next.is_some_and(|next| next.eq_ignore_ascii_case(half));
    let (morning, afternoon) = (is("am"), is("pm"));
    let texts: Vec<&str> = word.trim_end_matches(['a', 'p', 'm']).split(':').collect();
    let numbers: Option<Vec<f64>> = texts.iter().map(|part| part.parse().ok()).collect();
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
    let are_whole = texts[0].len() <= 2 && texts[1].len() == 2 && hours.fract() == 0.0 && minutes.fract() == 0.0;
    let is_clock = are_whole && (0.0..24.0).contains(&hours) && (0.0..60.0).contains(&minutes);
    let is_clock = is_clock && (0.0..60.0).contains(&seconds);
    is_clock.then_some(((hours * 60.0 + minutes) * 60.0 + seconds, morning || afternoon))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn since(one: &str, other: &str) -> f64 {
        let [one, other] = [one, other].map(|text| Moment::from_text(text).expect(text));
        assert!(one.has_day() == other.has_day());
        one.seconds_since_1970() - other.seconds_since_1970()
    }

    #[test]
    fn the_usual_ways_to_write_a_moment_are_one() {
        for text in [
            "2026-11-26T10:15:32",
            "2026-11-26 10:15:32Z",
            "Recorded: 26.11.2026, 10:15:32",
            "26.11.26 10:15:32",
            "26/11/2026 10:15:32",
            "11-26-2026 10:15:32",
            "11/26/2026 10:15:32 AM",
            "11/26/2026;10:15:32am",
            "2026-11-26T10:15:32+01:00",
            "2026-11-26T10:15:32-05:00",
            "Thu Nov 26 10:15:32 2026",
            "26. November 2026 10:15:32",
            "2026-11-26 (UTC+01:00) 10:15:32",
            "date=\"26.11.2026\" time=\"10:15:32,0\"",
        ] {
            assert_eq!(since(text, "2026-11-26 10:15:32"), 0.0, "{text}");
        }
        assert_eq!(since("10:15:32.25 PM", "10:15:32.00 AM"), 12.0 * 3600.0 + 0.25);
        assert_eq!(since("12:00 AM", "00:00"), 0.0);
        // a clock of halves stands beside months first
        assert_eq!(since("11/13/2026 00:05 AM", "11/12/2026 11:50:00 PM"), 900.0);
        // over midnight, the end of a month and a leap day
        assert_eq!(since("2026-12-01 00:00:10", "2026-11-30 23:59:50"), 20.0);
        assert_eq!(since("2028-03-01 00:00", "2028-02-28 00:00"), 2.0 * DAY_S);
    }

    #[test]
    fn what_is_no_moment_states_none() {
        let none = [
            "",
            "version 5.07.2011",
            "26.11.2026",
            "2026-02-30",
            "2026-11-31 07:00",
            "25:00:00",
            "10:61",
            "1:1",
            "1:2:3:4",
            "µm/s",
            "::",
            "TTT",
            "1e308:00",
            "ßT1:00T",
            "99999999999999999999-01-01 10:00",
        ];
        for text in none {
            assert_eq!(Moment::from_text(text), None, "{text}");
        }
        let mut stated = Stated::default();
        for line in [
            "Calibration date: 2020-01-01 08:00",
            "Kalibrierdatum: 12.03.2025",
            "Ball bar recorder firmware 12.03.2021",
            "Last update: 2026-01-12 08:00",
            "Software version: 1.2.2020",
            "Test duration: 00:01:05",
            "Timezone: 01:00",
            "Recording finished: 2026-11-26 10:16:00",
            "Recorded: 2026-11-31 10:16:00",
            "Time scale 1:1",
        ] {
            stated.take_line(line);
        }
        assert_eq!(stated.moment(), None);
        stated.take_line("Date: 26.11.2026");
        stated.take_line("Time: 10:15");
        assert_eq!(stated.moment(), Moment::from_text("2026-11-26 10:15"));
        // a line that states both is surer
        stated.take_line("Recorded: 2026-11-26 10:20, Serial: 12");
        assert_eq!(stated.moment(), Moment::from_text("2026-11-26 10:20"));
    }

    #[test]
    fn a_stamp_has_the_day_of_the_preamble_and_its_seconds() {
        let mut preamble = Stated::default();
        preamble.take_line("Date: 2026-11-26");
        assert_eq!(Moment::of_stamp("01:30:00.5", preamble), Moment::from_text("2026-11-26 01:30:00.5"));
        assert_eq!(Moment::of_stamp("2026-11-27T01:30:00", preamble), Moment::from_text("2026-11-27 01:30"));
        assert_eq!(Moment::of_stamp("05:10.0", preamble), None);
        assert_eq!(Moment::of_stamp("12.5", preamble), None);
    }
}

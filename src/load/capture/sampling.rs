//! How often a gauge reads, by the names and units of elements: which name a sampling rate, and which another one.

use crate::load::moment::words_of;

/// Words, alone or as the first part of one, that say that readings are taken.
const TAKING: [&str; 17] = [
    "sample",
    "samples",
    "sampling",
    "data",
    "acquisition",
    "scan",
    "scanning",
    "logging",
    "recording",
    "capture",
    "reading",
    "readings",
    "measuring",
    "measurement",
    "abtast",
    "abtastung",
    "mess",
];
/// How words begin that are about a calibration, whose rate is another.
const CALIBRATION: [&str; 2] = ["calib", "kalib"];
/// Words for readings a second, and for the time from one to the next.
const RATES: [&str; 5] = ["rate", "frequency", "freq", "frequenz", "hz"];
const STEPS: [&str; 4] = ["interval", "period", "intervall", "periode"];
/// Units of rates, Hz, and of times, s.
const OF_RATES: [(&str, f64); 3] = [("hz", 1.0), ("khz", 1e3), ("1/s", 1.0)];
const OF_STEPS: [(&str, f64); 14] = [
    ("s", 1.0),
    ("sec", 1.0),
    ("second", 1.0),
    ("seconds", 1.0),
    ("ms", 1e-3),
    ("msec", 1e-3),
    ("us", 1e-6),
    ("µs", 1e-6),
    ("μs", 1e-6),
    ("usec", 1e-6),
    ("ns", 1e-9),
    ("min", 60.0),
    ("minute", 60.0),
    ("minutes", 60.0),
];

/// Whether the label of a line, before its first number, says sampling.
pub(super) fn says_sampling(line: &str) -> bool {
    line.split(|c: char| c.is_ascii_digit()).next().is_some_and(|label| Sampling::of(label).is_some())
}

/// Readings a second that a line of a preamble states: `Sample rate: 0.25 kHz`, `Sample interval: 4 ms`.
pub(super) fn stated_rate(line: &str) -> Option<f64> {
    let lower = line.to_lowercase();
    let is_number = |c: char| c.is_ascii_digit() || c == '.' || c == ',';
    let value = |word: &str| word.replace(',', ".").parse().ok().filter(|value: &f64| *value > 0.0);
    // a rate in Hz is one under any label, which may be of any language
    if let Some(at) = lower.find("hz") {
        let before = &lower[..at];
        let unit = if before.ends_with('k') { "khz" } else { "hz" };
        let size = OF_RATES.iter().find(|(name, _)| *name == unit).map_or(1.0, |(_, size)| *size);
        let last = before.split(|c| !is_number(c)).rfind(|word| !word.is_empty());
        return last.and_then(value).map(|rate| size * rate);
    }
    // one in units of time is told by its label
    let (label, behind) = line.split_at(line.find(|c: char| c.is_ascii_digit())?);
    let (interval, unit) = behind.split_at(behind.find(|c| !is_number(c))?);
    let unit = unit.split_whitespace().next()?;
    let sampling = Sampling::of(label).filter(|sampling| sampling.is_step)?;
    sampling.rate_hz(value(interval)?, Some(unit)).ok()
}

/// Units of time that messages name.
pub(super) const TIME_UNITS: &str = "s, ms or us";

/// Size of a unit of time, s; `None` for a word that is none.
pub(super) fn time_unit_s(word: &str) -> Option<f64> {
    OF_STEPS.iter().find(|(name, _)| *name == word).map(|(_, size_s)| *size_s)
}

/// What a name says of sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sampling {
    /// The time from one reading to the next, not readings a second.
    is_step: bool,
    /// The name says that readings are taken: `SampleRate`, not `Rate`.
    pub is_certain: bool,
    /// Unit within the name, Hz or s.
    unit: Option<f64>,
}

impl Sampling {
    /// Of a name whose words say a sampling rate or interval, or a rate and nothing else; `None` for any other, such as a feed
    /// rate.
    pub fn of(name: &str) -> Option<Sampling> {
        let all: Vec<String> = words_of(name).into_iter().filter(|word| !word.is_empty()).collect();
        if all.iter().any(|word| CALIBRATION.iter().any(|begin| word.starts_with(begin))) {
            return None;
        }
        let mut words: Vec<&str> = all.iter().map(String::as_str).collect();
        let is_kind = |word: &str| RATES.contains(&word) || STEPS.contains(&word);
        // a unit behind the words; `Hz` alone is one of rates
        let units = || OF_RATES.iter().chain(&OF_STEPS);
        let of_name = units().find(|(unit, _)| words.len() > 1 && words.last() == Some(unit)).copied();
        words.truncate(words.len() - usize::from(of_name.is_some()));
        // SAMPLERATE is one word of two
        let (last, rest) = words.split_last()?;
        let parted = |kind: &&&str| last.strip_suffix(**kind).is_some_and(|front| TAKING.contains(&front));
        if let Some(kind) = RATES.iter().chain(&STEPS).find(parted) {
            return Sampling::with(kind, true, of_name);
        }
        let at = words.iter().position(|word| is_kind(word))?;
        let kind = words[at];
        match (&words[..at], &words[at + 1..]) {
            ([], []) if rest.is_empty() => Sampling::with(kind, false, of_name),
            ([.., before], []) if TAKING.contains(before) => Sampling::with(kind, true, of_name),
            ([], ["of", behind @ ..] | behind)
                if !behind.is_empty() && behind.iter().all(|word| TAKING.contains(word)) =>
            {
                Sampling::with(kind, true, of_name)
            }
            _ => None,
        }
    }

    /// `None` where the unit in the name is none of what it names.
    fn with(kind: &str, is_certain: bool, unit: Option<(&str, f64)>) -> Option<Sampling> {
        let is_step = STEPS.contains(&kind);
        let fits = |unit: &(&str, f64)| if is_step { OF_STEPS.contains(unit) } else { OF_RATES.contains(unit) };
        unit.as_ref().is_none_or(fits).then_some(Sampling { is_step, is_certain, unit: unit.map(|(_, size)| size) })
    }

    /// Readings a second, by a value in a stated unit, that in the name, or else Hz or s. What is allowed where the unit is none.
    pub fn rate_hz(self, value: f64, unit: Option<&str>) -> Result<f64, &'static str> {
        let known: &[(&str, f64)] = if self.is_step { &OF_STEPS } else { &OF_RATES };
        let size = match unit {
            Some(unit) => known.iter().find(|(name, _)| *name == unit.trim().to_lowercase()).map(|(_, size)| *size),
            None => Some(self.unit.unwrap_or(1.0)),
        };
        match size {
            Some(size) if self.is_step => Ok(1.0 / (value * size)),
            Some(size) => Ok(value * size),
            None if self.is_step => Err(TIME_UNITS),
            None => Err("Hz or kHz"),
        }
    }
}

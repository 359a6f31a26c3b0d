//! Numbers, units, times and lists of tests in words. It knows no findings.

/// A number with the digits that its uncertainty leaves.
pub fn digits(value: f64, sigma: Option<f64>) -> String {
    let scale = sigma.filter(|sigma| sigma.is_finite() && *sigma > 0.0).unwrap_or(value.abs() * 0.01);
    let decimals = (1.0 - scale.abs().max(1e-9).log10().floor()).clamp(0.0, 3.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches('-').chars().all(|c| "0.".contains(c)) {
        text.replace('-', "")
    } else {
        text.replace('-', "−")
    }
}

/// A unit as people write it.
pub fn unit(name: &str) -> &str {
    match name {
        "um" => "µm",
        "um/m" => "µm/m",
        "us2" => "ms²",
        other => other,
    }
}

/// Seconds as people at a machine say them.
pub fn time_words(seconds: f64) -> String {
    match seconds.abs() {
        s if s < 120.0 => format!("{seconds:.0} s"),
        s if s < 7200.0 => format!("{:.1} min", seconds / 60.0),
        _ => format!("{:.1} h", seconds / 3600.0),
    }
}

/// Names of tests, the first few.
pub fn tests_words(tests: &[String], most: usize) -> String {
    let named = tests.iter().take(most).map(String::as_str).collect::<Vec<_>>().join(", ");
    match tests.len().saturating_sub(most) {
        0 => named,
        more => format!("{named} and {more} more"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_their_sigma_leaves() {
        assert_eq!(digits(3.2749, Some(0.14)), "3.27");
        assert_eq!(digits(591.3, Some(267.5)), "591");
        assert_eq!(digits(-0.001, Some(0.5)), "0.00");
        assert_eq!(digits(-12.4, None), "−12.40");
    }

    #[test]
    fn times_are_said_as_at_the_machine() {
        assert_eq!(
            (time_words(45.0).as_str(), time_words(996.3).as_str(), time_words(8640.0).as_str()),
            ("45 s", "16.6 min", "2.4 h")
        );
    }
}

//! Numbers as they are printed: as many digits as are known.

/// Decimals beyond which, and values from which, powers of ten are easier to read.
const MOST_DECIMALS: i32 = 5;
const LARGE: f64 = 1e6;
/// Values below which leading zeros are harder to read than a power of ten.
const SMALL: f64 = 0.01;

/// A value with its standard deviation, both rounded to the deviation's two significant
/// digits: `20.41 ± 0.12 N`. Without a positive standard deviation, as [`plain`].
#[must_use]
pub fn with_std(value: f64, std: f64, unit: &str) -> String {
    if !(value.is_finite() && std.is_finite() && std > 0.0) {
        return plain(value, unit);
    }
    let decimals = 1 - exponent(std, 1);
    let magnitude = value.abs().max(std);
    if (decimals > MOST_DECIMALS && magnitude < SMALL) || magnitude >= LARGE {
        let power = exponent(magnitude, 1);
        let scale = 10_f64.powi(power);
        let digits = (power + decimals).clamp(0, 15) as usize;
        let (v, s) = (value / scale, std / scale);
        return unit_after(format!("({v:.digits$} ± {s:.digits$})e{power}"), unit);
    }
    let round = |x: f64| decimal(x, decimals);
    unit_after(format!("{} ± {}", round(value), round(std)), unit)
}

/// A value with its standard deviation; of one that lies at the edge of what was tried, that.
#[must_use]
pub fn estimate(value: f64, std: f64, unit: &str, at_bound: bool) -> String {
    if at_bound {
        return format!("{} (at the edge of what was tried)", plain(value, unit));
    }
    with_std(value, std, unit)
}

/// A value to three significant digits: `0.00123 m`.
#[must_use]
pub fn plain(value: f64, unit: &str) -> String {
    if value.is_nan() {
        return "not known".to_owned();
    }
    if diverged(value) {
        return "diverges".to_owned();
    }
    if value == 0.0 {
        return unit_after("0".to_owned(), unit);
    }
    let text = match scientific(value) {
        true => format!("{value:.2e}"),
        false => decimal(value, 2 - exponent(value, 2)),
    };
    unit_after(text, unit)
}

/// A value that somebody gave, as it was written: nobody writes more than nine digits, and what comes after them are
/// the errors of a change of units or frames.
#[must_use]
pub fn given(value: f64) -> String {
    format!("{value:.8e}").parse::<f64>().unwrap_or(value).to_string()
}

/// A value before and after, to three significant digits each and in the same notation, so
/// that they compare at a glance: `4.31e-3 → 2.34e-5 m`.
#[must_use]
pub fn change(before: f64, arrow: &str, after: f64, unit: &str) -> String {
    let written = |v: f64| v.is_finite() && !diverged(v) && v != 0.0;
    let powers = [before, after].into_iter().any(|v| written(v) && scientific(v));
    let one = |v: f64| match powers && written(v) {
        true => format!("{v:.2e}"),
        false => plain(v, ""),
    };
    let after = if written(after) { unit_after(one(after), unit) } else { one(after) };
    format!("{} {arrow} {after}", one(before))
}

/// Whether three digits are easier to read with a power of ten.
fn scientific(value: f64) -> bool {
    2 - exponent(value, 2) > MOST_DECIMALS + 1 || value.abs() >= LARGE
}

/// A probability or share in percent, never rounded to a certainty that it is not.
#[must_use]
pub fn percent(share: f64) -> String {
    match share {
        s if s.is_nan() => "not known".to_owned(),
        s if s >= 1.0 => "100 %".to_owned(),
        s if s > 0.999 => "> 99.9 %".to_owned(),
        s if s <= 0.0 => "0 %".to_owned(),
        s if s < 0.001 => "< 0.1 %".to_owned(),
        s if !(0.01..0.99).contains(&s) => format!("{:.1} %", 100.0 * s),
        s => format!("{:.0} %", 100.0 * s),
    }
}

/// Two significant digits, for ratios: `1.1`, `12`, `340`.
#[must_use]
pub fn ratio(value: f64) -> String {
    if value == 0.0 || !value.is_finite() || value.abs() >= LARGE {
        return plain(value, "");
    }
    decimal(value, 1 - exponent(value, 1))
}

/// Whether an error is that of a simulation that diverged: infinite.
#[must_use]
pub fn diverged(value: f64) -> bool {
    value.is_infinite()
}

/// Power of ten of the leading digit after rounding to `digits` more digits: 0.0996 rounds
/// to 0.10 and has -1.
fn exponent(value: f64, digits: usize) -> i32 {
    let text = format!("{value:.digits$e}");
    text.rsplit('e').next().and_then(|e| e.parse().ok()).unwrap_or(0)
}

/// Round to a number of decimals, which may be negative (-2: to hundreds).
fn decimal(value: f64, decimals: i32) -> String {
    let text = match usize::try_from(decimals) {
        Ok(digits) => format!("{value:.digits$}"),
        Err(_) => {
            let step = 10_f64.powi(-decimals);
            format!("{:.0}", (value / step).round() * step)
        }
    };
    let zero = text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.'));
    if zero { text.trim_start_matches('-').to_owned() } else { text }
}

/// The unit after a number; `1` is the unit of pure numbers and stays unwritten.
fn unit_after(number: String, unit: &str) -> String {
    if unit.is_empty() || unit == "1" { number } else { format!("{number} {unit}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_show_the_digits_that_their_deviation_allows() {
        let table = [
            (20.4137, 0.1234, "N", "20.41 ± 0.12 N"),
            (-3.16, 0.04, "N m", "-3.160 ± 0.040 N m"),
            (1234.5, 56.0, "N", "1234 ± 56 N"),
            (123_456.0, 5_600.0, "N/m", "123500 ± 5600 N/m"),
            (0.5, 0.0996, "s", "0.50 ± 0.10 s"),
            (999.96, 0.997, "1", "1000.0 ± 1.0"),
            (0.001_234, 0.000_056, "rad", "(1.234 ± 0.056)e-3 rad"),
            (-0.001, 0.12, "N", "0.00 ± 0.12 N"),
            (2.5e-7, 1.2e-8, "kg", "(2.50 ± 0.12)e-7 kg"),
            (4.2e9, 3.1e7, "Pa", "(4.200 ± 0.031)e9 Pa"),
            (2.5, 0.0, "m", "2.50 m"),
            (2.5, f64::NAN, "m", "2.50 m"),
            (f64::NAN, 0.1, "m", "not known"),
            (3.0, f64::INFINITY, "m", "3.00 m"),
        ];
        for (value, std, unit, expected) in table {
            assert_eq!(with_std(value, std, unit), expected);
        }
    }

    #[test]
    fn values_at_the_edge_of_what_was_tried_have_no_deviation() {
        assert_eq!(estimate(20.4137, 0.1234, "N", false), "20.41 ± 0.12 N");
        let edge = estimate(20.4137, 0.1234, "N", true);
        assert_eq!(edge, "20.4 N (at the edge of what was tried)");
    }

    #[test]
    fn plain_values_have_three_digits() {
        let table = [
            (0.001_234, "0.00123 m"),
            (0.000_001_234, "1.23e-6 m"),
            (12.0, "12.0 m"),
            (12_345.0, "12300 m"),
            (1.234e7, "1.23e7 m"),
            (-0.5, "-0.500 m"),
            (0.0, "0 m"),
            (0.9996, "1.00 m"),
            (f64::INFINITY, "diverges"),
            (f64::INFINITY, "diverges"),
        ];
        for (value, expected) in table {
            assert_eq!(plain(value, "m"), expected);
        }
    }

    #[test]
    fn what_was_given_is_shown_as_it_was_written() {
        let computed = 0.1 * 3.0;
        let table = [(computed, "0.3"), (0.184_923, "0.184923"), (-4.6, "-4.6"), (0.0, "0")];
        for (value, expected) in table {
            assert_eq!(given(value), expected);
        }
        assert_ne!(computed.to_string(), "0.3");
        assert_eq!(given(f64::INFINITY), "inf");
    }

    #[test]
    fn changes_are_written_in_one_notation() {
        let table = [
            (0.0873, 0.0041, "0.0873 -> 0.00410 m"),
            (0.004_31, 2.34e-5, "4.31e-3 -> 2.34e-5 m"),
            (f64::INFINITY, 0.02, "diverges -> 0.0200 m"),
            (0.02, f64::INFINITY, "0.0200 -> diverges"),
            (2e-5, 0.0, "2.00e-5 -> 0"),
        ];
        for (before, after, expected) in table {
            assert_eq!(change(before, "->", after, "m"), expected);
        }
    }

    #[test]
    fn percentages_do_not_round_to_certainty() {
        let table = [
            (0.9996, "> 99.9 %"),
            (0.9954, "99.5 %"),
            (0.976, "98 %"),
            (0.02, "2 %"),
            (0.0004, "< 0.1 %"),
            (0.0, "0 %"),
            (1.0, "100 %"),
            (f64::NAN, "not known"),
        ];
        for (share, expected) in table {
            assert_eq!(percent(share), expected);
        }
    }

    #[test]
    fn ratios_have_two_digits() {
        let table = [(1.08, "1.1"), (11.6, "12"), (344.0, "340"), (0.0, "0"), (0.034, "0.034")];
        for (value, expected) in table {
            assert_eq!(ratio(value), expected);
        }
    }
}

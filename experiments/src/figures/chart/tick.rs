//! Texts beside the ticks of an axis.

use std::ops::Range;

use super::Scale;

/// Text of a tick: as many digits as the range needs, without trailing zeros.
pub(super) fn tick(value: f64, range: &Range<f64>, scale: Scale) -> String {
    let length = range.end - range.start;
    match scale {
        Scale::Linear => decimal(value, 1.5 - length.log10()),
        Scale::Log if length > 4.0 => power_of_ten(value),
        Scale::Log => decimal(10_f64.powf(value), 1.0 - value.floor()),
    }
}

fn decimal(value: f64, digits: f64) -> String {
    let digits = digits.ceil().clamp(0.0, 8.0) as usize;
    let text = format!("{value:.digits$}");
    let short = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    if short == "-0" { "0".into() } else { short.into() }
}

/// `10` with a superscript exponent; nothing between whole powers.
fn power_of_ten(exponent: f64) -> String {
    if (exponent - exponent.round()).abs() > 1e-6 {
        return String::new();
    }
    let superscript = |c: char| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    };
    let text = (exponent.round() as i32).to_string();
    format!("10{}", text.chars().map(superscript).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_say_what_they_mean() {
        assert_eq!(tick(-3.0, &(-13.0..7.0), Scale::Log), "10\u{207b}\u{b3}");
        assert_eq!(tick(0.5, &(-13.0..7.0), Scale::Log), "");
        assert_eq!(tick(0.25, &(0.0..1.0), Scale::Linear), "0.25");
        assert_eq!(tick(-0.0, &(-5.0..5.0), Scale::Linear), "0");
        assert_eq!(tick(20.0, &(0.0..100.0), Scale::Linear), "20");
        assert_eq!(tick(-3.0, &(-3.0..3.0), Scale::Linear), "-3");
        assert_eq!(tick(-0.5, &(-1.0..1.0), Scale::Log), "0.32");
    }
}

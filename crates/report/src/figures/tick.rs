//! Numbers at the axes.

use std::ops::Range;

/// Text of a tick: as many digits as the range needs, without trailing zeros.
pub(super) fn tick(value: f64, range: &Range<f64>) -> String {
    let length = range.end - range.start;
    if value.abs() < 1e-9 * length {
        return "0".to_owned();
    }
    let digits = 1.5 - length.log10();
    let largest = range.start.abs().max(range.end.abs());
    if !(2e-3..1e5).contains(&largest) {
        let digits = (digits + largest.log10()).ceil().clamp(0.0, 9.0) as usize;
        let text = format!("{value:.digits$e}");
        let (number, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{power}", trim(number));
    }
    let digits = digits.ceil().clamp(0.0, 9.0) as usize;
    trim(&format!("{value:.digits$}")).to_owned()
}

fn trim(number: &str) -> &str {
    match number.contains('.') {
        true => number.trim_end_matches('0').trim_end_matches('.'),
        false => number,
    }
}

#[cfg(test)]
mod tests {
    use super::tick;

    #[test]
    fn ticks_have_the_digits_that_the_range_needs() {
        let table = [
            (0.25, 0.0..1.0, "0.25"),
            (-0.0, -5.0..5.0, "0"),
            (20.0, 0.0..100.0, "20"),
            (0.0005, 0.0..0.001, "5e-4"),
            (250_000.0, 0.0..1e6, "2.5e5"),
            (1000.5, 1000.0..1001.0, "1000.5"),
        ];
        for (value, range, expected) in table {
            assert_eq!(tick(value, &range), expected);
        }
    }
}

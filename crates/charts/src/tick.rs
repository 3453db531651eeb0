//! Where the ticks of an axis are, and the texts beside them.

use super::axis::Scale;
use plotters::coord::ranged1d::Ranged;
use plotters::coord::types::RangedCoordf64;
use std::ops::Range;

/// Ticks of a linear axis at most.
const MOST: usize = 6;
/// Powers of ten beyond which nothing is marked between them, and beyond which some are left out.
const FINE: f64 = 2.0;
const COARSE: f64 = 8.0;

/// Places of the ticks along an axis that shows a range of places.
pub(super) fn ticks(range: &Range<f64>, scale: &Scale) -> Vec<f64> {
    let length = range.end - range.start;
    match scale {
        Scale::Linear => RangedCoordf64::from(range.clone()).key_points(MOST),
        Scale::Names(names) => (0..names.len()).map(|k| k as f64).collect(),
        Scale::Log => {
            let powers = range.start.floor() as i32..=range.end.ceil() as i32;
            let every = (length / COARSE).ceil().max(1.0) as i32;
            let between: &[f64] = if length > FINE { &[1.0] } else { &[1.0, 2.0, 5.0] };
            powers
                .filter(|p| p.rem_euclid(every) == 0)
                .flat_map(|p| between.iter().map(move |m| f64::from(p) + m.log10()))
                .filter(|place| (range.start..=range.end).contains(place))
                .collect()
        }
    }
}

/// Text of a tick.
pub(super) fn tick(place: f64, range: &Range<f64>, scale: &Scale) -> String {
    match scale {
        Scale::Linear => linear(place, range),
        Scale::Log => power(place),
        Scale::Names(names) => names.get(place.round() as usize).cloned().unwrap_or_default(),
    }
}

/// As many digits as the range needs, without trailing zeros.
fn linear(value: f64, range: &Range<f64>) -> String {
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

/// A tick of a logarithmic axis: one digit, and a power of ten where zeros are hard to count.
fn power(place: f64) -> String {
    let value = 10_f64.powf(place);
    match (-3.0 - 1e-9..4.0).contains(&place) {
        true => trim(&format!("{value:.3}")).to_owned(),
        false => format!("{value:.0e}"),
    }
}

fn trim(number: &str) -> &str {
    match number.contains('.') {
        true => number.trim_end_matches('0').trim_end_matches('.'),
        false => number,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(tick(value, &range, &Scale::Linear), expected);
        }
        assert!(ticks(&(0.0..1.0), &Scale::Linear).len() <= MOST);
    }

    #[test]
    fn logarithmic_ticks_are_powers_and_few() {
        let texts = |range: Range<f64>| -> Vec<String> {
            let all = ticks(&range, &Scale::Log);
            all.into_iter().map(|place| tick(place, &range, &Scale::Log)).collect()
        };
        assert_eq!(texts(-1.1..0.4), ["0.1", "0.2", "0.5", "1", "2"]);
        assert_eq!(texts(-5.2..-1.9), ["1e-5", "1e-4", "0.001", "0.01"]);
        assert_eq!(texts(-13.0..7.0).len(), 7);
    }

    #[test]
    fn names_stand_at_whole_numbers() {
        let names = Scale::Names(vec!["a".into(), "b".into()]);
        assert_eq!(ticks(&(-0.5..1.5), &names), [0.0, 1.0]);
        assert_eq!(tick(1.0, &(-0.5..1.5), &names), "b");
    }
}

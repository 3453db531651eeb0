//! Unit conversion is inverted by the conversion back, and no text makes the reader panic.

use lacuna_units::{Unit, convert, convert_factor};
use proptest::prelude::*;

/// Units of one kind, each compatible with the others of its row.
const KINDS: &[&[&str]] = &[
    &["rad", "deg", "rev", "1", "%", "mrad"],
    &["rad/s", "deg/s", "rpm", "rev/s", "Hz", "kHz"],
    &["m", "mm", "um", "cm", "in", "ft", "km"],
    &["N m", "Nm", "mNm", "N mm", "kg m^2/s^2", "J", "N m/rad"],
    &["m^2.5/s", "cm^2.5/ms", "(m^5)^0.5/s"],
    &["degC", "K", "degF", "mK"],
    &["kg m^2", "g cm^2", "N m s^2/rad"],
];

fn pair() -> impl Strategy<Value = (&'static str, &'static str)> {
    proptest::sample::select(KINDS).prop_flat_map(|kind| {
        (proptest::sample::select(kind.to_vec()), proptest::sample::select(kind.to_vec()))
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn conversion_back_gives_the_value_again((from, to) in pair(), value in -1e6f64..1e6) {
        let (from, to) = (Unit::parse(from).unwrap(), Unit::parse(to).unwrap());
        let there = convert(&[value], &from, &to).unwrap();
        let back = convert(&there, &to, &from).unwrap()[0];
        // The offsets of temperature scales cost digits of small values.
        prop_assert!((back - value).abs() <= 1e-12 * value.abs() + 1e-9, "{value} {back}");
    }

    #[test]
    fn factors_multiply((from, to) in pair(), power in -3i32..=3) {
        let unit = |text: &str| Unit::parse(&format!("({text})^{power}")).unwrap();
        let whole = convert_factor(&unit(from), &unit(to)).unwrap();
        // In parentheses, as part of a product, temperature scales have no offset.
        let alone = |text: &str| Unit::parse(&format!("({text})")).unwrap();
        let one = convert_factor(&alone(from), &alone(to)).unwrap();
        prop_assert!((whole / one.powi(power) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "[a-zA-Z0-9 */^().µ°²\\-+%Ω]{0,24}|\\PC{0,16}") {
        if let Ok(unit) = Unit::parse(&text) {
            prop_assert_eq!(convert_factor(&unit, &unit), Ok(1.0));
            prop_assert_eq!(Unit::parse(&unit.to_string()), Ok(unit));
        }
    }
}

//! Units as FMUs write them: `N.m`, `kg.m2/s`, `1/min`.

use lacuna_units::Unit;
use roxmltree::Node;

/// The unit in Lacuna's spelling. One that is not known by its name is what its `<BaseUnit>` says, where
/// that is a product of SI units and nothing else; otherwise the name stays as it is.
pub(crate) fn unit(written: &str, definitions: Option<Node<'_, '_>>) -> String {
    let spelled = spell(written);
    if Unit::parse(&spelled).is_ok() {
        return spelled;
    }
    let defined = definitions.and_then(|all| {
        let own = all.children().find(|n| n.attribute("name") == Some(written))?;
        product(own.children().find(|n| n.has_tag_name("BaseUnit"))?)
    });
    defined.unwrap_or(spelled)
}

/// Factors of Modelica are joined by a dot, and all that follows a division is divided by.
fn spell(written: &str) -> String {
    let written = written.trim();
    let Some((above, below)) = written.split_once('/') else { return written.replace('.', " ") };
    let below = below.trim_start_matches('(').trim_end_matches(')');
    match below.contains('.') {
        true => format!("{}/({})", above.replace('.', " "), below.replace('.', " ")),
        false => format!("{}/{below}", above.replace('.', " ")),
    }
}

/// The product of SI units of a `<BaseUnit>` without factor and offset.
fn product(base: Node<'_, '_>) -> Option<String> {
    let number = |name: &str, default: f64| match base.attribute(name) {
        Some(text) => text.parse::<f64>().ok(),
        None => Some(default),
    };
    if number("factor", 1.0)? != 1.0 || number("offset", 0.0)? != 0.0 {
        return None;
    }
    let mut factors = vec![];
    for symbol in ["kg", "m", "s", "A", "K", "mol", "cd", "rad"] {
        match number(symbol, 0.0)? {
            0.0 => {}
            1.0 => factors.push(symbol.to_owned()),
            power => factors.push(format!("{symbol}^{power}")),
        }
    }
    Some(if factors.is_empty() { "1".to_owned() } else { factors.join(" ") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_those_of_lacuna() {
        for (written, expected) in [
            ("N.m", "N m"),
            ("kg.m2", "kg m2"),
            ("rad/s", "rad/s"),
            ("N.m.s/rad", "N m s/rad"),
            ("m3/(s.V)", "m3/(s V)"),
            ("degC", "degC"),
        ] {
            assert_eq!(unit(written, None), expected);
            assert!(Unit::parse(expected).is_ok(), "{expected}");
        }
        let xml = r#"<U><Unit name="torque"><BaseUnit kg="1" m="2" s="-2"/></Unit>
            <Unit name="odd"><BaseUnit m="1" factor="0.3"/></Unit></U>"#;
        let document = roxmltree::Document::parse(xml).expect("XML");
        let definitions = Some(document.root_element());
        assert_eq!(unit("torque", definitions), "kg m^2 s^-2");
        assert_eq!(unit("odd", definitions), "odd");
    }
}

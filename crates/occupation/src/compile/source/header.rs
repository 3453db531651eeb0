//! What the head of a source file says.

use super::super::{Compiled, Representation};

/// Lines without comment signs.
pub(super) fn lines(compiled: &Compiled, mechanism: &Result<usize, String>) -> Vec<String> {
    let names = compiled.names();
    let evaluator = compiled.evaluator();
    let shape = evaluator.shape();
    let mut lines = vec![
        "Written by `lacuna export`: an identified model on a box.".to_owned(),
        String::new(),
        equation(compiled.order()).to_owned(),
        String::new(),
        "Arguments x, in this order, and the box (in the units of the recordings):".to_owned(),
    ];
    for i in 0..shape.arguments {
        let name = names.map_or(format!("x{}", i + 1), |n| n.arguments[i].clone());
        lines.push(format!(
            "  x[{i}] {name}: {:?} .. {:?}",
            evaluator.lower()[i],
            evaluator.upper()[i]
        ));
    }
    if let Some(names) = names {
        lines.push(format!("Coordinates, the rows of f and g: {}", names.coordinates.join(", ")));
        lines.push(format!("Inputs, the columns of g: {}", names.inputs.join(", ")));
    }
    lines.extend([
        String::new(),
        "Functions (g is row-major), largest value on the box, largest error against the identified".to_owned(),
        "model as it was measured on points of the box, and the same relative to the largest value:".to_owned(),
    ]);
    for (k, function) in compiled.functions().iter().enumerate() {
        let place = match k.checked_sub(shape.dimension) {
            None => format!("f[{k}]"),
            Some(k) => format!("g[{k}]"),
        };
        let note = match function.representation {
            Representation::Zero => "  (zero)",
            Representation::Series => "",
            Representation::Landmarks => "  (sum over landmarks)",
        };
        lines.push(format!(
            "  {place} {}: {:.3e}, {:.3e}, {:.1e}{note}",
            function.name(names),
            function.magnitude,
            function.absolute,
            function.relative
        ));
    }
    lines.extend([
        String::new(),
        "Outside the box nothing is extrapolated: f and g are those of its nearest point, and the"
            .to_owned(),
        "return value says so. There is no error bound there.".to_owned(),
    ]);
    lines.push(match mechanism {
        Ok(_) => {
            "M = g_a^-1 and c = -g_a^-1 f_a with the rows of the accelerations: u = M q'' + c."
                .to_owned()
        }
        Err(why) => format!("No M and c for computed torque: {why}."),
    });
    // Names come from files: a line break in one would end the comment.
    let control = |c: char| if c.is_control() { ' ' } else { c };
    lines.iter().map(|line| line.chars().map(control).collect()).collect()
}

fn equation(order: usize) -> &'static str {
    match order {
        1 => "  x' = f(x) + g(x) u",
        2 => "  q'' = f(x) + g(x) u",
        _ => "  the highest derivative = f(x) + g(x) u",
    }
}

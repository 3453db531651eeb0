//! Where elements stand in their parents: `pos`, and one of the ways to say an orientation.

use super::defaults::Part;
use super::settings::Settings;
use crate::algebra::{
    Matrix, Pose, Vector, add, cross, dot, length, product, rotation, scaled, transposed, unit,
};
use crate::robot::RobotError;
use crate::xml::Element;

const AXES: [Vector<f64>; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

pub(super) fn pose(part: &Part, settings: &Settings) -> Result<Pose, RobotError> {
    let translation = part.numbers_or("pos", [0.0; 3])?;
    Ok(Pose { rotation: orientation(part, settings)?, translation })
}

fn orientation(part: &Part, settings: &Settings) -> Result<Matrix<f64>, RobotError> {
    let ways = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];
    let Some((element, way)) = part.stated(&ways) else { return Ok(Pose::SAME.rotation) };
    let direction = |v: Vector<f64>| {
        unit(v).ok_or_else(|| {
            let called = part.own.called();
            element.error(format!("'{way}' of {called} has a direction of length 0"))
        })
    };
    Ok(match way {
        "quat" => quaternion(element)?,
        "axisangle" => {
            let [x, y, z, angle] = element.numbers(way)?;
            rotation(direction([x, y, z])?, angle * settings.angle)
        }
        "xyaxes" => {
            let [a, b, c, d, e, f] = element.numbers(way)?;
            let (x, y) = (direction([a, b, c])?, [d, e, f]);
            let y = direction(add(y, scaled(x, -dot(x, y))))?;
            transposed(&[x, y, cross(x, y)])
        }
        "zaxis" => from_z_directly(direction(element.numbers(way)?)?),
        _ => settings.euler.iter().zip(element.numbers::<3>(way)?).fold(
            Pose::SAME.rotation,
            |before, (turn, angle)| {
                let turned = rotation(AXES[turn.axis], angle * settings.angle);
                if turn.fixed { product(&turned, &before) } else { product(&before, &turned) }
            },
        ),
    })
}

fn quaternion(element: Element) -> Result<Matrix<f64>, RobotError> {
    let [w, x, y, z] = element.numbers("quat")?;
    let length = (w * w + x * x + y * y + z * z).sqrt();
    if length == 0.0 || !length.is_finite() {
        return Err(element.must_be("quat", "a quaternion of a length above 0"));
    }
    let [w, x, y, z] = [w, x, y, z].map(|part| part / length);
    Ok([
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ])
}

/// The least rotation that takes the z axis to a unit vector.
pub(super) fn from_z_directly(to: Vector<f64>) -> Matrix<f64> {
    let about = cross(AXES[2], to);
    // Where it is turned about, any axis across z would do: x, as in MuJoCo.
    rotation(unit(about).unwrap_or(AXES[0]), length(about).atan2(to[2]))
}

/// The elements in a body, in the file's order and with those in its `<frame>`s.
pub(super) fn within(body: Element<'_>) -> Vec<Element<'_>> {
    let (mut open, mut all) = (body.elements().rev().collect::<Vec<_>>(), vec![]);
    while let Some(element) = open.pop() {
        match element.tag() {
            "frame" => open.extend(element.elements().rev()),
            _ => all.push(element),
        }
    }
    all
}

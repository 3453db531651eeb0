//! Inertia of `<geom>`s: of their shapes, evenly filled.

use super::defaults::Part;
use super::frames::{from_z_directly, pose};
use super::settings::Settings;
use crate::Inertia;
use crate::algebra::{Pose, Vector, length, unit};
use crate::robot::RobotError;
use crate::xml::Element;
use std::f64::consts::PI;

/// Density of a geom that does not say its own, kg/m^3.
const DENSITY: f64 = 1000.0;

/// A geom whose inertia follows from its size.
#[derive(Clone, Copy)]
enum Shape {
    Sphere,
    Capsule,
    Cylinder,
    Ellipsoid,
    Box,
}

/// Inertia in the frame that a geom of a body is told in.
pub(super) fn of_geom(
    geom: &Part,
    body: Element,
    settings: &Settings,
) -> Result<Inertia<f64>, RobotError> {
    let [group] = geom.numbers_or("group", [0.0])?;
    let density = geom.positive_or("density", DENSITY)?;
    let [first, last] = settings.groups;
    let weightless = geom.positive_or("mass", density)? == 0.0;
    if group < first || group > last || weightless {
        return Ok(Inertia::none());
    }
    let Some(shape) = shape(geom, body)? else { return Ok(Inertia::none()) };
    let (halves, frame) = match geom.holder("fromto") {
        Some(element) => between(geom, shape, element)?,
        None => (halves(geom, shape)?, pose(geom, settings)?),
    };
    let mass = geom.positive_or("mass", density * shape.volume(halves))?;
    let [xx, yy, zz] = shape.inertia(halves).map(|of_unit| mass * of_unit);
    Ok(Inertia::of_centred(mass, [xx, 0.0, 0.0, yy, 0.0, zz], &frame))
}

/// The shape of a geom; none of one that weighs nothing, whatever is said.
fn shape(geom: &Part, body: Element) -> Result<Option<Shape>, RobotError> {
    let refused = |why: &str| {
        let (called, body) = (geom.own.called(), body.called());
        geom.own.error(format!("{called} {why}: state the <inertial> of {body}"))
    };
    const MESH: &str = "has the inertia of a mesh, and meshes are not opened";
    let shape = match geom.get("type").unwrap_or("sphere") {
        "plane" | "hfield" => return Ok(None),
        "mesh" | "sdf" => return Err(refused(MESH)),
        _ if geom.get("mesh").is_some() => return Err(refused(MESH)),
        _ if geom.get("shellinertia") == Some("true") => return Err(refused("is a shell")),
        "sphere" => Shape::Sphere,
        "capsule" => Shape::Capsule,
        "cylinder" => Shape::Cylinder,
        "ellipsoid" => Shape::Ellipsoid,
        "box" => Shape::Box,
        other => {
            let message = format!(
                "the type of {} is '{other}', which is none of sphere, capsule, cylinder, ellipsoid, box, \
                 plane, hfield, mesh, sdf",
                geom.own.called()
            );
            return Err(geom.holder("type").unwrap_or(geom.own).error(message));
        }
    };
    Ok(Some(shape))
}

/// Half lengths along the axes of a geom's frame.
fn halves(geom: &Part, shape: Shape) -> Result<Vector<f64>, RobotError> {
    Ok(match shape {
        Shape::Sphere => size::<1>(geom).map(|[radius]| [radius; 3])?,
        Shape::Capsule | Shape::Cylinder => {
            size::<2>(geom).map(|[radius, half]| [radius, radius, half])?
        }
        Shape::Ellipsoid | Shape::Box => size(geom)?,
    })
}

/// The same of a geom that reaches from one point to another, and its frame.
fn between(geom: &Part, shape: Shape, fromto: Element) -> Result<(Vector<f64>, Pose), RobotError> {
    if matches!(shape, Shape::Sphere) {
        return Err(fromto.error(format!("{} is a sphere and has a fromto", geom.own.called())));
    }
    let [a, b, c, d, e, f] = fromto.numbers("fromto")?;
    let (middle, along) = ([a + d, b + e, c + f].map(|x| 0.5 * x), [d - a, e - b, f - c]);
    let axis = unit(along).ok_or_else(|| fromto.must_be("fromto", "two points apart"))?;
    let [radius] = size(geom)?;
    let halves = [radius, radius, 0.5 * length(along)];
    Ok((halves, Pose { rotation: from_z_directly(axis), translation: middle }))
}

/// The first numbers of `size`: a shorter list leaves the rest as the class says.
fn size<const N: usize>(geom: &Part) -> Result<[f64; N], RobotError> {
    let mut size: Vec<f64> = vec![];
    for element in geom.all_stated("size").into_iter().rev() {
        let stated = element.list("size")?;
        let rest = size.split_off(stated.len().min(size.len()));
        size = stated.into_iter().chain(rest).collect();
    }
    let needed = size.first_chunk().filter(|halves| halves.iter().all(|s| *s > 0.0));
    needed.copied().ok_or_else(|| {
        let many = if N == 1 { "a number".to_owned() } else { format!("{N} numbers") };
        let called = geom.own.called();
        let message = format!("the size of {called} must be {many} above 0; found {size:?}");
        geom.holder("size").unwrap_or(geom.own).error(message)
    })
}

impl Shape {
    /// Volume of half lengths, m^3: of a cylinder, or of a capsule without its caps, the radius twice
    /// and half the length.
    fn volume(self, [a, b, c]: Vector<f64>) -> f64 {
        match self {
            Self::Sphere => 4.0 / 3.0 * PI * a.powi(3),
            Self::Ellipsoid => 4.0 / 3.0 * PI * a * b * c,
            Self::Box => 8.0 * a * b * c,
            Self::Cylinder => 2.0 * PI * a * a * c,
            Self::Capsule => PI * a * a * (2.0 * c + 4.0 / 3.0 * a),
        }
    }

    /// Principal inertia about the centre of one kilogram, m^2.
    fn inertia(self, [a, b, c]: Vector<f64>) -> [f64; 3] {
        let (aa, bb, cc) = (a * a, b * b, c * c);
        match self {
            Self::Sphere => [0.4 * aa; 3],
            Self::Ellipsoid => [bb + cc, aa + cc, aa + bb].map(|squares| squares / 5.0),
            Self::Box => [bb + cc, aa + cc, aa + bb].map(|squares| squares / 3.0),
            Self::Cylinder => [aa / 4.0 + cc / 3.0, aa / 4.0 + cc / 3.0, aa / 2.0],
            Self::Capsule => {
                // Two half balls, whose centres of mass are 3/8 a beyond the ends, and what is between.
                let ends = 4.0 / 3.0 * a / (4.0 / 3.0 * a + 2.0 * c);
                let [across, _, along] = Self::Cylinder.inertia([a, b, c]);
                let across_ends = 0.4 * aa + cc + 0.75 * a * c;
                let mixed = |between: f64, of_ends: f64| (1.0 - ends) * between + ends * of_ends;
                let across = mixed(across, across_ends);
                [across, across, mixed(along, 0.4 * aa)]
            }
        }
    }
}

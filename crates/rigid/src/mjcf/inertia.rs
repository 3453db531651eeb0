//! How heavy bodies are: `<inertial>`, or else the shapes of `<geom>`s.

use super::defaults::Part;
use super::frames::{from_z_directly, pose};
use super::settings::{FromGeoms, Settings};
use crate::algebra::{Pose, Vector, dot, unit};
use crate::robot::RobotError;
use crate::xml::Element;
use crate::{Inertia, InertialParameters};
use nalgebra::{Matrix3, SymmetricEigen};
use std::f64::consts::PI;

/// Density of a geom that does not say its own, kg/m^3.
const DENSITY: f64 = 1000.0;

/// Inertia of a body in its frame, from its `<inertial>` and its geoms, which stand in frames of it.
pub(super) fn of_body(
    body: Element,
    geoms: &[(Part, Pose)],
    settings: &Settings,
) -> Result<Inertia<f64>, RobotError> {
    let stated = body.child("inertial").filter(|_| settings.from_geoms != FromGeoms::Always);
    let inertia = match stated {
        Some(inertial) => of_inertial(inertial, settings)?,
        None if settings.from_geoms == FromGeoms::Never => Inertia::none(),
        None => {
            let mut whole = Inertia::none();
            for (geom, frame) in geoms {
                let own = of_geom(geom, body, settings)?;
                whole = whole.plus(&own.seen_from_frame(frame));
            }
            whole
        }
    };
    let Inertia { mass, moment, about_origin } = inertia;
    let all = about_origin.iter().flatten().chain(&moment).chain([&mass]);
    if all.into_iter().all(|x| x.is_finite()) {
        return Ok(within_bounds(inertia, settings));
    }
    Err(body.error(format!("the inertia of {} is not finite", body.called())))
}

fn of_inertial(element: Element, settings: &Settings) -> Result<Inertia<f64>, RobotError> {
    let part = Part::alone(element);
    element.attribute("pos")?;
    element.attribute("mass")?;
    let mass = part.positive("mass")?;
    let diagonal = part.numbers_or("diaginertia", [0.0; 3])?;
    let [x, y, z] = diagonal;
    let full = part.numbers_or("fullinertia", [x, y, z, 0.0, 0.0, 0.0])?;
    let [xx, yy, zz, xy, xz, yz] = full;
    if xx.min(yy).min(zz) < 0.0 {
        let message =
            format!("inertia of {} must be 0 or more: {xx}, {yy}, {zz}", element.called());
        return Err(element.error(message));
    }
    let inertia = [xx, xy, xz, yy, yz, zz];
    let about_centre = InertialParameters { mass, centre: [0.0; 3], inertia };
    Ok(about_centre.about_origin().seen_from_frame(&pose(&part, settings)?))
}

/// A geom whose inertia follows from its size.
#[derive(Clone, Copy)]
enum Shape {
    Sphere,
    Capsule,
    Cylinder,
    Ellipsoid,
    Box,
}

fn of_geom(geom: &Part, body: Element, settings: &Settings) -> Result<Inertia<f64>, RobotError> {
    let [group] = geom.numbers_or("group", [0.0])?;
    if group < settings.groups[0] || group > settings.groups[1] || weighs_nothing(geom)? {
        return Ok(Inertia::none());
    }
    let shape = match geom.get("type").unwrap_or("sphere") {
        "plane" | "hfield" => return Ok(Inertia::none()),
        "mesh" | "sdf" => return Err(of_mesh(geom, body)),
        _ if geom.get("mesh").is_some() => return Err(of_mesh(geom, body)),
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
    if geom.get("shellinertia") == Some("true") {
        let (called, body) = (geom.own.called(), body.called());
        return Err(geom.own.error(format!("{called} is a shell: state the <inertial> of {body}")));
    }
    let (size, frame) = placed(geom, shape, settings)?;
    let density = geom.positive_or("density", DENSITY)?;
    let mass = geom.positive_or("mass", density * shape.volume(size))?;
    let [xx, yy, zz] = shape.inertia(size).map(|of_unit| mass * of_unit);
    let inertia = [xx, 0.0, 0.0, yy, 0.0, zz];
    let about_centre = InertialParameters { mass, centre: [0.0; 3], inertia };
    Ok(about_centre.about_origin().seen_from_frame(&frame))
}

fn weighs_nothing(geom: &Part) -> Result<bool, RobotError> {
    let density = geom.positive_or("density", DENSITY)?;
    Ok(geom.positive_or("mass", density)? == 0.0)
}

fn of_mesh(geom: &Part, body: Element) -> RobotError {
    geom.own.error(format!(
        "{} has the inertia of a mesh, and meshes are not opened: state the <inertial> of {}",
        geom.own.called(),
        body.called()
    ))
}

/// The size of a geom, half lengths along the axes of its frame, and where this stands.
fn placed(
    geom: &Part,
    shape: Shape,
    settings: &Settings,
) -> Result<(Vector<f64>, Pose), RobotError> {
    let size = size(geom)?;
    let wrong = |needed: &str| {
        let message =
            format!("the size of {} must be {needed} above 0; found {size:?}", geom.own.called());
        geom.holder("size").unwrap_or(geom.own).error(message)
    };
    let above = |count: usize| size.len() >= count && size[..count].iter().all(|s| *s > 0.0);
    let Some(element) = geom.holder("fromto") else {
        let (needed, said) = match shape {
            Shape::Sphere => (1, "a number"),
            Shape::Capsule | Shape::Cylinder => (2, "2 numbers"),
            Shape::Ellipsoid | Shape::Box => (3, "3 numbers"),
        };
        if !above(needed) {
            return Err(wrong(said));
        }
        let at = |k: usize| size.get(k).copied().unwrap_or(size[0]);
        let halves = match shape {
            Shape::Capsule | Shape::Cylinder => [size[0], size[0], size[1]],
            _ => [size[0], at(1), at(2)],
        };
        return Ok((halves, pose(geom, settings)?));
    };
    let [a, b, c, d, e, f] = element.numbers("fromto")?;
    let (middle, along) = ([a + d, b + e, c + f].map(|x| 0.5 * x), [d - a, e - b, f - c]);
    let axis = unit(along).ok_or_else(|| element.must_be("fromto", "two points apart"))?;
    if !above(1) {
        return Err(wrong("a number"));
    }
    if matches!(shape, Shape::Sphere) {
        return Err(element.error(format!("{} is a sphere and has a fromto", geom.own.called())));
    }
    let halves = [size[0], size[0], 0.5 * dot(along, along).sqrt()];
    Ok((halves, Pose { rotation: from_z_directly(axis), translation: middle }))
}

/// Numbers of `size`: a shorter list leaves the rest as the class says.
fn size(geom: &Part) -> Result<Vec<f64>, RobotError> {
    let mut size: Vec<f64> = vec![];
    for element in geom.all_stated("size").into_iter().rev() {
        let stated = element.list("size")?;
        let rest = size.split_off(stated.len().min(size.len()));
        size = stated.into_iter().chain(rest).collect();
    }
    Ok(size)
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

/// No less than the bounds of `<compiler>` in mass and principal inertia, and one that a body can have
/// if that is asked for.
fn within_bounds(inertia: Inertia<f64>, settings: &Settings) -> Inertia<f64> {
    let parameters = inertia.parameters();
    let mass = parameters.mass.max(settings.least_mass);
    if settings.least_inertia <= 0.0 && !settings.balance {
        return if mass > parameters.mass {
            InertialParameters { mass, ..parameters }.about_origin()
        } else {
            inertia
        };
    }
    let [xx, xy, xz, yy, yz, zz] = parameters.inertia;
    let SymmetricEigen { eigenvectors: axes, eigenvalues: mut principal } =
        SymmetricEigen::new(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz));
    principal.apply(|i| *i = i.max(settings.least_inertia));
    if settings.balance && 2.0 * principal.max() > principal.sum() {
        principal.fill(principal.mean());
    }
    let i = axes * Matrix3::from_diagonal(&principal) * axes.transpose();
    let inertia = [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]];
    InertialParameters { mass, inertia, ..parameters }.about_origin()
}

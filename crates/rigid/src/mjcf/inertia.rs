//! How heavy bodies are: `<inertial>`, or else their `<geom>`s.

use super::defaults::Part;
use super::frames::pose;
use super::geoms::of_geom;
use super::settings::{FromGeoms, Settings};
use crate::algebra::Pose;
use crate::robot::RobotError;
use crate::xml::{Element, check_diagonal};
use crate::{Inertia, InertialParameters};
use nalgebra::{Matrix3, SymmetricEigen};

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
    let [x, y, z] = part.numbers_or("diaginertia", [0.0; 3])?;
    let [xx, yy, zz, xy, xz, yz] = part.numbers_or("fullinertia", [x, y, z, 0.0, 0.0, 0.0])?;
    check_diagonal(element, [xx, yy, zz])?;
    Ok(Inertia::of_centred(mass, [xx, xy, xz, yy, yz, zz], &pose(&part, settings)?))
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

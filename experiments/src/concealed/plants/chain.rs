//! Robots: chains of drawn links and joints, as a URDF.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;

use crate::concealed::effects::{log_uniform, uniform};

/// Share of prismatic joints.
const PRISMATIC: f64 = 0.2;
/// Damping that the file knows of, as a share of a joint's inertia (1/s).
const DAMPED: [f64; 2] = [0.5, 2.0];

/// A solid box beside its joint's axis, lighter and shorter the more links carry it.
struct Link {
    mass: f64,
    sides: [f64; 3],
    centre: [f64; 3],
}

impl Link {
    fn draw(k: usize, rng: &mut ChaCha8Rng) -> Self {
        let mass = uniform(rng, 4.0, 9.0) * 0.6f64.powi(k as i32);
        let length = uniform(rng, 0.25, 0.45) * 0.85f64.powi(k as i32);
        let mut thickness = || uniform(rng, 0.06, 0.12);
        let sides = [thickness(), thickness(), length];
        let mut aside = || uniform(rng, -0.03, 0.03);
        let centre = [aside(), aside(), uniform(rng, 0.35, 0.65) * length];
        Self { mass, sides, centre }
    }

    /// About its own centre.
    fn inertia(&self) -> [f64; 3] {
        let [x, y, z] = self.sides.map(|side| side * side);
        [y + z, x + z, x + y].map(|squares| self.mass * squares / 12.0)
    }

    fn write(&self, name: &str, out: &mut String) -> std::fmt::Result {
        let ([x, y, z], [xx, yy, zz]) = (self.centre, self.inertia());
        writeln!(out, "  <link name=\"{name}\"><inertial>")?;
        writeln!(
            out,
            "    <origin xyz=\"{x:.5} {y:.5} {z:.5}\"/><mass value=\"{:.4}\"/>",
            self.mass
        )?;
        writeln!(
            out,
            "    <inertia ixx=\"{xx:.6}\" ixy=\"0\" ixz=\"0\" iyy=\"{yy:.6}\" iyz=\"0\" izz=\"{zz:.6}\"/>"
        )?;
        writeln!(out, "  </inertial></link>")
    }
}

/// The text of a robot of so many joints, one link after another; no two axes that follow are parallel.
pub fn draw(joints: usize, rng: &mut ChaCha8Rng) -> String {
    let mut out = "<robot name=\"chain\">\n  <link name=\"base_link\"/>\n".to_owned();
    let links: Vec<Link> = (0..joints).map(|k| Link::draw(k, rng)).collect();
    let mut axis = 2;
    for (k, link) in links.iter().enumerate() {
        let parent = if k == 0 { "base_link".to_owned() } else { format!("link{k}") };
        let reach = if k == 0 { 0.2 } else { links[k - 1].sides[2] };
        let slides = rng.random_range(0.0..1.0) < PRISMATIC;
        let kind = if slides { "prismatic" } else { "revolute" };
        let direction = ["1 0 0", "0 1 0", "0 0 1"][axis];
        let turned = uniform(rng, -0.3, 0.3);
        let inertia = link.inertia()[0] + link.mass * link.centre[2].powi(2);
        let damping =
            log_uniform(rng, DAMPED[0], DAMPED[1]) * if slides { link.mass } else { inertia };
        link.write(&format!("link{}", k + 1), &mut out).expect("a string takes all");
        write!(
            out,
            "  <joint name=\"joint{}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"link{}\"/>\n    \
             <origin xyz=\"0 0 {reach:.4}\" rpy=\"0 0 {turned:.4}\"/><axis xyz=\"{direction}\"/>\n    \
             <limit lower=\"-10\" upper=\"10\" effort=\"1000\" velocity=\"100\"/><dynamics damping=\"{damping:.5}\"/>\n  </joint>\n",
            k + 1,
            k + 1,
        )
        .expect("a string takes all");
        axis = (axis + rng.random_range(1..3)) % 3;
    }
    out.push_str("</robot>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::super::ROBOTS;
    use crate::concealed::machine::{self, is_mass};
    use lacuna_excitation::rng;

    /// Whatever is drawn can be read, and has as many joints as were asked for, each with a motor.
    #[test]
    fn a_drawn_robot_is_read() {
        for seed in 0..20 {
            for spec in ROBOTS {
                let (files, model) = machine::draw(spec, &mut rng(seed, 0)).expect("a robot");
                assert_eq!(
                    (model.coordinates.len(), model.inputs.len()),
                    (spec.joints, spec.joints)
                );
                let masses = model.parameters.iter().filter(|p| is_mass(p));
                assert_eq!(masses.filter(|p| p.value > 0.0).count(), spec.joints);
                assert!(files.robot.is_some());
            }
        }
    }
}

//! URDF files that are drawn, with every type of joint.

use super::{drawn_link, spaced};
use lacuna_excitation::rng;
use rand::{Rng, RngExt};

/// A tree of so many joints that move, of every type and among them some that follow others; fixed ones stand
/// between, and links hang from any that is there. A planar joint's normal is z, the only one that Pinocchio knows.
pub fn drawn_every_joint(joints: usize, seed: u64) -> String {
    let mut rng = rng(seed, 3);
    let mut text = format!("<robot name=\"drawn\">\n{}\n", drawn_link(0, &mut rng));
    let (mut of_one, mut moving, mut k) = (vec![], 0, 0);
    while moving < joints {
        let kinds = ["revolute", "continuous", "prismatic", "fixed", "planar", "floating"];
        let kind = if k < kinds.len() { kinds[k] } else { kinds[rng.random_range(0..kinds.len())] };
        moving += usize::from(kind != "fixed");
        let several = matches!(kind, "planar" | "floating");
        let axis = if several { "0 0 1".to_owned() } else { spaced(&three(&mut rng)) };
        let parent = rng.random_range(k / 2..=k);
        let follows = of_one.len() > 2 && rng.random_range(0..4) == 0;
        let mimic = match kind {
            "revolute" | "continuous" | "prismatic" if follows => mimic(&of_one, &mut rng),
            _ => String::new(),
        };
        if matches!(kind, "revolute" | "continuous" | "prismatic") {
            of_one.push(k);
        }
        text += &joint((k, kind), parent, (&axis, &mimic), &mut rng);
        k += 1;
    }
    text + "</robot>\n"
}

/// A tree of so many joints that turn or slide, every third of which follows the one that it hangs from; the others
/// hang from one of the two before.
pub fn drawn_followers(joints: usize, seed: u64) -> String {
    let mut rng = rng(seed, 4);
    let mut text = format!("<robot name=\"drawn\">\n{}\n", drawn_link(0, &mut rng));
    for k in 0..joints {
        let kind = ["revolute", "prismatic"][rng.random_range(0..2)];
        let (axis, follows) = (spaced(&three(&mut rng)), k % 3 == 1);
        let parent = if follows || k == 0 { k } else { k - rng.random_range(0..2) };
        let mimic = if follows { mimic(&[k - 1], &mut rng) } else { String::new() };
        text += &joint((k, kind), parent, (&axis, &mimic), &mut rng);
    }
    text + "</robot>\n"
}

/// A joint and the link that it carries.
fn joint(
    (k, kind): (usize, &str),
    parent: usize,
    (axis, mimic): (&str, &str),
    rng: &mut impl Rng,
) -> String {
    format!(
        "{}<joint name=\"j{k}\" type=\"{kind}\"><parent link=\"l{parent}\"/><child link=\"l{}\"/>\
         <origin xyz=\"{}\" rpy=\"{}\"/><axis xyz=\"{axis}\"/>{mimic}\
         <limit lower=\"-9\" upper=\"9\" effort=\"9\" velocity=\"9\"/></joint>\n",
        drawn_link(k + 1, rng),
        k + 1,
        spaced(&three(rng)),
        spaced(&three(rng)),
    )
}

fn mimic(leaders: &[usize], rng: &mut impl Rng) -> String {
    let leader = leaders[rng.random_range(0..leaders.len())];
    let [multiplier, offset, _] = three(rng);
    format!("<mimic joint=\"j{leader}\" multiplier=\"{multiplier}\" offset=\"{offset}\"/>")
}

fn three(rng: &mut impl Rng) -> [f64; 3] {
    [(); 3].map(|()| rng.random_range(-1.0..1.0))
}

//! The findings of a robot, by kind of physics and by joint.

use crate::words;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::{Finding, Joint, Robot};
use lacuna_effects::Quantity;

/// Findings of one kind on the joints of a robot.
pub(crate) struct Kind<'d> {
    /// `dry friction`, `a payload`: the family of the laws, or the one law.
    pub words: &'static str,
    /// The findings of each joint, in the order of joints.
    pub of_joints: Vec<Vec<&'d Finding>>,
    joints: &'d [Joint],
    quantity: Option<Quantity>,
}

impl<'d> Kind<'d> {
    /// Whether it is missing on each of several joints.
    fn is_everywhere(&self) -> bool {
        self.of_joints.len() > 1 && self.of_joints.iter().all(|of| !of.is_empty())
    }

    /// Whether it is missing on more than one.
    pub fn is_on_several(&self) -> bool {
        self.having().nth(1).is_some()
    }

    /// What is missing where: `dry friction on all six joints`, `on all joints but wrist`, `on shoulder and elbow`.
    pub fn name(&self) -> String {
        /// Of fewer joints those that have it are no longer a list.
        const MANY: usize = 4;
        let joints = self.of_joints.len();
        let lacking = (0..joints).filter(|k| self.of_joints[*k].is_empty()).collect::<Vec<_>>();
        let place = match lacking[..] {
            [] => format!("on {} joints", all(joints)),
            [one] if joints >= MANY => format!("on all joints but {}", self.joints[one].name),
            _ => self.places(),
        };
        format!("{} {place}", self.words)
    }

    /// The channels on which its findings are: `on shoulder and elbow`.
    fn places(&self) -> String {
        let channels: Vec<String> = self.having().map(|of| of[0].channel.clone()).collect();
        let list = words::list(&channels);
        let first = self.findings().next().and_then(|f| lacuna_effects::find(&f.class));
        first.map_or_else(|| format!("on {list}"), |effect| effect.acts.at(&list))
    }

    /// The findings of each joint that has any.
    fn having(&self) -> impl Iterator<Item = &[&'d Finding]> {
        self.of_joints.iter().map(|of| &of[..]).filter(|of| !of.is_empty())
    }

    pub fn findings(&self) -> impl Iterator<Item = &'d Finding> {
        self.of_joints.iter().flatten().copied()
    }
}

/// The kinds of findings on joints, the most important first; none where the model is no robot's.
pub(crate) fn kinds(d: &Diagnosis) -> Vec<Kind<'_>> {
    let mut kinds: Vec<Kind> = vec![];
    let Some(robot) = &d.robot else { return kinds };
    for finding in &d.findings {
        let joint = robot.joints.iter().position(|j| j.has(finding));
        let Some((joint, effect)) = joint.zip(lacuna_effects::find(&finding.class)) else {
            continue;
        };
        let words = effect.nature.kin.map_or(effect.words, |kin| kin.family.words);
        let place = kinds.iter().position(|k| k.words == words).unwrap_or_else(|| {
            let of_joints = vec![vec![]; robot.joints.len()];
            let quantity = effect.nature.stated.map(|s| s.quantity);
            kinds.push(Kind { words, of_joints, joints: &robot.joints, quantity });
            kinds.len() - 1
        });
        kinds[place].of_joints[joint].push(finding);
    }
    kinds
}

/// What a robot's file leaves out everywhere: `The URDF has no friction on any of its six joints.`
pub(crate) fn left_out(d: &Diagnosis) -> Option<String> {
    let robot = d.robot.as_ref()?;
    let quantities = kinds(d).into_iter().filter(Kind::is_everywhere).filter_map(|k| k.quantity);
    let words: Vec<&str> = quantities.filter_map(|q| unstated(robot, q)).collect();
    let any = match robot.joints.len() {
        2 => "either of its two".to_owned(),
        n => format!("any of its {}", count(n)),
    };
    let (format, words) = (&robot.format, words.join(" and no "));
    (!words.is_empty()).then(|| format!("The {format} has no {words} on {any} joints."))
}

/// The words of a quantity that no joint of the file has.
fn unstated(robot: &Robot, quantity: Quantity) -> Option<&'static str> {
    let none = |j: &Joint| j.stated(quantity) == Some(0.0);
    let words = match quantity {
        Quantity::Damping => "damping",
        Quantity::Friction => "friction",
        Quantity::RotorInertia => "rotor inertia",
        Quantity::Stiffness => "spring",
        Quantity::Force | Quantity::Gain => return None,
    };
    robot.joints.iter().all(none).then_some(words)
}

/// `both`, `all six`.
fn all(n: usize) -> String {
    if n == 2 { "both".to_owned() } else { format!("all {}", count(n)) }
}

/// A number in words, while these are short.
fn count(n: usize) -> String {
    const WORDS: [&str; 13] = [
        "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten",
        "eleven", "twelve",
    ];
    WORDS.get(n).map_or_else(|| n.to_string(), |word| (*word).to_owned())
}

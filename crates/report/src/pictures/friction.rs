//! The missing friction of a robot's joints, side by side.

use super::missing_force::{picture, view};
use super::{Drawing, Picture};
use crate::words;
use lacuna_discrepancy::Diagnosis;
use lacuna_discrepancy::diagnosis::{Curve, Joint};

/// The missing force of each joint over its velocity, all of one unit in the same range, so that they
/// compare at a glance; none where no joint has a law over its velocity.
pub(crate) fn friction(d: &Diagnosis) -> Vec<Picture> {
    let joints = d.robot.iter().flat_map(|r| &r.joints);
    let curves: Vec<_> = joints.filter_map(|j| Some((j, curve(d, j)?))).collect();
    if curves.iter().all(|(_, (_, c))| c.law.is_empty()) {
        return vec![];
    }
    let range = |unit: &str| {
        let alike = curves.iter().map(|(_, (_, c))| c).filter(|c| c.force_unit == unit);
        alike.filter_map(view).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    };
    let one = |(joint, (words, curve)): &(&Joint, (String, Curve))| {
        let law = (!curve.law.is_empty()).then_some(words.as_str());
        let mut picture = picture(&joint.name, curve, &format!("{}: {words}", joint.name), law);
        picture.kind = "friction";
        if let Drawing::Figure(figure) = &mut picture.drawing {
            figure.within = range(&curve.force_unit);
        }
        picture
    };
    curves.iter().map(one).collect()
}

/// What recordings show over a joint's velocity, with the sum of the laws over it, and their words: the force
/// that is learned beside each law holds that one, and the others are added. Where no law is named, what is
/// learned before anything is added.
fn curve(d: &Diagnosis, joint: &Joint) -> Option<(String, Curve)> {
    let over = |c: &&Curve| c.variable == joint.velocity;
    let named = d.findings.iter().filter(|f| f.channel == joint.name);
    let mut named = named.filter_map(|f| Some((f, f.curve.as_ref().filter(over)?)));
    let Some((first, curve)) = named.next() else {
        let learned = d.location.channels.get(&joint.name)?.curves.iter().find(over)?;
        return Some(("nothing named".to_owned(), learned.clone()));
    };
    let (mut curve, mut all) = (curve.clone(), vec![words::class_words(first.named_law())]);
    for (finding, other) in named.filter(|(_, other)| other.at == curve.at.clone()) {
        for (sum, part) in [&mut curve.learned, &mut curve.law].into_iter().zip([&other.law; 2]) {
            sum.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
        all.push(words::class_words(finding.named_law()));
    }
    Some((all.join(" and "), curve))
}

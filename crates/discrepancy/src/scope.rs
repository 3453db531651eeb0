//! What a search may name: classes of effects, on all channels or on one.

use crate::DiagnoseError;
use crate::candidates::Candidate;
use lacuna_effects::{CATALOGUE, Law, curve};
use lacuna_plants::Model;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// A class of effects, on all channels or on one: `dead_zone`, `coulomb_friction@q1`. A class holds
/// its variations (`time_friction` is a `coulomb_friction`); a coupling is on both of its channels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selector {
    /// Class of the catalogue.
    pub class: String,
    /// Channel, input or state; all of them where none is named.
    pub channel: Option<String>,
}

/// A text that selects nothing.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("expected CLASS or CLASS@CHANNEL, such as coulomb_friction@q1; found '{found}'")]
pub struct SelectorError {
    /// The text.
    pub found: String,
}

impl FromStr for Selector {
    type Err = SelectorError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (class, channel) = match text.split_once('@') {
            Some((class, channel)) => (class, Some(channel)),
            None => (text, None),
        };
        if class.is_empty() || channel.is_some_and(str::is_empty) {
            return Err(SelectorError { found: text.to_owned() });
        }
        Ok(Self { class: class.to_owned(), channel: channel.map(str::to_owned) })
    }
}

impl fmt::Display for Selector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.channel {
            Some(channel) => write!(f, "{}@{channel}", self.class),
            None => f.write_str(&self.class),
        }
    }
}

impl Selector {
    fn selects(&self, model: &Model, c: &Candidate) -> bool {
        let class = [c.effect.class, c.effect.named_class()].contains(&&*self.class);
        let on = |name: &str| {
            model.effect_channel_name(c.effect, c.channel) == name
                || c.other.is_some_and(|o| model.channel_name(o) == name)
        };
        class && self.channel.as_deref().is_none_or(on)
    }

    /// Check that the class and the channel exist.
    fn check(&self, model: &Model) -> Result<(), DiagnoseError> {
        let classes = CATALOGUE.iter().copied().chain([curve()]);
        let mut classes: Vec<&str> = classes.flat_map(|e| [e.class, e.named_class()]).collect();
        classes.sort_unstable();
        classes.dedup();
        known("effect class", &self.class, &classes)?;
        let states = (0..model.machine_states()).map(|i| model.state_name(i));
        let structures = CATALOGUE.iter().flat_map(|effect| match effect.law {
            Law::Structure(_) => model.structures(effect),
            _ => vec![],
        });
        let inputs = model.inputs.iter().map(|i| &*i.name);
        let channels: Vec<&str> = states.chain(inputs).chain(structures).collect();
        self.channel.as_ref().map_or(Ok(()), |channel| known("channel", channel, &channels))
    }
}

/// What a search may name; everything where nothing is said.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scope {
    /// Nothing but these, where there are any.
    pub only: Vec<Selector>,
    /// None of these.
    pub exclude: Vec<Selector>,
}

impl Scope {
    /// Whether a candidate may be named.
    #[must_use]
    pub fn admits(&self, model: &Model, c: &Candidate) -> bool {
        let any = |list: &[Selector]| list.iter().any(|s| s.selects(model, c));
        (self.only.is_empty() || any(&self.only)) && !any(&self.exclude)
    }

    /// Check that all classes and channels exist.
    ///
    /// # Errors
    /// [`DiagnoseError::Unknown`] with the name that is near, and those that there are.
    pub fn check(&self, model: &Model) -> Result<(), DiagnoseError> {
        self.only.iter().chain(&self.exclude).try_for_each(|s| s.check(model))
    }

    /// What a reader of the diagnosis must know.
    pub(crate) fn notes(&self) -> Vec<String> {
        let list =
            |all: &[Selector]| all.iter().map(Selector::to_string).collect::<Vec<_>>().join(", ");
        let mut notes = vec![];
        if !self.only.is_empty() {
            notes.push(format!(
                "Nothing but {} was looked for, as was asked: other physics may be missing.",
                list(&self.only)
            ));
        }
        if !self.exclude.is_empty() {
            notes.push(format!(
                "Not looked for, as was asked: {}. Another class may stand in its place.",
                list(&self.exclude)
            ));
        }
        notes
    }
}

/// Check that a name is one of those that there are.
pub(crate) fn known(what: &'static str, found: &str, names: &[&str]) -> Result<(), DiagnoseError> {
    if names.contains(&found) {
        return Ok(());
    }
    let known: Vec<String> = names.iter().map(|&n| n.to_owned()).collect();
    let near = lacuna_plants::expression::nearest(found, &known);
    Err(DiagnoseError::Unknown { what, found: found.to_owned(), near, known })
}

#[cfg(test)]
mod tests {
    use super::{Scope, Selector, SelectorError};
    use crate::DiagnoseError;
    use crate::candidates::candidates;
    use lacuna_plants::Model;

    fn model() -> Model {
        let two = Model::builder("two").input("u", "N").input("d", "N");
        let two = two.coordinate("x", "v", "m").coordinate("y", "w", "m");
        two.rates(|at| [at.inputs[0], at.inputs[1]]).build().expect("right")
    }

    fn scope(only: &[&str], exclude: &[&str]) -> Scope {
        let all = |texts: &[&str]| -> Vec<Selector> {
            texts.iter().map(|t| t.parse().expect("a selector")).collect()
        };
        Scope { only: all(only), exclude: all(exclude) }
    }

    /// Class and channel of what a scope admits.
    fn admitted(scope: &Scope) -> Vec<(&'static str, String)> {
        let model = model();
        let all = candidates(&model, &[0, 1]).into_iter().filter(|c| scope.admits(&model, c));
        let name = |c: super::Candidate| model.effect_channel_name(c.effect, c.channel).to_owned();
        all.map(|c| (c.effect.class, name(c))).collect()
    }

    #[test]
    fn a_scope_admits_what_it_says() {
        let all = admitted(&Scope::default());
        let delays = admitted(&scope(&["input_delay"], &["input_delay@d"]));
        assert_eq!(delays, [("input_delay", "u".to_owned())]);
        // A class holds its variations, and a coupling is on both of its channels.
        let excluded = admitted(&scope(&[], &["coulomb_friction@x", "coupling_stiffness@x"]));
        let gone: Vec<_> = all.iter().filter(|c| !excluded.contains(c)).collect();
        assert!(gone.iter().any(|c| c.0 == "coulomb_friction" && c.1 == "x"), "{gone:?}");
        assert!(gone.iter().any(|c| c.0 == "time_friction" && c.1 == "x"), "{gone:?}");
        assert!(gone.iter().any(|c| c.0 == "coupling_stiffness"), "{gone:?}");
        assert!(excluded.iter().any(|c| c.0 == "coulomb_friction" && c.1 == "y"));
        assert_eq!(all.len(), excluded.len() + gone.len());
    }

    #[test]
    fn names_that_do_not_exist_are_told() {
        let check = |text: &str| scope(&[text], &[]).check(&model());
        assert!(check("coulomb_friction@v").is_ok() && check("unknown_function").is_ok());
        match check("dead_zome@u") {
            Err(DiagnoseError::Unknown { what, near, .. }) => {
                assert_eq!((what, near.as_deref()), ("effect class", Some("dead_zone")));
            }
            other => panic!("{other:?}"),
        }
        assert!(matches!(
            check("dead_zone@z"),
            Err(DiagnoseError::Unknown { what: "channel", .. })
        ));
        for text in ["", "@q", "dead_zone@"] {
            let error = SelectorError { found: text.to_owned() };
            assert_eq!(text.parse::<Selector>(), Err(error));
        }
    }
}

//! Named sub-expressions: the `[define]` of a model file.

use super::{Names, Reader, Spanned};
use crate::expression::{Graph, is_function, names_in};
use crate::model::ModelError;
use crate::model::name::check_name;
use indexmap::IndexMap;

/// Names with their expressions, in the file's order, which says nothing.
pub(super) type Definitions = IndexMap<Spanned<String>, Spanned<String>>;

impl Reader<'_> {
    /// That every definition has a name of its own, beside those that are `taken`.
    pub(super) fn check_defined(
        &self,
        definitions: &Definitions,
        taken: &[String],
    ) -> Result<(), ModelError> {
        for name in definitions.keys() {
            let at = |message: String| self.error(name.span(), message);
            check_name(name.get_ref(), taken).map_err(|e| at(e.to_string()))?;
            if is_function(name.get_ref()) {
                let name = name.get_ref();
                return Err(at(format!(
                    "'{name}' is a function: give the definition another name"
                )));
            }
        }
        Ok(())
    }

    /// Read the definitions, those first on which others build, into the names that expressions
    /// may use.
    pub(super) fn define(
        &self,
        definitions: &Definitions,
        graph: &mut Graph,
        names: &mut Names,
    ) -> Result<(), ModelError> {
        let waits: Vec<Vec<usize>> = definitions
            .values()
            .map(|text| names_in(text.get_ref()))
            .map(|used| used.iter().filter_map(|n| definitions.get_index_of(&**n)).collect())
            .collect();
        let entries: Vec<_> = definitions.iter().collect();
        let mut done = vec![false; waits.len()];
        while let Some(next) =
            (0..waits.len()).find(|&k| !done[k] && waits[k].iter().all(|&other| done[other]))
        {
            done[next] = true;
            let (name, text) = entries[next];
            let node = self.expression(text, graph, names)?;
            names.defined.push((name.get_ref().clone(), node));
        }
        match done.iter().position(|done| !done) {
            Some(begin) => Err(self.circle(&entries, &waits, &done, begin)),
            None => Ok(()),
        }
    }

    /// What is wrong with definitions that wait for each other; `begin` is one that waits.
    fn circle(
        &self,
        definitions: &[(&Spanned<String>, &Spanned<String>)],
        waits: &[Vec<usize>],
        done: &[bool],
        begin: usize,
    ) -> ModelError {
        let mut path = vec![begin];
        let from = loop {
            let last = path[path.len() - 1];
            let next = waits[last].iter().copied().find(|&k| !done[k]).unwrap_or(last);
            if let Some(from) = path.iter().position(|&k| k == next) {
                break from;
            }
            path.push(next);
        };
        let name = |k: usize| definitions[k].0.get_ref().as_str();
        let around: Vec<&str> =
            path[from..].iter().chain(&path[from..=from]).map(|&k| name(k)).collect();
        let message = format!(
            "'{}' is defined by itself ({}): a definition may only use what can be computed before it",
            around[0],
            around.join(" needs ")
        );
        self.error(definitions[path[from]].0.span(), message)
    }
}

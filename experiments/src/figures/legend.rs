//! Recipes in legends: the same words and the same colour in every figure.

use lacuna_charts::Colour;

use crate::recipes::Recipe;

/// A recipe in words; its own name where it is none of [`Recipe::ALL`].
pub(super) fn words(name: &str) -> &str {
    match find(name) {
        Some(Recipe::Paper) => "paper's recipe",
        Some(Recipe::Lacuna) => "Lacuna",
        Some(Recipe::Sindyc) => "SINDYc",
        Some(Recipe::Wsindy) => "weak SINDy",
        None => name,
    }
}

/// Its colour; ink is the truth's.
pub(super) fn colour(name: &str) -> Colour {
    match find(name) {
        Some(Recipe::Paper) => Colour::Vermilion,
        Some(Recipe::Lacuna) => Colour::Blue,
        Some(Recipe::Sindyc) => Colour::Green,
        Some(Recipe::Wsindy) | None => Colour::Purple,
    }
}

fn find(name: &str) -> Option<Recipe> {
    Recipe::ALL.into_iter().find(|r| r.name() == name)
}

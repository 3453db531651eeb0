//! Pages and summaries of made-up diagnoses of the kinds that occur.

mod cases;
mod page;
mod summary;

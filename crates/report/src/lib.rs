//! Pictures, pages and words of a diagnosis

//! Studies.
fn main() {}

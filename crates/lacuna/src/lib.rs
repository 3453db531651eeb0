//! Finds the physics that a simulator leaves out

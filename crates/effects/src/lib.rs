//! The catalogue of physical effects, each once, as a force law with units

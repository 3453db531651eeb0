//! Figures of the studies, as SVG.

pub mod chart;
pub mod duffing;
pub mod manipulator;
pub mod regulator;

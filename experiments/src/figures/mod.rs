//! Figures of the studies, as SVG.

pub mod chart;
pub mod concealed;
pub mod duffing;
pub mod manipulator;
pub mod noise_sweep;
pub mod regulator;

//! Control occupation kernel regression: drift and control effectiveness from whole trajectories

//! Computed torque and closed loops on true or identified models

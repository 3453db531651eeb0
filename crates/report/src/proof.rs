//! Series that prove a diagnosis.

/// One measured channel of a held-out recording with the model's free run before and after.
/// All series have the length of `time`; what goes beyond the shortest is not drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Proof {
    /// Name of the recording.
    pub recording: String,
    /// Measured channel.
    pub channel: String,
    /// Its unit.
    pub unit: String,
    /// Time (s).
    pub time: Vec<f64>,
    /// What was measured.
    pub measured: Vec<f64>,
    /// What the model as it was says.
    pub before: Vec<f64>,
    /// What the augmented model says.
    pub after: Vec<f64>,
    /// Of a force, the motion that was imposed: what it is drawn against.
    pub imposed: Vec<Imposed>,
}

/// Motion that was imposed on the machine: a position or a velocity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Imposed {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its values, as long as the series that it belongs to.
    pub values: Vec<f64>,
}

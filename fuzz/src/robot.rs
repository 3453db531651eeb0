//! Robots' files, URDF and MJCF.

/// Neither may panic, whatever the text is.
pub fn survive(text: &str) {
    if let Ok(robot) = lacuna::rigid::read(text) {
        let _ = robot.tree(&[]);
    }
}

//! Robots' files, URDF and MJCF.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    if let Ok(robot) = lacuna::rigid::read(text) {
        let _ = robot.tree(&[]);
    }
});

//! Reading, noise and smoothing of published recordings of real machines.

mod shared;

use std::path::Path;

use lacuna_recordings::{
    Recording, RecordingSource, Sampling, Smoother, estimate_noise, estimate_noise_pooled,
};

fn read(folder: &Path, name: &str) -> Recording {
    let source: RecordingSource = folder.join(name).display().to_string().parse().unwrap();
    lacuna_recordings::read(&source, "t_s").unwrap()
}

#[test]
fn published_recordings_are_read() {
    let Some(real) = shared::folder("real") else { return };
    let emps = read(&real, "emps/emps_train.csv");
    assert_eq!((emps.len(), emps.columns.len()), (24_841, 4));
    assert!(Sampling::of(&emps.time).uniform);
    let arrow = read(&real, "silverbox/silverbox_SNLS80mV.csv#rows=100..40575");
    assert_eq!(arrow.len(), 40_475);
    assert!((arrow.time[0] - 0.16384).abs() < 1e-12);
    assert!((Sampling::of(&arrow.time).step - 0.0016384).abs() < 1e-12);
    let tanks = read(&real, "cascaded_tanks/cascaded_tanks_test.csv");
    assert_eq!((tanks.len(), Sampling::of(&tanks.time).step), (1024, 4.0));
    let pendulum = shared::sorted_entries(&real.join("dfki_double_pendulum"));
    let files = pendulum.iter().filter(|file| file.extension() == Some("csv".as_ref()));
    for run in files.map(|file| read(&real, &file.display().to_string())) {
        let sampling = Sampling::of(&run.time);
        assert_eq!(run.columns.len(), 8, "{}", run.name);
        assert!((sampling.step - 0.002).abs() < 1e-5 && sampling.jitter < 0.05, "{}", run.name);
    }
}

#[test]
fn emps_velocity_is_that_of_a_positioning_system() {
    let Some(folder) = shared::folder("real/emps") else { return };
    let run = read(&folder, "emps_train.csv");
    let position = run.column("q_m").unwrap();
    let noise = estimate_noise(&run.time, position).unwrap();
    // Load-side position on a grid of 5e-8 m: at least the noise of that rounding.
    assert!((1.4e-8..4e-8).contains(&noise.sd), "{noise:?}");
    let smoothed = Smoother::fit(&run.time, position, noise.sd).unwrap().at(&run.time);
    // Central differences over 20 ms, an independent and much coarser look.
    for k in (1000..24_000).step_by(500) {
        let difference =
            (position[k + 10] - position[k - 10]) / (run.time[k + 10] - run.time[k - 10]);
        let curvature = 0.01 * smoothed.second[k].abs();
        assert!((smoothed.first[k] - difference).abs() < 1e-3 + curvature, "row {k}");
    }
}

#[test]
fn silverbox_noise_is_not_the_multisine() {
    let Some(folder) = shared::folder("real/silverbox") else { return };
    let run = read(&folder, "silverbox_SNLS80mV.csv#rows=40650..127400");
    let noise = estimate_noise(&run.time, run.column("y_V").unwrap()).unwrap();
    // The best published model simulates this part to 0.3 mV; sixth differences say 1.0 mV.
    assert!(noise.sd < 1e-4, "{noise:?}");
}

#[test]
fn double_pendulum_encoders_are_seen() {
    let Some(folder) = shared::folder("real/dfki_double_pendulum") else { return };
    let names = ["143906", "144003", "144115"].map(|at| format!("dpC1_20230629-{at}.csv"));
    let runs = names.map(|name| read(&folder, &name));
    let pooled: Vec<(&[f64], &[f64])> =
        runs.iter().map(|run| (&run.time[..], run.column("q2_rad").unwrap())).collect();
    let quantum = estimate_noise_pooled(&pooled).unwrap().quantum.unwrap();
    // The drives send 16 bits for -12.5 rad to 12.5 rad.
    assert!((quantum - 25.0 / 65535.0).abs() < 1e-8, "{quantum}");
}

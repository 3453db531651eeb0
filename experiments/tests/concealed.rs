//! The generator of the proof on concealed physics.

use experiments::concealed::case::{Case, plans};
use experiments::concealed::sealed::Group;

#[test]
#[ignore]
fn survey() {
    for group in Group::ALL {
        for plan in plans(3, 32, Some(group)) {
            let begin = std::time::Instant::now();
            let case = Case::draw(3, &plan);
            let seconds = begin.elapsed().as_secs_f64();
            match case {
                Ok(c) => println!(
                    "{:?} {:<24} {:<16} {:<16} {seconds:5.1} s model gap {:7.1} effects {:?}",
                    group,
                    c.sealed.topic,
                    c.sealed.plant,
                    c.sealed.drive,
                    c.sealed.model_gap_over_noise,
                    c.sealed
                        .effects
                        .iter()
                        .map(|e| format!(
                            "{}@{} {:.1} {}",
                            e.name.class,
                            e.name.channel,
                            e.gap_over_noise,
                            e.accept.len()
                        ))
                        .collect::<Vec<_>>()
                ),
                Err(e) => println!("{group:?} {:<24} {seconds:.1} s {e}", plan.topic.words()),
            }
        }
    }
}

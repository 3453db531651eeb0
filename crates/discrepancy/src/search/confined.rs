//! Further laws that do what they do only where a law with an edge acts.
//!
//! In a stop a machine is pushed harder than anywhere else, and no stop is its formula's to a twentieth. Whatever else
//! acts there and nowhere else (an actuator that saturates, a spring that hardens) takes up what that formula leaves,
//! and recordings cannot tell it from a stop of another form.

use super::Search;
use crate::likelihood::{Fit, Hypothesis};
use lacuna_plants::model::{ModelEffect, System};

impl Search<'_> {
    /// Whether the last effect of a fit, which has no edge of its own, moves the machine, but for a twentieth, only
    /// where effects with an edge do.
    pub(super) fn is_confined(&self, fit: &Fit) -> bool {
        let h = &fit.hypothesis;
        let Some((last, others)) = h.effects.split_last() else { return false };
        let edges: Vec<ModelEffect> =
            others.iter().filter(|e| e.effect.nature.edge).cloned().collect();
        if edges.is_empty() || last.effect.nature.edge {
            return false;
        }
        let mut shares = vec![Share::default(); self.problem.model.machine_states()];
        for r in 0..self.problem.dataset.recordings.len() {
            let [bare, at_edges, by_last] = [&[][..], &edges, std::slice::from_ref(last)]
                .map(|effects| self.rates_along(h, effects, r));
            let samples = bare.iter().zip(&at_edges).zip(&by_last);
            for ((bare, at_edges), by_last) in samples {
                let acts = bare.iter().zip(at_edges).any(|(bare, edge)| bare != edge);
                for (share, (bare, by_last)) in shares.iter_mut().zip(bare.iter().zip(by_last)) {
                    share.add((by_last - bare).powi(2), acts);
                }
            }
        }
        shares.retain(|share| share.all > 0.0);
        let confined = |share: &Share| share.elsewhere <= self.decision.relevant * share.all;
        !shares.is_empty() && shares.iter().all(confined)
    }

    /// Rates of the machine's state at each sample of a recording's own motion, beside some effects.
    fn rates_along(&self, h: &Hypothesis, effects: &[ModelEffect], r: usize) -> Vec<Vec<f64>> {
        let system = System::with(self.problem.model, &h.parameters, effects);
        self.problem.measured_motion(effects, r).rates_of(&system)
    }
}

/// Squares by which an effect changes a rate.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    all: f64,
    /// Where no effect with an edge acts.
    elsewhere: f64,
}

impl Share {
    fn add(&mut self, square: f64, acts: bool) {
        self.all += square;
        if !acts {
            self.elsewhere += square;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Search, first_level};
    use crate::likelihood::{Fit, Hypothesis, Problem};
    use crate::{Dataset, Decision, Scope, Watch};
    use lacuna_plants::Model;
    use lacuna_recordings::{Column, Recording};

    const MODEL: &str = "name = \"slider\"\n[[input]]\nname = \"u\"\nunit = \"N\"\n\
        [[coordinate]]\nname = \"q\"\nvelocity = \"v\"\nunit = \"m\"\n\
        [mechanics]\nmass = [[\"1\"]]\nforce = [\"u - q\"]\n";
    const STOP: &str = "[[effect]]\nclass = \"end_stop\"\nchannel = \"q\"\nstiffness = 50\n\
        position = 0.6\nside = 1\n";

    /// A slow sweep through a stop at 0.6, pushed hard in it and as softly as anywhere else on the other side.
    fn recording() -> Recording {
        let time: Vec<f64> = (0..400).map(|k| 0.02 * f64::from(k)).collect();
        let q: Vec<f64> = time.iter().map(|t| 0.7 * (0.9 * t).sin()).collect();
        let u = q.iter().map(|q| q + 50.0 * (q - 0.6).max(0.0)).collect();
        let column = |name: &str, values| Column { name: name.into(), values };
        Recording { name: "run".into(), columns: vec![column("q", q), column("u", u)], time }
    }

    fn is_confined(effects: &str) -> bool {
        let model = Model::from_text(MODEL, "slider.toml").expect("a model");
        let with = Model::from_text(&format!("{MODEL}{effects}"), "slider.toml").expect("effects");
        let dataset = Dataset::new(&model, &[recording()]).expect("a dataset");
        let problem = Problem::new(&model, &dataset).expect("a problem");
        let (scope, watch) = (Scope::default(), Watch::default());
        let search = Search::new(&problem, Decision::default(), &scope, &watch);
        let mut h = Hypothesis::of(&model).held();
        for effect in &with.effects {
            h = h.with(effect.clone(), &problem.scales_of(effect));
        }
        let fit = Fit::begin(&problem, h, first_level(&dataset)).expect("a fit");
        search.is_confined(&fit)
    }

    #[test]
    fn what_acts_in_a_stop_alone_is_its_formula() {
        let on_input = |limit: f64| {
            format!("[[effect]]\nclass = \"saturation\"\nchannel = \"u\"\nlimit = {limit}\n")
        };
        let drag = "[[effect]]\nclass = \"viscous_friction\"\nchannel = \"q\"\ncoefficient = 0.1\n";
        // Beyond 2 N only the stop is pushed, beyond 0.3 N all is.
        assert!(is_confined(&format!("{STOP}{}", on_input(2.0))));
        assert!(!is_confined(&format!("{STOP}{}", on_input(0.3))));
        assert!(!is_confined(&format!("{STOP}{drag}")));
        // Without a stop there is nothing to be taken for it, and a second stop has an edge of its own.
        assert!(!is_confined(&on_input(2.0)));
        assert!(!is_confined(&format!("{STOP}{STOP}")));
    }
}

//! What an actuator makes of commands that are held from sample to sample, in continuous time.

use lacuna_plants::Input;

/// An imperfect actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Actuator {
    /// The command times a gain.
    Gain(f64),
    /// Nothing within half a width of zero.
    DeadZone(f64),
    /// No more than a limit.
    Saturation(f64),
    /// The command of so many seconds ago.
    Delay(f64),
    /// A first-order lag with this time constant (s).
    Lag(f64),
}

impl Actuator {
    /// The actuator of a class of the catalogue.
    pub fn of(class: &str, parameter: f64) -> Option<Self> {
        Some(match class {
            "gain_error" => Self::Gain(parameter),
            "dead_zone" => Self::DeadZone(parameter),
            "saturation" => Self::Saturation(parameter),
            "input_delay" => Self::Delay(parameter),
            "actuator_lag" => Self::Lag(parameter),
            _ => return None,
        })
    }
}

/// The effective inputs from one sample to the next.
pub struct Step {
    from: f64,
    courses: Vec<Course>,
    breakpoints: Vec<f64>,
}

/// One effective input within a step.
#[derive(Clone, Copy, Debug)]
enum Course {
    Constant(f64),
    Jump { at: f64, before: f64, after: f64 },
    Relaxation { from: f64, to: f64, time_constant: f64 },
}

impl Input for Step {
    fn value(&self, start: f64, t: f64, u: &mut [f64]) {
        for (u, course) in u.iter_mut().zip(&self.courses) {
            *u = match *course {
                Course::Constant(value) => value,
                // The side on which the integration step began; it does not reach across.
                Course::Jump { at, before, after } => {
                    let slack = 1e-9 * (1.0 + at.abs());
                    if start < at - slack { before } else { after }
                }
                Course::Relaxation { from, to, time_constant } => {
                    to + (from - to) * (-(t - self.from) / time_constant).exp()
                }
            };
        }
    }

    fn breakpoints(&self) -> &[f64] {
        &self.breakpoints
    }
}

/// The actuators of all inputs with what they remember.
#[derive(Clone, Debug)]
pub struct Actuators {
    of_input: Vec<Option<Actuator>>,
    /// Commands so far, one row a sample.
    history: Vec<Vec<f64>>,
    /// What lags have reached.
    reached: Vec<f64>,
    step: f64,
}

impl Actuators {
    /// Actuators of inputs that are sampled every `step` seconds.
    pub fn new(of_input: Vec<Option<Actuator>>, step: f64) -> Self {
        let reached = vec![0.0; of_input.len()];
        Self { of_input, history: Vec::new(), reached, step }
    }

    /// The effective inputs from sample `history.len()` on, under a new command. What was
    /// commanded before the recording began is its first command.
    pub fn advance(&mut self, command: &[f64]) -> Step {
        let sample = self.history.len();
        if sample == 0 {
            self.reached.copy_from_slice(command);
        }
        self.history.push(command.to_vec());
        let from = sample as f64 * self.step;
        let mut breakpoints = Vec::new();
        let mut courses = Vec::with_capacity(command.len());
        for (j, &u) in command.iter().enumerate() {
            let course = match self.of_input[j] {
                None => Course::Constant(u),
                Some(Actuator::Gain(gain)) => Course::Constant(gain * u),
                Some(Actuator::DeadZone(w)) => Course::Constant(u - u.clamp(-w, w)),
                Some(Actuator::Saturation(limit)) => Course::Constant(u.clamp(-limit, limit)),
                Some(Actuator::Delay(delay)) => self.delayed(j, sample, from, delay),
                Some(Actuator::Lag(time_constant)) => {
                    let before = self.reached[j];
                    self.reached[j] = u + (before - u) * (-self.step / time_constant).exp();
                    Course::Relaxation { from: before, to: u, time_constant }
                }
            };
            if let Course::Jump { at, .. } = course {
                breakpoints.push(at);
            }
            courses.push(course);
        }
        breakpoints.sort_by(f64::total_cmp);
        Step { from, courses, breakpoints }
    }

    fn delayed(&self, input: usize, sample: usize, from: f64, delay: f64) -> Course {
        let whole = (delay / self.step).floor();
        let command = |ago: usize| self.history[sample.saturating_sub(ago)][input];
        let at = from + delay - whole * self.step;
        Course::Jump { at, before: command(whole as usize + 1), after: command(whole as usize) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of an effective input over each step, by fine sampling.
    fn means(actuator: Actuator, commands: &[f64]) -> Vec<f64> {
        let mut actuators = Actuators::new(vec![Some(actuator)], 0.1);
        let mean = |(k, u): (usize, &f64)| {
            let step = actuators.advance(&[*u]);
            let fine = (0..1000).map(|i| 0.1 * (k as f64 + (f64::from(i) + 0.5) / 1000.0));
            let value = |t: f64| {
                let mut out = [0.0];
                step.value(t, t, &mut out);
                out[0]
            };
            fine.map(value).sum::<f64>() / 1000.0
        };
        commands.iter().enumerate().map(mean).collect()
    }

    /// The catalogue's laws give the means of the same actuators over each step.
    #[test]
    fn actuators_agree_with_the_catalogue() {
        let commands: Vec<f64> = (0..40).map(|k| (0.7 * f64::from(k)).sin() + 0.3).collect();
        let times: Vec<f64> = (0..40).map(|k| 0.1 * f64::from(k)).collect();
        let cases = [
            ("gain_error", 1.2),
            ("dead_zone", 0.4),
            ("saturation", 0.6),
            ("input_delay", 0.23),
            ("actuator_lag", 0.17),
        ];
        for (class, parameter) in cases {
            let actuator = Actuator::of(class, parameter).unwrap();
            let effect = lacuna_effects::find(class).unwrap();
            let lacuna_effects::Law::Input(law) = effect.law else { panic!("{class}") };
            let parameters =
                if class == "actuator_lag" { vec![parameter, 1.0] } else { vec![parameter] };
            let expected = law.plain().applied(&parameters, &times, &commands);
            for (k, (found, expected)) in
                means(actuator, &commands).iter().zip(expected).enumerate()
            {
                assert!((found - expected).abs() < 2e-3, "{class} {k}: {found} {expected}");
            }
        }
    }
}

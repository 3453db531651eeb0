//! What is compared, and who is closer.

/// Errors that differ by less than this share of the larger are the same.
const SAME: f64 = 0.05;

/// Which of two models is closer to what was measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closer {
    /// The first.
    A,
    /// The second.
    B,
    /// Neither: the errors differ by less than 5 %.
    Neither,
}

impl Closer {
    /// By their rms errors, infinite where a model diverges.
    #[must_use]
    pub fn of(a: f64, b: f64) -> Self {
        match (a, b) {
            _ if a < (1.0 - SAME) * b => Self::A,
            _ if b < (1.0 - SAME) * a => Self::B,
            _ => Self::Neither,
        }
    }

    /// `A`, `B` or `same`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::Neither => "same",
        }
    }
}

/// The errors of one channel over all recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedChannel {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Standard deviation of the noise.
    pub noise: f64,
    /// Rms error of the first model, infinite where it diverges.
    pub a: f64,
    /// Rms error of the second model.
    pub b: f64,
}

/// One channel of one recording with both models' runs.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedSeries {
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
    /// What the first model says.
    pub a: Vec<f64>,
    /// What the second model says.
    pub b: Vec<f64>,
    /// Rms errors of both in this recording.
    pub rmse: [f64; 2],
}

/// Two models against the same recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// What the first model is called.
    pub a: String,
    /// What the second model is called.
    pub b: String,
    /// How they were run: `running free from the first 50 samples`.
    pub how: String,
    /// Errors of each channel.
    pub channels: Vec<ComparedChannel>,
    /// What is drawn.
    pub series: Vec<ComparedSeries>,
}

impl Comparison {
    /// Who is closer, in one line: `B is closer in q and dq`.
    #[must_use]
    pub fn headline(&self) -> String {
        let within = |closer| {
            let names = self.channels.iter().filter(|c| Closer::of(c.a, c.b) == closer);
            names.map(|c| c.name.as_str()).collect::<Vec<_>>()
        };
        let said = |name: &str, closer| match within(closer).as_slice() {
            [] => None,
            channels => Some(format!("{name} is closer in {}", channels.join(", "))),
        };
        let parts: Vec<String> =
            [said(&self.a, Closer::A), said(&self.b, Closer::B)].into_iter().flatten().collect();
        match parts.as_slice() {
            [] => format!("{} and {} are equally close", self.a, self.b),
            parts => parts.join("; "),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(crate) fn comparison(errors: &[(&str, f64, f64)]) -> Comparison {
        let channel = |&(name, a, b): &(&str, f64, f64)| ComparedChannel {
            name: name.into(),
            unit: "m".into(),
            noise: 0.01,
            a,
            b,
        };
        Comparison {
            a: "a.toml".into(),
            b: "<b>.toml".into(),
            how: "running free".into(),
            channels: errors.iter().map(channel).collect(),
            series: vec![],
        }
    }

    #[test]
    fn the_closer_model_is_named_for_each_channel() {
        let headline = |errors: &[_]| comparison(errors).headline();
        let apart = [("x", 1.0, 2.0), ("y", f64::INFINITY, 2.0), ("z", 1.0, 1.04)];
        assert_eq!(headline(&apart), "a.toml is closer in x; <b>.toml is closer in y");
        let same = [("x", 1.0, 1.0), ("y", f64::INFINITY, f64::INFINITY), ("z", 0.0, 0.0)];
        assert_eq!(headline(&same), "a.toml and <b>.toml are equally close");
    }
}

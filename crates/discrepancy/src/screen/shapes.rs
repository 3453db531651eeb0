//! The search for the shape of a law.

/// The box in which shapes are refined, from the grid that was screened: logarithmic where
/// all values are positive.
pub(super) struct Bounds {
    low: Vec<f64>,
    high: Vec<f64>,
    logarithmic: Vec<bool>,
    step: Vec<f64>,
    fixed: Vec<bool>,
}

impl Bounds {
    pub(super) fn of(grid: &[Vec<f64>]) -> Self {
        let d = grid.first().map_or(0, Vec::len);
        let mut this =
            Self { low: vec![], high: vec![], logarithmic: vec![], step: vec![], fixed: vec![] };
        for k in 0..d {
            let mut values: Vec<f64> = grid.iter().map(|s| s[k]).collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            let positive = values[0] > 0.0;
            let map = |v: f64| if positive { v.ln() } else { v };
            let (low, high) = (map(values[0]), map(values[values.len() - 1]));
            // A sign (of an end stop's side) is no magnitude to refine.
            let fixed = values.iter().all(|v| v.abs() == 1.0) || values.len() == 1;
            let step = (high - low) / values.len() as f64;
            // One step of the grid beyond its ends: further off a law is another law.
            let room = (high - low) / (values.len().max(2) - 1) as f64;
            this.low.push(low - room);
            this.high.push(high + room);
            this.logarithmic.push(positive);
            this.step.push(0.5 * step);
            this.fixed.push(fixed);
        }
        this
    }

    pub(super) fn coordinates(&self, shape: &[f64]) -> Vec<f64> {
        (0..shape.len())
            .map(|k| if self.logarithmic[k] { shape[k].ln() } else { shape[k] })
            .collect()
    }

    pub(super) fn shape(&self, x: &[f64]) -> Vec<f64> {
        (0..x.len())
            .map(|k| {
                let v = x[k].clamp(self.low[k], self.high[k]);
                if self.logarithmic[k] { v.exp() } else { v }
            })
            .collect()
    }

    pub(super) fn steps(&self) -> Vec<f64> {
        (0..self.step.len()).map(|k| if self.fixed[k] { 0.0 } else { self.step[k] }).collect()
    }
}

/// Nelder and Mead's simplex search; coordinates with a step of 0 stay.
pub(super) fn simplex(
    cost: &dyn Fn(&[f64]) -> f64,
    start: &[f64],
    steps: &[f64],
    most: usize,
) -> Vec<f64> {
    let mut points = vec![(cost(start), start.to_vec())];
    for k in (0..start.len()).filter(|&k| steps[k] != 0.0) {
        let mut x = start.to_vec();
        x[k] += steps[k];
        points.push((cost(&x), x));
    }
    let d = points.len() - 1;
    if d == 0 {
        return start.to_vec();
    }
    for _ in 0..most {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if points[d].0 - points[0].0 < 0.05 {
            break;
        }
        let centre: Vec<f64> = (0..start.len())
            .map(|k| points[..d].iter().map(|p| p.1[k]).sum::<f64>() / d as f64)
            .collect();
        let worst = points[d].1.clone();
        let at = |share: f64| -> Vec<f64> {
            centre.iter().zip(&worst).map(|(c, w)| c + share * (c - w)).collect()
        };
        let try_at = |share: f64| {
            let x = at(share);
            (cost(&x), x)
        };
        let reflected = try_at(1.0);
        points[d] = if reflected.0 < points[0].0 {
            let expanded = try_at(2.0);
            if expanded.0 < reflected.0 { expanded } else { reflected }
        } else if reflected.0 < points[d - 1].0 {
            reflected
        } else {
            let contracted = try_at(if reflected.0 < points[d].0 { 0.5 } else { -0.5 });
            if contracted.0 < points[d].0.min(reflected.0) {
                contracted
            } else {
                let best = points[0].1.clone();
                for p in &mut points[1..] {
                    let x: Vec<f64> = p.1.iter().zip(&best).map(|(x, b)| 0.5 * (x + b)).collect();
                    *p = (cost(&x), x);
                }
                continue;
            }
        };
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points.swap_remove(0).1
}

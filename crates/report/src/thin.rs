//! Long series, thinned for drawing without losing a peak.

/// Points that a drawn series keeps at most.
pub const POINTS: usize = 1500;

/// The smallest and the largest value of each of `most / 2` stretches of equally many samples,
/// in the order of time; all points where there are no more than `most`. A stretch without a
/// finite value keeps one that is not, so that a gap remains a gap.
#[must_use]
pub fn thin(time: &[f64], values: &[f64], most: usize) -> Vec<(f64, f64)> {
    let points: Vec<(f64, f64)> = time.iter().copied().zip(values.iter().copied()).collect();
    if points.len() <= most.max(2) {
        return points;
    }
    let stretch = points.len().div_ceil((most / 2).max(1));
    points.chunks(stretch).flat_map(extremes).collect()
}

fn extremes(stretch: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let finite = || stretch.iter().enumerate().filter(|(_, p)| p.1.is_finite());
    let low = finite().min_by(|a, b| a.1.1.total_cmp(&b.1.1)).map(|(k, _)| k);
    let high = finite().max_by(|a, b| a.1.1.total_cmp(&b.1.1)).map(|(k, _)| k);
    let (Some(low), Some(high)) = (low, high) else {
        return stretch.first().copied().into_iter().collect();
    };
    let mut kept = vec![low.min(high), low.max(high)];
    kept.dedup();
    kept.into_iter().map(|k| stretch[k]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_survive_thinning() {
        let time: Vec<f64> = (0..100_000).map(|k| f64::from(k) * 1e-3).collect();
        let mut values: Vec<f64> = time.iter().map(|t| t.sin()).collect();
        values[54_321] = 7.0;
        values[54_322] = -8.0;
        let kept = thin(&time, &values, POINTS);
        assert!(kept.len() <= POINTS && kept.len() > POINTS / 2);
        assert!(kept.contains(&(time[54_321], 7.0)));
        assert!(kept.contains(&(time[54_322], -8.0)));
        assert!(kept.windows(2).all(|w| w[0].0 < w[1].0));
    }

    #[test]
    fn short_series_and_gaps_stay() {
        assert_eq!(thin(&[0.0, 1.0], &[2.0, 3.0], POINTS), [(0.0, 2.0), (1.0, 3.0)]);
        let values = [[1.0; 10], [f64::NAN; 10], [2.0; 10]].concat();
        let time: Vec<f64> = (0..30).map(f64::from).collect();
        let kept = thin(&time, &values, 6);
        assert!(kept.iter().any(|p| p.1.is_nan()) && kept.iter().any(|p| p.1 == 2.0));
    }
}

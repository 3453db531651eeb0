//! Recorded inputs between their samples, computed once for all fits.

use super::Window;
use lacuna_plants::InputPath;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Most numbers that are kept (64 MiB).
const MOST: usize = 1 << 23;

/// A recording, the range of a window, Runge-Kutta steps a sample.
type Key = (usize, (usize, usize), usize);

/// Paths along windows that were asked for. Those that are nothing but the samples are not kept.
#[derive(Default)]
pub(super) struct Paths {
    kept: Mutex<Kept>,
}

#[derive(Default)]
struct Kept {
    paths: HashMap<Key, Arc<InputPath<'static, f64>>>,
    numbers: usize,
}

impl Paths {
    /// The path along a window with so many steps a sample, made where it is not known.
    pub(super) fn along<'s>(
        &self,
        w: &Window,
        substeps: usize,
        make: impl FnOnce() -> InputPath<'s, f64>,
    ) -> Arc<InputPath<'s, f64>> {
        let key = (w.recording, (w.range.start, w.range.end), substeps);
        if let Some(known) = self.known(&key) {
            return known;
        }
        let path = make();
        let numbers = path.computed();
        if numbers == 0 || numbers > MOST {
            return Arc::new(path);
        }
        let path = Arc::new(path.into_owned());
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        // Searches go on to windows of other lengths: what was kept for those before is let go.
        if kept.numbers + numbers > MOST {
            *kept = Kept::default();
        }
        if kept.paths.insert(key, path.clone()).is_none() {
            kept.numbers += numbers;
        }
        path
    }

    fn known(&self, key: &Key) -> Option<Arc<InputPath<'static, f64>>> {
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.paths.get(key).cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST, Paths, Window};
    use lacuna_plants::Hold;

    /// What is between samples is computed once; what is kept stays below its bound.
    #[test]
    fn paths_are_made_once_and_let_go() {
        let length = MOST / 8;
        let times: Vec<f64> = (0..length).map(|k| k as f64).collect();
        let values: Vec<f64> = times.iter().map(|t| (0.1 * t).sin()).collect();
        let paths = Paths::default();
        let mut made = 0;
        let mut numbers = 0;
        for k in [0, 0, 1, 2, 3, 4, 4, 0] {
            let range = k..length - 9 + k;
            let w = Window { recording: 0, range: range.clone() };
            let path = paths.along(&w, 1, || {
                made += 1;
                Hold::BandLimited.along((&times, &values), range.clone(), 1, 1)
            });
            assert_eq!(path.sample(3), &values[3 + k..4 + k]);
            numbers = paths.kept.lock().expect("nothing panicked").numbers;
            assert!(numbers >= path.computed() && numbers <= MOST, "{numbers}");
        }
        assert_eq!(made, 6);
        assert!(numbers > 0);
        let held = Window { recording: 0, range: 0..10 };
        let path = paths.along(&held, 1, || Hold::Linear.along((&times, &values), 0..10, 1, 1));
        assert_eq!(path.computed(), 0);
        assert_eq!(paths.kept.lock().expect("nothing panicked").numbers, numbers);
    }
}

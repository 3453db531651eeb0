//! Who waits for a diagnosis: is told what is being done, and can call it off or bound its time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Who waits for a diagnosis.
pub struct Watch<'a> {
    progress: &'a (dyn Fn(&str) + Sync),
    cancelled: &'a AtomicBool,
    budget: Option<Budget>,
}

/// Time after which a search ends with what it has.
struct Budget {
    length: Duration,
    end: Instant,
    /// Whether what is under way is done however late it is: without it there is no diagnosis.
    necessary: AtomicBool,
    /// What was not tried, or not to the end, because it was late.
    untried: Mutex<Vec<&'static str>>,
}

/// Nobody calls off what is not watched.
static NEVER: AtomicBool = AtomicBool::new(false);

impl<'a> Watch<'a> {
    /// `progress` is told what is being done; the work ends soon after `cancelled` is set, with
    /// [`crate::DiagnoseError::Cancelled`].
    #[must_use]
    pub fn new(progress: &'a (dyn Fn(&str) + Sync), cancelled: &'a AtomicBool) -> Self {
        Self { progress, cancelled, budget: None }
    }

    /// The same for a search that ends `length` from now with the best that it has found by then. The
    /// diagnosis of that is complete: what it needs to be proved and told is done however late it is.
    #[must_use]
    pub fn within(self, length: Duration) -> Self {
        let (necessary, untried) = (AtomicBool::new(false), Mutex::new(vec![]));
        // A budget beyond the end of clocks is none.
        let end = Instant::now().checked_add(length);
        let budget = end.map(|end| Budget { length, end, necessary, untried });
        Self { budget, ..self }
    }

    /// Tell what is being done.
    pub fn tell(&self, doing: &str) {
        (self.progress)(doing);
    }

    /// Whether the work is called off.
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Whether the search's time is over.
    pub(crate) fn is_late(&self) -> bool {
        let late = |b: &Budget| !b.necessary.load(Ordering::Relaxed) && Instant::now() >= b.end;
        self.budget.as_ref().is_some_and(late)
    }

    /// Whether the search's time is over before something is done; it is remembered what.
    pub(crate) fn skips(&self, what: &'static str) -> bool {
        let late = self.is_late();
        if let (true, Some(budget)) = (late, &self.budget) {
            let mut untried = budget.untried.lock().unwrap_or_else(PoisonError::into_inner);
            if !untried.contains(&what) {
                untried.push(what);
            }
        }
        late
    }

    /// Work without which there is no diagnosis, done however late it is.
    pub(crate) fn necessarily<T>(&self, work: impl FnOnce() -> T) -> T {
        let Some(budget) = &self.budget else { return work() };
        let before = budget.necessary.swap(true, Ordering::Relaxed);
        let done = work();
        budget.necessary.store(before, Ordering::Relaxed);
        done
    }

    /// What a reader of the diagnosis must know of a search whose time was over.
    pub(crate) fn note(&self) -> Option<String> {
        let budget = self.budget.as_ref()?;
        let untried = budget.untried.lock().unwrap_or_else(PoisonError::into_inner);
        (!untried.is_empty()).then(|| {
            format!(
                "The time budget of {} s ended the search: this is the best that it had found. Not \
                 tried, or not to the end: {}.",
                budget.length.as_secs_f64(),
                untried.join("; ")
            )
        })
    }
}

impl Default for Watch<'_> {
    /// Tells nobody, and runs to the end.
    fn default() -> Self {
        Self { progress: &|_| (), cancelled: &NEVER, budget: None }
    }
}

#[cfg(test)]
mod tests {
    use super::Watch;
    use std::time::Duration;

    #[test]
    fn what_is_late_is_remembered_once_and_what_is_necessary_is_never_late() {
        let watch = Watch::default().within(Duration::ZERO);
        assert!(watch.is_late() && !watch.is_cancelled());
        let inside = watch.necessarily(|| watch.necessarily(|| watch.skips("a")) | watch.is_late());
        assert!(!inside && watch.note().is_none());
        assert!(watch.skips("b") && watch.skips("c") && watch.skips("b"));
        let note = watch.note().expect("late");
        assert!(note.contains("budget of 0 s") && note.ends_with("to the end: b; c."), "{note}");
    }

    #[test]
    fn nobody_is_late_without_a_budget_or_within_it() {
        for watch in [Watch::default(), Watch::default().within(Duration::MAX)] {
            assert!(!watch.is_late() && !watch.skips("a"));
            assert_eq!(watch.note(), None);
        }
    }
}

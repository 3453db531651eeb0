//! Who waits for a diagnosis: is told what is being done, and can call it off.

use std::sync::atomic::{AtomicBool, Ordering};

/// Who waits for a diagnosis.
pub struct Watch<'a> {
    progress: &'a (dyn Fn(&str) + Sync),
    cancelled: &'a AtomicBool,
}

/// Nobody calls off what is not watched.
static NEVER: AtomicBool = AtomicBool::new(false);

impl<'a> Watch<'a> {
    /// `progress` is told what is being done; the work ends soon after `cancelled` is set, with
    /// [`crate::DiagnoseError::Cancelled`].
    #[must_use]
    pub fn new(progress: &'a (dyn Fn(&str) + Sync), cancelled: &'a AtomicBool) -> Self {
        Self { progress, cancelled }
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

    /// What is set when the work is called off.
    #[must_use]
    pub fn cancelled(&self) -> &'a AtomicBool {
        self.cancelled
    }
}

impl Default for Watch<'_> {
    /// Tells nobody, and runs to the end.
    fn default() -> Self {
        Self { progress: &|_| (), cancelled: &NEVER }
    }
}

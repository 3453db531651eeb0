//! Long work that Python waits for: it can be interrupted, and says what it does.

use crate::function::Raised;
use lacuna::discrepancy::Watch;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// How often it is asked whether a signal has come.
const POLL: Duration = Duration::from_millis(50);

/// Do some work in a thread of its own without Python's lock, while this thread looks for signals and
/// hands on what the work says. Whatever `progress` or a signal raises, and what the function of the
/// model has `raised`, calls the work off and is raised in its place.
pub fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    raised: &Raised,
    work: impl FnOnce(Watch<'_>) -> T + Send,
) -> PyResult<T> {
    let cancelled = AtomicBool::new(false);
    let (says, said) = channel::<String>();
    let token = &cancelled;
    let (done, stopped) = py.detach(move || {
        thread::scope(move |scope| {
            let worker = scope.spawn(move || {
                // Nobody listens any more once the work is called off.
                let progress = |doing: &str| drop(says.send(doing.to_owned()));
                work(Watch::new(&progress, token))
            });
            let stopped = wait(&said, progress, raised, token);
            (worker.join(), stopped)
        })
    });
    // A panic goes on as it would have without a thread.
    let done = done.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
    match raised.take().or(stopped) {
        Some(error) => Err(error),
        None => Ok(done),
    }
}

/// Until the work is done, look for what calls it off.
fn wait(
    said: &Receiver<String>,
    progress: Option<&Py<PyAny>>,
    raised: &Raised,
    cancelled: &AtomicBool,
) -> Option<PyErr> {
    let mut stopped = None;
    loop {
        let doing = match said.recv_timeout(POLL) {
            Ok(doing) => Some(doing),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => return stopped,
        };
        if stopped.is_none() {
            stopped = Python::attach(|py| attend(py, progress, doing)).err();
        }
        if stopped.is_some() || raised.is_some() {
            cancelled.store(true, Ordering::Relaxed);
        }
    }
}

fn attend(py: Python<'_>, progress: Option<&Py<PyAny>>, doing: Option<String>) -> PyResult<()> {
    py.check_signals()?;
    if let (Some(progress), Some(doing)) = (progress, doing) {
        progress.call1(py, (doing,))?;
    }
    Ok(())
}

//! Decoders of others that panic on files that are damaged: such a panic ends here. Readers of our own are not contained,
//! for a panic of theirs is a defect.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use crate::error::RecordingError;
use crate::source::RecordingSource;

thread_local! {
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// What a reader makes of a source with a decoder that may give up by a panic. Nothing is printed of a panic that ends here;
/// others go the way they went before.
///
/// # Errors
/// Those of the reader, and [`RecordingError::Broken`] in the place of a panic.
pub(crate) fn contained<T>(
    format: &'static str,
    source: &RecordingSource,
    decode: impl FnOnce() -> Result<T, RecordingError>,
) -> Result<T, RecordingError> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |panic| {
            if !CONTAINED.get() {
                before(panic);
            }
        }));
    });
    let outer = CONTAINED.replace(true);
    // What was half decoded is dropped.
    let decoded = catch_unwind(AssertUnwindSafe(decode));
    CONTAINED.set(outer);
    decoded.unwrap_or_else(|panic| {
        let reason =
            format!("its decoder gave up ({}): the file is damaged", message(panic.as_ref()));
        let file = source.path.display().to_string();
        Err(RecordingError::Broken { file, format, reason })
    })
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::contained;
    use crate::source::RecordingSource;

    #[test]
    fn a_panic_is_an_error_with_its_message() {
        let source = RecordingSource::file("run.tape");
        let third =
            |list: &[u8]| contained("Tape", &source, || Ok(list[2])).map_err(|e| e.to_string());
        assert_eq!(third(&[0, 1, 2]), Ok(2));
        let said = third(&[0]).unwrap_err();
        assert!(said.starts_with("run.tape cannot be read as Tape: "), "{said}");
        assert!(said.contains("index out of bounds"), "{said}");
    }
}

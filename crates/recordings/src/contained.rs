//! Decoders of others, some of which panic on files that are damaged: such a panic ends here.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static CONTAINED: Cell<bool> = const { Cell::new(false) };
}

/// What a decoder makes of a file, or what it said when it gave up. Nothing is printed of a panic that ends here; others go
/// the way they went before.
///
/// # Errors
/// The message of a panic within.
pub(crate) fn contained<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
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
    decoded.map_err(|panic| message(panic.as_ref()))
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::contained;

    #[test]
    fn a_panic_is_an_error_with_its_message() {
        assert_eq!(contained(|| 3), Ok(3));
        let third = |list: &[u8]| contained(|| list[2]);
        assert_eq!(third(&[0, 1, 2]), Ok(2));
        assert!(third(&[0]).is_err_and(|e| e.contains("index out of bounds")));
        assert_eq!(
            contained(|| contained(|| panic!("within")).map(|()| 1)),
            Ok(Err("within".into()))
        );
    }
}

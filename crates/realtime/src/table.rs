//! Tables that are borrowed, or owned where there is an allocator.

use core::ops::Deref;

/// A slice that is borrowed (from flash memory, say) or owned.
#[derive(Debug, Clone, PartialEq)]
pub enum Table<'a, T> {
    /// Borrowed.
    Borrowed(&'a [T]),
    /// Owned.
    #[cfg(feature = "alloc")]
    Owned(alloc::vec::Vec<T>),
}

impl<T> Deref for Table<'_, T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match self {
            Self::Borrowed(slice) => slice,
            #[cfg(feature = "alloc")]
            Self::Owned(vector) => vector,
        }
    }
}

#[cfg(feature = "alloc")]
impl<T> From<alloc::vec::Vec<T>> for Table<'_, T> {
    fn from(vector: alloc::vec::Vec<T>) -> Self {
        Self::Owned(vector)
    }
}

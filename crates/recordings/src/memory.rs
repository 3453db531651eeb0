//! How much memory a file may make a reader take: compressed data can claim to be of any size.

use crate::error::RecordingError;

/// Bytes that any file may take.
const ALWAYS: u64 = 1 << 30;
/// Bytes that a file may take for each of its own.
const PER_BYTE: u64 = 64;
/// Largest piece that is decompressed at once, in bytes.
pub(crate) const LARGEST_PIECE: u64 = 1 << 29;

/// The memory that is left for what a file holds.
pub(crate) struct Budget {
    file: String,
    allowed: u64,
    taken: u64,
}

impl Budget {
    /// For a file of so many bytes.
    pub fn of(file: &str, bytes: u64) -> Self {
        let allowed = ALWAYS.max(bytes.saturating_mul(PER_BYTE));
        Self { file: file.into(), allowed, taken: 0 }
    }

    /// Takes the memory of so many numbers that are kept.
    pub fn take_numbers(&mut self, numbers: u64) -> Result<(), RecordingError> {
        self.taken = self.taken.saturating_add(numbers.saturating_mul(size_of::<f64>() as u64));
        self.within(self.taken, self.allowed)
    }

    /// That a piece that is decompressed at once is of a bearable size.
    pub fn check_piece(&self, bytes: u64) -> Result<(), RecordingError> {
        self.within(bytes, LARGEST_PIECE)
    }

    fn within(&self, needed: u64, allowed: u64) -> Result<(), RecordingError> {
        if needed <= allowed {
            return Ok(());
        }
        Err(RecordingError::TooLarge { file: self.file.clone(), needed, allowed })
    }
}

//! The recording itself: channels against time.

use lacuna_units::names::nearest;

use crate::error::RecordingError;

/// One recorded channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name, from the header line.
    pub name: String,
    /// One value per time, in the unit of the file; NaN where the sample is missing.
    pub values: Vec<f64>,
}

/// Measured channels and inputs against time. NaN marks a missing sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// File name, followed by the selection where only a part was read.
    pub name: String,
    /// Times in seconds, strictly increasing.
    pub time: Vec<f64>,
    /// All columns but time, in the order of the file.
    pub columns: Vec<Column>,
}

impl Recording {
    /// The values of the column called `name`, one per time.
    ///
    /// # Errors
    /// [`RecordingError::NoSuchColumn`] lists the columns that exist and the nearest name.
    pub fn column(&self, name: &str) -> Result<&[f64], RecordingError> {
        match self.columns.iter().find(|column| column.name == name) {
            Some(column) => Ok(&column.values),
            None => Err(self.no_such_column(name)),
        }
    }

    /// The values of all columns but time, in their order.
    pub(crate) fn values(&self) -> impl Iterator<Item = &[f64]> {
        self.columns.iter().map(|column| &column.values[..])
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    fn no_such_column(&self, wanted: &str) -> RecordingError {
        let available: Vec<String> = self.columns.iter().map(|c| c.name.clone()).collect();
        RecordingError::NoSuchColumn {
            recording: self.name.clone(),
            wanted: wanted.into(),
            suggestion: nearest(wanted, available.iter().map(String::as_str)).map(Into::into),
            available,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_column_is_answered_with_the_known_ones() {
        let column = |name: &str| Column { name: name.into(), values: vec![1.0] };
        let recording = Recording {
            name: "run.csv".into(),
            time: vec![0.0],
            columns: vec![column("theta"), column("tau")],
        };
        assert_eq!(recording.column("tau").unwrap(), [1.0]);
        let said = recording.column("thta").unwrap_err().to_string();
        assert_eq!(
            said,
            "recording run.csv has no column 'thta' (did you mean 'theta'?); its columns are: \
             theta, tau"
        );
    }
}

//! Reader of NumPy archives, for the reference data.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// An array of a NumPy archive, its values in row-major order.
pub struct Array {
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
}

/// The folder of reference data beside the repository, or a message that the test is skipped.
pub fn reference_folder() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/reference");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no reference data at {}", folder.display());
    None
}

/// The array `name` of an .npz archive.
pub fn read_npz(path: &Path, name: &str) -> Array {
    let mut archive = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
    let array = npyz::NpyFile::new(&bytes[..]).unwrap();
    let shape: Vec<usize> = array.shape().iter().map(|&length| length as usize).collect();
    let column_major = array.order() == npyz::Order::Fortran;
    let values: Vec<f64> = array.into_vec().unwrap();
    let values = if column_major { row_major(&shape, &values) } else { values };
    Array { shape, values }
}

/// Values of a column-major array in row-major order.
fn row_major(shape: &[usize], values: &[f64]) -> Vec<f64> {
    let position = |mut flat: usize| {
        let mut index = vec![0; shape.len()];
        for axis in (0..shape.len()).rev() {
            index[axis] = flat % shape[axis];
            flat /= shape[axis];
        }
        let strides = shape.iter().scan(1, |stride, length| {
            let own = *stride;
            *stride *= length;
            Some(own)
        });
        index.iter().zip(strides).map(|(i, stride)| i * stride).sum::<usize>()
    };
    (0..values.len()).map(|flat| values[position(flat)]).collect()
}

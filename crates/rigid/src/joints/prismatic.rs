//! A joint that slides along its axis.

use crate::algebra::{Matrix, Pose, Vector};
use lacuna_numbers::Number;

#[inline(always)]
pub(super) fn frame<T: Number>(at_zero: &Pose, q: T) -> (Matrix<T>, Vector<T>) {
    let (fixed, place) = (&at_zero.rotation, at_zero.translation);
    let slid = std::array::from_fn(|k| q * fixed[k][2] + place[k]);
    (fixed.map(|row| row.map(T::constant)), slid)
}

pub(super) fn moved(axis: Vector<f64>, at: f64) -> Pose {
    Pose { translation: axis.map(|z| z * at), ..Pose::SAME }
}

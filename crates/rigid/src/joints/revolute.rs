//! A joint that turns about its axis.

use crate::algebra::{Matrix, Pose, Vector, add, rotation, scaled, times};
use lacuna_numbers::Number;

#[inline(always)]
pub(super) fn frame<T: Number>(at_zero: &Pose, q: T) -> (Matrix<T>, Vector<T>) {
    let (sine, cosine) = q.sin_cos();
    let turned = at_zero
        .rotation
        .map(|[x, y, z]| [cosine * x + sine * y, cosine * y + sine * -x, T::constant(z)]);
    (turned, at_zero.translation.map(T::constant))
}

pub(super) fn moved(axis: Vector<f64>, anchor: Vector<f64>, at: f64) -> Pose {
    let rotation = rotation(axis, at);
    let swung = times(&rotation, anchor);
    Pose { rotation, translation: add(anchor, scaled(swung, -1.0)) }
}

//! Vectors and rotations in three dimensions, in any number.

use lacuna_numbers::Number;

/// A vector.
pub type Vector<T> = [T; 3];
/// A matrix by its rows.
pub type Matrix<T> = [[T; 3]; 3];

#[inline(always)]
pub(crate) fn add<T: Number>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn sub<T: Number>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn scaled<T: Number>(a: Vector<T>, by: T) -> Vector<T> {
    [a[0] * by, a[1] * by, a[2] * by]
}

#[inline(always)]
pub(crate) fn dot<T: Number>(a: Vector<T>, b: Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn length(a: Vector<f64>) -> f64 {
    dot(a, a).sqrt()
}

/// The unit vector along a vector; none along one whose length is 0 or no number.
pub(crate) fn unit(a: Vector<f64>) -> Option<Vector<f64>> {
    let length = length(a);
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}

#[inline(always)]
pub(crate) fn cross<T: Number>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a x (0, 0, b)`.
#[inline(always)]
pub(crate) fn cross_z<T: Number>(a: Vector<T>, b: T) -> [T; 2] {
    [a[1] * b, -(a[0] * b)]
}

/// `m a`.
#[inline(always)]
pub(crate) fn times<T: Number>(m: &Matrix<T>, a: Vector<T>) -> Vector<T> {
    [dot(m[0], a), dot(m[1], a), dot(m[2], a)]
}

/// `m^T a`.
#[inline(always)]
pub(crate) fn transposed_times<T: Number>(m: &Matrix<T>, a: Vector<T>) -> Vector<T> {
    add(add(scaled(m[0], a[0]), scaled(m[1], a[1])), scaled(m[2], a[2]))
}

/// `a b` of matrices.
#[inline(always)]
pub(crate) fn product<T: Number>(a: &Matrix<T>, b: &Matrix<T>) -> Matrix<T> {
    [transposed_times(b, a[0]), transposed_times(b, a[1]), transposed_times(b, a[2])]
}

#[inline(always)]
pub(crate) fn transposed<T: Copy>(m: &Matrix<T>) -> Matrix<T> {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

/// The rotation about a unit vector z by an angle: `1 + s K + (1 - c) K^2` with K = z x.
#[inline(always)]
pub(crate) fn rotation<T: Number>(z: Vector<f64>, angle: T) -> Matrix<T> {
    let (sine, cosine) = angle.sin_cos();
    let versine = -cosine + 1.0;
    let k = [[0.0, -z[2], z[1]], [z[2], 0.0, -z[0]], [-z[1], z[0], 0.0]];
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let (same, square) = if i == j { (1.0, z[i] * z[i] - 1.0) } else { (0.0, z[i] * z[j]) };
            sine * k[i][j] + versine * square + same
        })
    })
}

/// A rotation that takes the z axis to a unit vector.
pub(crate) fn from_z(to: Vector<f64>) -> Matrix<f64> {
    // Any axis across both would do: that of the two coordinate axes which is further off.
    let help = if to[0].abs() < 0.5 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let across = cross(help, to);
    let x = scaled(across, 1.0 / length(across));
    transposed(&[x, cross(to, x), to])
}

/// Where a frame stands in another: `x_there = rotation x_here + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Axes of the frame, as columns.
    pub rotation: Matrix<f64>,
    /// Its origin, m.
    pub translation: Vector<f64>,
}

impl Pose {
    /// The same frame.
    pub const SAME: Self = Self {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// A frame at a place, turned by roll, pitch and yaw about the fixed axes x, y and z (rad).
    #[must_use]
    pub fn of_roll_pitch_yaw(translation: Vector<f64>, [roll, pitch, yaw]: Vector<f64>) -> Self {
        let x = rotation([1.0, 0.0, 0.0], roll);
        let y = rotation([0.0, 1.0, 0.0], pitch);
        let z = rotation([0.0, 0.0, 1.0], yaw);
        Self { rotation: product(&z, &product(&y, &x)), translation }
    }

    /// Where the other frame stands in this one.
    #[must_use]
    pub(crate) fn inverse(&self) -> Self {
        let rotation = transposed(&self.rotation);
        Self { rotation, translation: scaled(times(&rotation, self.translation), -1.0) }
    }

    /// A direction of the frame that this one stands in, as it is seen from this one.
    #[must_use]
    pub fn turned_back(&self, direction: Vector<f64>) -> Vector<f64> {
        transposed_times(&self.rotation, direction)
    }

    /// A frame that stands so in this one, as it stands where this one does.
    #[must_use]
    pub fn then(&self, inner: &Self) -> Self {
        let moved = times(&self.rotation, inner.translation);
        Self {
            rotation: product(&self.rotation, &inner.rotation),
            translation: add(self.translation, moved),
        }
    }
}

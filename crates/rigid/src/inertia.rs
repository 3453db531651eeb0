//! Inertia of bodies.

use crate::algebra::{Matrix, Pose, Vector, add, dot, product, scaled, times};
use lacuna_numbers::Number;

/// How hard a body is to move, about the origin of its frame: all dynamics are linear in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inertia<T> {
    /// Mass m, kg.
    pub mass: T,
    /// First moment m c, kg m.
    pub moment: Vector<T>,
    /// Inertia about the origin, kg m^2; symmetric.
    pub about_origin: Matrix<T>,
}

/// The ten numbers of a body as files give them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertialParameters<T> {
    /// Mass, kg.
    pub mass: T,
    /// Centre of mass in the body's frame, m.
    pub centre: Vector<T>,
    /// Inertia about the centre of mass along the frame's axes, kg m^2: xx, xy, xz, yy, yz, zz.
    pub inertia: [T; 6],
}

impl<T: Number> Inertia<T> {
    /// That of nothing.
    #[must_use]
    pub fn none() -> Self {
        let zero = T::constant(0.0);
        Self { mass: zero, moment: [zero; 3], about_origin: [[zero; 3]; 3] }
    }

    /// The same in another kind of number.
    #[must_use]
    pub fn map<U>(&self, into: impl Fn(T) -> U) -> Inertia<U> {
        let about_origin = self.about_origin.map(|row| row.map(&into));
        Inertia { mass: into(self.mass), moment: self.moment.map(&into), about_origin }
    }

    /// All its numbers: mass, moment, inertia by rows.
    #[must_use]
    pub fn entries(&self) -> [T; 13] {
        let ([x, y, z], [a, b, c]) = (self.moment, self.about_origin);
        [self.mass, x, y, z, a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]
    }

    /// That of two bodies, held together.
    #[inline(always)]
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            moment: add(self.moment, other.moment),
            about_origin: std::array::from_fn(|i| add(self.about_origin[i], other.about_origin[i])),
        }
    }

    /// The same body as it is seen from a frame in which its own stands so: the moment c' = R c + m p,
    /// the inertia R I R^T + 2 (p . Rc) 1 - p (Rc)^T - (Rc) p^T + m (p . p 1 - p p^T).
    #[inline(always)]
    pub(crate) fn seen_from(&self, rotation: &Matrix<T>, place: Vector<T>) -> Self {
        let turned = times(rotation, self.moment);
        let (m, p) = (self.mass, place);
        let half = product(rotation, &self.about_origin);
        let moment = add(turned, scaled(p, m));
        let round = dot(p, add(turned, moment));
        let mut about = [[round; 3]; 3];
        for i in 0..3 {
            for j in 0..=i {
                // p (Rc)^T + (Rc) p^T + m p p^T = p (Rc + m p)^T + (Rc) p^T.
                let entry = dot(half[i], rotation[j]) - p[i] * moment[j] - turned[i] * p[j];
                about[i][j] = if i == j { entry + round } else { entry };
                about[j][i] = about[i][j];
            }
        }
        Self { mass: m, moment, about_origin: about }
    }
}

impl Inertia<f64> {
    /// That of a mass and of inertia about its centre (xx, xy, xz, yy, yz, zz) along the axes of a frame, in
    /// which the centre is the origin, as it is seen from where that frame stands at this pose.
    pub(crate) fn of_centred(mass: f64, inertia: [f64; 6], frame: &Pose) -> Self {
        let about_centre = InertialParameters { mass, centre: [0.0; 3], inertia };
        about_centre.about_origin().seen_from_frame(frame)
    }

    /// The same body as it is seen from a frame in which its own stands at this pose.
    #[must_use]
    pub fn seen_from_frame(&self, pose: &Pose) -> Self {
        self.seen_from(&pose.rotation, pose.translation)
    }

    /// The ten numbers as files give them; those of nothing where there is no mass.
    #[must_use]
    pub fn parameters(&self) -> InertialParameters<f64> {
        let m = self.mass;
        let centre = if m > 0.0 { scaled(self.moment, 1.0 / m) } else { [0.0; 3] };
        let square = dot(centre, centre);
        let entry = |i: usize, j: usize| {
            let round = if i == j { square } else { 0.0 };
            self.about_origin[i][j] - m * (round - centre[i] * centre[j])
        };
        let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        InertialParameters { mass: m, centre, inertia: pairs.map(|(i, j)| entry(i, j)) }
    }
}

impl<T: Copy> InertialParameters<T> {
    /// By all its numbers, in the order of [`InertialParameters::entries`].
    #[inline(always)]
    #[must_use]
    pub fn of_entries(&[mass, x, y, z, xx, xy, xz, yy, yz, zz]: &[T; 10]) -> Self {
        Self { mass, centre: [x, y, z], inertia: [xx, xy, xz, yy, yz, zz] }
    }

    /// All its numbers: mass, centre, inertia.
    #[must_use]
    pub fn entries(&self) -> [T; 10] {
        let ([x, y, z], [xx, xy, xz, yy, yz, zz]) = (self.centre, self.inertia);
        [self.mass, x, y, z, xx, xy, xz, yy, yz, zz]
    }
}

impl<T: Number> InertialParameters<T> {
    /// About the origin of the body's frame.
    #[must_use]
    pub fn about_origin(&self) -> Inertia<T> {
        let (m, c, [xx, xy, xz, yy, yz, zz]) = (self.mass, self.centre, self.inertia);
        let square = dot(c, c);
        let about_centre = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        let about_origin = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let round = if i == j { square } else { T::constant(0.0) };
                about_centre[i][j] + m * (round - c[i] * c[j])
            })
        });
        Inertia { mass: m, moment: scaled(c, m), about_origin }
    }
}

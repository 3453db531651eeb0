//! How large and how heavy a robot is.

use crate::algebra::length;
use crate::{Body, Tree};

impl Tree {
    /// Mass of all that moves, kg.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.bodies.iter().map(|b| b.whole().mass).sum()
    }

    /// How far from its joint a body reaches, m: to the joints of the bodies that hang from it, and as far
    /// as its mass does. One that says little of its size is as large as bodies of this robot are in the
    /// mean.
    #[must_use]
    pub fn reach(&self, body: usize) -> f64 {
        let all = (0..self.bodies.len()).map(|k| self.own_reach(k));
        let mean = all.sum::<f64>() / self.bodies.len() as f64;
        self.own_reach(body).max(mean)
    }

    fn own_reach(&self, body: usize) -> f64 {
        let hanging = self.bodies.iter().filter(|b| b.parent == Some(body));
        let joints = hanging.map(|b| length(b.joint.pose.translation));
        joints.fold(self.bodies[body].extent(), f64::max)
    }
}

impl Body {
    /// How far from the origin of its frame its mass reaches: to its centre, and by the radius of gyration
    /// beyond.
    fn extent(&self) -> f64 {
        let whole = self.whole();
        let [xx, _, _, yy, _, zz] = whole.inertia;
        let gyration = match whole.mass {
            m if m > 0.0 => (0.5 * (xx + yy + zz) / m).max(0.0).sqrt(),
            _ => 0.0,
        };
        length(whole.centre) + gyration
    }
}

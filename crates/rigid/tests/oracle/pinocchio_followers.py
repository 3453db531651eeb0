"""Mass matrix and bias forces of a URDF by the joints of Pinocchio that follow others (`mimic=True`).

usage: pinocchio_followers.py ROBOT.urdf < states

As `pinocchio_dynamics.py`, where every joint has one coordinate and limits and where those that lead follow none: only such
trees does Pinocchio know. Columns of M are its inverse dynamics of unit accelerations. Its `crba` is not asked: where bodies
branch behind a joint that follows, that of 4.1 differs from its own inverse dynamics (by 2e-2 where j1 follows j0 and
carries j2 and j3), with which the energy of the bodies agrees.
"""

import sys

import numpy as np
import pinocchio as pin

model = pin.buildModelFromUrdf(sys.argv[1], mimic=True)
data = model.createData()
names = sys.stdin.readline().split()
assert model.nq == model.nv == len(names)
order = [model.joints[model.getJointId(name)].idx_v for name in names]
still = np.zeros(model.nv)


def forces(*state):
    """Those that it takes, of which the data keeps its own."""
    return pin.rnea(model, data, *state)[order].copy()


def energy(q, v):
    """That of the bodies in motion: `computeKineticEnergy` knows of no joint that follows."""
    pin.forwardKinematics(model, data, q, v)
    return sum(body.vtiv(moves) for body, moves in zip(model.inertias, data.v)) / 2


for line in sys.stdin:
    q, v = np.zeros((2, model.nv))
    q[order], v[order] = np.array(line.split(), dtype=float).reshape(2, -1)
    held = forces(q, still, still)
    mass = np.array([forces(q, still, unit) - held for unit in np.eye(model.nv)[order]]).T
    moving = energy(q, v)
    assert abs(v[order] @ mass @ v[order] / 2 - moving) < 1e-12 * moving
    print(*[repr(float(x)) for x in np.concatenate([mass.ravel(), forces(q, v, still)])])

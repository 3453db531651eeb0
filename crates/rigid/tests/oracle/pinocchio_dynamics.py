"""Mass matrix and bias forces of a URDF by Pinocchio.

usage: pinocchio_dynamics.py ROBOT.urdf < states

Each line of `states` holds coordinates, then velocities, in the order of the joints on the first line. A line is
printed for each: the mass matrix by rows, then the bias forces.
"""

import sys

import numpy as np
import pinocchio as pin

model = pin.buildModelFromUrdf(sys.argv[1])
data = model.createData()
names = sys.stdin.readline().split()
joints = [model.joints[model.getJointId(name)] for name in names]
order = [joint.idx_v for joint in joints]
for line in sys.stdin:
    numbers = np.array(line.split(), dtype=float)
    given, speeds = numbers[: len(names)], numbers[len(names) :]
    q, v = pin.neutral(model), np.zeros(model.nv)
    for joint, angle, speed in zip(joints, given, speeds):
        # A joint without limits is a point on the unit circle.
        turned = [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        q[joint.idx_q : joint.idx_q + joint.nq] = turned
        v[joint.idx_v] = speed
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    bias = pin.rnea(model, data, q, v, np.zeros(model.nv))
    both = np.concatenate([mass[np.ix_(order, order)].ravel(), bias[order]])
    print(*[repr(float(x)) for x in both])

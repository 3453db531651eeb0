"""Mass matrix and bias forces of a URDF by Pinocchio.

usage: pinocchio_dynamics.py ROBOT.urdf < states

Each line of `states` holds coordinates, then velocities, in the order of the names on the first line: those of joints, or
of a joint of several coordinates with _x, _y, _z, _yaw, _pitch or _roll behind it. A line is printed for each: the mass matrix
by rows, then the bias forces.

Pinocchio's velocities v of joints of several coordinates are told in the body that moves, and joints that follow others are
free in its model: v = S(q) q', with S of both. By q forces are S^T tau, and M = S^T M_v S, h = S^T (h_v + M_v S' q').
"""

import sys
import xml.etree.ElementTree

import numpy as np
import pinocchio as pin

model = pin.buildModelFromUrdf(sys.argv[1])
data = model.createData()
names = sys.stdin.readline().split()
place = {name: k for k, name in enumerate(names)}
mimics = {}
for joint in xml.etree.ElementTree.parse(sys.argv[1]).getroot().findall("joint"):
    if (mimic := joint.find("mimic")) is not None:
        factors = [float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))]
        mimics[joint.get("name")] = (mimic.get("joint"), *factors)


def axis(k):
    return np.eye(3)[k]


def about(k, angle):
    return pin.AngleAxis(angle, axis(k)).toRotationMatrix()


def single(q, nq):
    """Configuration of a joint of one coordinate: without limits it is a point on the unit circle."""
    return [q] if nq == 1 else [np.cos(q), np.sin(q)]


def planar(q, v):
    """Configuration, S and S' q' of a planar joint."""
    x, y, a = q
    c, s = np.cos(a), np.sin(a)
    turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    rate = v[2] * np.array([[-s, c, 0], [-c, -s, 0], [0, 0, 0]])
    return [x, y, c, s], turn, rate @ v


def floating(q, v):
    """The same of a floating joint: yaw, pitch and roll, R = Rz Ry Rx."""
    yaw, pitch, roll = q[3:]
    z, y, x = about(2, yaw), about(1, pitch), about(0, roll)
    rotation = z @ y @ x
    s, rate = np.zeros((6, 6)), np.zeros((6, 6))
    s[:3, :3] = rotation.T
    # w in the body: x roll' + (Rx^T y) pitch' + (Rx^T Ry^T z) yaw'.
    by_pitch, by_yaw = x.T @ axis(1), x.T @ y.T @ axis(2)
    s[3:, 3], s[3:, 4], s[3:, 5] = by_yaw, by_pitch, axis(0)
    rolls, pitches = v[5] * axis(0), v[4] * axis(1)
    rate[:3, :3] = -pin.skew(s[3:, 3:] @ v[3:]) @ rotation.T
    rate[3:, 4] = -np.cross(rolls, by_pitch)
    rate[3:, 3] = x.T @ -np.cross(pitches, y.T @ axis(2)) - np.cross(rolls, by_yaw)
    return [*q[:3], *pin.Quaternion(rotation).coeffs()], s, rate @ v


SEVERAL = {3: (planar, ["x", "y", "yaw"]), 6: (floating, ["x", "y", "z", "yaw", "pitch", "roll"])}
for line in sys.stdin:
    numbers = np.array(line.split(), dtype=float)
    given, speeds = numbers[: len(names)], numbers[len(names) :]
    q, s, extra = pin.neutral(model), np.zeros((model.nv, len(names))), np.zeros(model.nv)
    for name, joint in zip(model.names[1:], list(model.joints)[1:]):
        rows = slice(joint.idx_v, joint.idx_v + joint.nv)
        if joint.nv == 1:
            ratio, offset, leader = 1, 0, name
            while leader in mimics:
                leader, multiplier, added = mimics[leader]
                ratio, offset = ratio * multiplier, offset + ratio * added
            configuration = single(ratio * given[place[leader]] + offset, joint.nq)
            s[joint.idx_v, place[leader]] = ratio
        else:
            of, ends = SEVERAL[joint.nv]
            own = [place[f"{name}_{end}"] for end in ends]
            configuration, s[rows, own], extra[rows] = of(given[own], speeds[own])
        q[joint.idx_q : joint.idx_q + joint.nq] = configuration
    v = s @ speeds
    mass = pin.crba(model, data, q)
    mass = np.triu(mass) + np.triu(mass, 1).T
    bias = s.T @ (pin.rnea(model, data, q, v, np.zeros(model.nv)) + mass @ extra)
    print(*[repr(float(x)) for x in np.concatenate([(s.T @ mass @ s).ravel(), bias])])

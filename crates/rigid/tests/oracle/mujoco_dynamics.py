"""Mass matrix, bias forces, forces of springs and dampers, and accelerations of an MJCF by MuJoCo.

usage: mujoco_dynamics.py ROBOT.xml < states

Each line of `states` holds coordinates, then velocities, in the order of the names on the first line: those of joints, or
of a joint of several coordinates with _x, _y, _z, _yaw, _pitch or _roll behind it. A line is printed for each: the mass matrix
by rows (with rotors), then the bias forces, those of springs and dampers, and the accelerations where nothing else acts.

MuJoCo's velocities v tell how balls and free bodies turn in the body that moves, and joints that an <equality> ties are free
in its model: v = S(q) q'. By q forces are S^T tau, and M = S^T M_v S, h = S^T (h_v + M_v S' q'). That S moves joints as the
ties demand is asserted of MuJoCo's own constraints J v = 0. They are soft in its simulation; the accelerations are those of
ties that do not yield, by its M, J and accelerations without ties: a - M^-1 J^T (J M^-1 J^T)^-1 J a (Gauss's principle).
"""

import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # matrices are small, and tests run side by side

import mujoco
import numpy as np

model = mujoco.MjModel.from_xml_path(sys.argv[1])
model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
data = mujoco.MjData(model)
names = sys.stdin.readline().split()
place = {name: k for k, name in enumerate(names)}
FREE, BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)
SLIDES, TURNS = ["x", "y", "z"], ["yaw", "pitch", "roll"]
X, Y, Z = np.eye(3)
ties = {}
for follower, leader, numbers in zip(model.eq_obj1id, model.eq_obj2id, model.eq_data):
    assert not numbers[2:5].any(), "a straight line"
    at, of = model.qpos0[model.jnt_qposadr[[follower, leader]]]
    ties[follower] = (leader, numbers[1], at + numbers[0] - numbers[1] * of)


def called(joint):
    return model.joint(joint).name or f"joint{joint}"


def about(axis, angle):
    quaternion, matrix = np.zeros(4), np.zeros(9)
    mujoco.mju_axisAngle2Quat(quaternion, axis, angle)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def turned(q, v):
    """Quaternion of R = Rz Ry Rx, and S and S' q' of the angular velocity in the body."""
    (yaw, pitch, roll), (_, pitches, rolls) = q, v
    y, x = about(Y, pitch), about(X, roll)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, (about(Z, yaw) @ y @ x).ravel())
    # w = x roll' + (Rx^T y) pitch' + (Rx^T Ry^T z) yaw'.
    by_yaw, by_pitch = x.T @ y.T @ Z, x.T @ Y
    yaws_rate = x.T @ -np.cross(pitches * Y, y.T @ Z) - np.cross(rolls * X, by_yaw)
    rate = np.column_stack([yaws_rate, -np.cross(rolls * X, by_pitch), 0 * X])
    return quaternion, np.column_stack([by_yaw, by_pitch, X]), rate @ v


def led(joint):
    """The joint that leads this one, and how far this one goes with it and where it is where that is at 0."""
    ratio, offset = 1, 0
    while joint in ties:
        joint, multiplier, added = ties[joint]
        ratio, offset = ratio * multiplier, offset + ratio * added
    return joint, ratio, offset


for line in sys.stdin:
    given, speeds = np.array(line.split(), dtype=float).reshape(2, -1)
    s, extra = np.zeros((model.nv, len(names))), np.zeros(model.nv)
    for joint, (kind, q, v) in enumerate(zip(model.jnt_type, model.jnt_qposadr, model.jnt_dofadr)):
        if kind == FREE:
            own = [place[f"{called(joint)}_{end}"] for end in SLIDES]
            data.qpos[q : q + 3] = given[own]
            s[range(v, v + 3), own] = 1
            q, v = q + 3, v + 3
        if kind in (FREE, BALL):
            own = [place[f"{called(joint)}_{end}"] for end in TURNS]
            found = turned(given[own], speeds[own])
            data.qpos[q : q + 4], s[v : v + 3, own], extra[v : v + 3] = found
        else:
            leader, ratio, offset = led(joint)
            own = place[called(leader)]
            data.qpos[q], s[v, own] = ratio * given[own] + offset, ratio
    data.qvel[:] = s @ speeds
    mujoco.mj_forward(model, data)
    # Before the rows of friction and of stops.
    assert data.ne == len(ties), "nothing else ties"
    ties_by_v = data.efc_J.reshape(data.nefc, model.nv)[: data.ne]
    assert np.abs(data.efc_pos[: data.ne]).max(initial=0) < 1e-12, "S places joints as they are tied"
    assert np.abs(ties_by_v @ s).max(initial=0) < 1e-12, "S moves joints as they are tied"
    mass = np.zeros((model.nv, model.nv))
    for column, unit in zip(mass, np.eye(model.nv)):
        mujoco.mj_mulM(model, data, column, unit)
    bias = s.T @ (data.qfrc_bias + mass @ extra)
    passive = s.T @ (data.qfrc_spring + data.qfrc_damper)
    loose = data.qacc_smooth
    pulled = np.linalg.solve(mass, ties_by_v.T)
    tied = loose - pulled @ np.linalg.solve(ties_by_v @ pulled, ties_by_v @ loose)
    accelerations, *_ = np.linalg.lstsq(s, tied - extra)
    assert np.abs(s @ accelerations + extra - tied).max() <= 1e-9 * np.abs(tied).max()
    all = [(s.T @ mass @ s).ravel(), bias, passive, accelerations]
    print(*[repr(float(x)) for x in np.concatenate(all)])

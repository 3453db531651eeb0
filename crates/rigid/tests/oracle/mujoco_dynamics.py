"""Mass matrix, bias forces and forces of springs and dampers of an MJCF by MuJoCo.

usage: mujoco_dynamics.py ROBOT.xml < states

Each line of `states` holds coordinates, then velocities, in the order of the joints on the first line. A line is
printed for each: the mass matrix by rows (with rotors), then the bias forces, then those of springs and dampers.
"""

import sys

import mujoco
import numpy as np

model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
names = sys.stdin.readline().split()
known = {model.joint(k).name or f"joint{k}": k for k in range(model.njnt)}
joints = [known[name] for name in names]
assert len(joints) == model.nv, "a joint is missing"
for line in sys.stdin:
    numbers = np.array(line.split(), dtype=float)
    data.qpos[model.jnt_qposadr[joints]] = numbers[: len(names)]
    data.qvel[model.jnt_dofadr[joints]] = numbers[len(names) :]
    mujoco.mj_fwdPosition(model, data)
    mujoco.mj_fwdVelocity(model, data)
    order = model.jnt_dofadr[joints]
    mass = np.zeros((model.nv, model.nv))
    for column, unit in zip(mass, np.eye(model.nv)):
        mujoco.mj_mulM(model, data, column, unit)
    passive = data.qfrc_spring + data.qfrc_damper
    all = [mass[np.ix_(order, order)].ravel(), data.qfrc_bias[order], passive[order]]
    print(*[repr(float(x)) for x in np.concatenate(all)])

"""Motion of a robot by MuJoCo, as URDF or MJCF.

usage: mujoco_run.py ROBOT STEP SUBSTEPS < motion

The first line names the joints, the second holds their coordinates at rest; each that follows holds the torques
from one sample to the next. Motors get them where there are any, else the joints do. The coordinates at each
sample are printed, in the order of the joints.
"""

import sys

import mujoco
import numpy as np

model = mujoco.MjModel.from_xml_path(sys.argv[1])
substeps = int(sys.argv[3])
model.opt.timestep = float(sys.argv[2]) / substeps
model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
data = mujoco.MjData(model)
joints = [model.joint(name).id for name in sys.stdin.readline().split()]
places, velocities = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
data.qpos[places] = np.array(sys.stdin.readline().split(), dtype=float)
for line in sys.stdin:
    print(*[repr(float(q)) for q in data.qpos[places]])
    torques = np.array(line.split(), dtype=float)
    if model.nu:
        data.ctrl[:] = torques
    else:
        data.qfrc_applied[velocities] = torques
    for _ in range(substeps):
        mujoco.mj_step(model, data)

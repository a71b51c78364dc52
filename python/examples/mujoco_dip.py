"""MuJoCo moves a gripper on a lift and drench the towel in it: the towel is dipped into water and lifted out.

MuJoCo gets the wrench on the gripper, drench its pose. At rest the motor carries the gripper and the wet towel.

    pip install mujoco gymnasium
    python mujoco_dip.py
"""

import mujoco
import numpy as np

import drench
from drench.envs import REST, scene

LIFT = f"""
<mujoco>
  <option timestep="0.002"/>
  <worldbody>
    <body name="gripper" pos="0 {REST} 0">
      <joint name="lift" type="slide" axis="0 1 0" damping="5"/>
      <geom type="box" size="0.07 0.008 0.01" mass="0.5"/>
    </body>
  </worldbody>
  <actuator><position joint="lift" kp="4000" kv="120"/></actuator>
</mujoco>"""
GRAVITY = 9.81  # m/s²


def dip(run, until=3.0):
    """Yields (time, height of the gripper, force of the motor, weight of the gripper and the towel) for each step."""
    model = mujoco.MjModel.from_xml_string(LIFT)
    model.opt.gravity[:] = [0, -GRAVITY, 0]
    data = mujoco.MjData(model)
    body, gripper = model.body("gripper").id, run.bodies["gripper"]
    towel = 0.4 * 0.12 * 0.16
    while run.time < until - 1e-9:
        data.ctrl[0] = np.interp(run.time, [0.2, 0.8, 1.2, 1.8], [0, -0.16, -0.16, 0])  # m
        force, torque = gripper.wrench
        data.xfrc_applied[body] = [*force, *torque]
        mujoco.mj_step(model, data)
        gripper.set_pose(data.xpos[body], data.xquat[body], duration=model.opt.timestep)
        run.step(model.opt.timestep)
        water = run.mass("node_liquid").sum()
        yield run.time, data.xpos[body][1], data.actuator_force[0], GRAVITY * (0.5 + towel + water)


def main():
    run = drench.Simulation(scene())
    rows = np.array(list(dip(run)))
    for name, start, end in (("dry", 0.1, 0.2), ("wet", 2.5, 3.0)):
        at = rows[(rows[:, 0] > start) & (rows[:, 0] <= end)]
        print(f"{name}: the motor carries {at[:, 2].mean():.3f} N, gripper and towel weigh {at[:, 3].mean():.3f} N")


if __name__ == "__main__":
    main()

"""A robot arm in Newton dips a towel into water, lifts it and turns it on edge, so that water runs out at its lowest corner.

Newton gets the wrench on the gripper, drench its pose. At rest the base carries the arm and the wet towel. The drives
compensate the weight of the arm, so that their torques show the weight of the wet towel. In drench, pressure on fabric does
not release liquid: a towel drips where its saturation is above 1.

    pip install newton gymnasium
    python newton_arm.py
"""

import newton
import numpy as np
import warp as wp

import drench
from drench.envs import HEIGHT, REST, WIDTH, scene

STEP, SUBSTEPS = 0.004, 4  # s: step of drench; Newton's steps in it
UPPER, FORE, STEM = 0.3, 0.3, 0.1  # m: lengths of the links; the wrist is STEM above the gripper
SHOULDER = np.array([-0.45, 0.5])  # m: x and y; the arm moves in the plane z = 0
STIFFNESS, DAMPING = 300.0, 12.0  # N m/rad and N m s/rad, of the drives
GRAVITY = 9.81  # m/s²
TURN = 3.0  # s: when the gripper turns
END = 6.0  # s
TERRY = {"capillary_height": 0.08, "diffusivity": 5e-3, "max_saturation": 1.5}  # liquid flows through it within seconds


def path(time):
    """Position x, y of the gripper, m, and its angle, rad."""
    height = REST + np.interp(time, [0.3, 0.8, 1.2, 1.8, TURN, TURN + 1], [0, -0.16, -0.16, 0.0, 0.0, 0.08])
    return 0.0, height, np.interp(time, [TURN, TURN + 1], [0, np.pi / 2])


def joint_angles(x, y, angle):
    """Angles of shoulder, elbow and wrist, rad, that bring the gripper to a place of its path."""
    wrist = np.array([x - STEM * np.sin(angle), y + STEM * np.cos(angle)]) - SHOULDER
    elbow = -np.arccos((wrist @ wrist - UPPER**2 - FORE**2) / (2 * UPPER * FORE))
    shoulder = np.arctan2(wrist[1], wrist[0]) - np.arctan2(FORE * np.sin(elbow), UPPER + FORE * np.cos(elbow))
    return np.array([shoulder, elbow, angle - shoulder - elbow])


class Arm:
    """Three revolute joints about z on a base. Newton's axis y points up, as in drench."""

    def __init__(self):
        wp.config.log_level = wp.LOG_WARNING
        builder = newton.ModelBuilder(up_axis=newton.Axis.Y, gravity=(0.0, -GRAVITY, 0.0))

        def link(name, half, centre, mass):
            body = builder.add_link(label=name)
            shape = newton.ModelBuilder.ShapeConfig(density=mass / float(8 * np.prod(half)))
            builder.add_shape_box(body, xform=wp.transform(centre, wp.quat_identity()), hx=half[0], hy=half[1], hz=half[2],
                                  cfg=shape)
            return body

        def joint(parent, child, at, offset=(0.0, 0.0, 0.0)):
            return builder.add_joint_revolute(
                parent, child, axis=newton.Axis.Z, parent_xform=wp.transform(at, wp.quat_identity()),
                child_xform=wp.transform(offset, wp.quat_identity()), target_ke=STIFFNESS, target_kd=DAMPING, armature=0.02)

        base = link("base", (0.05, 0.05, 0.05), (0.0, -0.05, 0.0), 2.0)
        upper = link("upper arm", (UPPER / 2, 0.02, 0.02), (UPPER / 2, 0.0, 0.0), 0.6)
        fore = link("forearm", (FORE / 2, 0.015, 0.015), (FORE / 2, 0.0, 0.0), 0.4)
        self.gripper = link("gripper", (0.07, 0.008, 0.01), (0.0, 0.0, 0.0), 0.3)
        place = wp.transform((float(SHOULDER[0]), float(SHOULDER[1]), 0.0), wp.quat_identity())
        builder.add_articulation([
            builder.add_joint_fixed(-1, base, parent_xform=place),
            joint(base, upper, (0.0, 0.0, 0.0)),
            joint(upper, fore, (UPPER, 0.0, 0.0)),
            joint(fore, self.gripper, (FORE, 0.0, 0.0), (0.0, STEM, 0.0))])
        builder.joint_q[:] = joint_angles(*path(0.0))
        self.model = builder.finalize(device="cpu")
        self.solver = newton.solvers.SolverFeatherstone(self.model, angular_damping=0.0)
        self.state, self.next = self.model.state(), self.model.state()
        newton.eval_fk(self.model, self.model.joint_q, self.model.joint_qd, self.state)
        self.control = self.model.control()
        self.observed = self.solver.observables({self.solver.ObservableKind.BODY_PARENT_F})
        self.weight = GRAVITY * float(self.model.body_mass.numpy().sum())  # N
        self.load = np.zeros((self.model.body_count, 6), np.float32)  # force and torque on each link
        self.torques = np.zeros(3)  # N m: of the drives, without the compensation of the arm's weight

    def step(self, place, force, torque):
        """Advance by STEP towards a place of the path, with a wrench on the gripper."""
        angles = joint_angles(*place)
        self.control.joint_target_q.assign(angles.astype(np.float32))
        newton.eval_inverse_dynamics_passive(self.model, self.state, gravity_force=self.control.joint_f)
        self.load[self.gripper] = [*force, *torque]
        for _ in range(SUBSTEPS):
            self.state.body_f.assign(self.load)
            self.solver.step(self.state, self.next, self.control, None, STEP / SUBSTEPS, observables=self.observed)
            self.state, self.next = self.next, self.state
        self.torques = STIFFNESS * (angles - self.state.joint_q.numpy()) - DAMPING * self.state.joint_qd.numpy()

    def pose(self):
        """Position of the gripper, m, and its orientation as a quaternion w x y z; Newton's order is x y z w."""
        x, y, z, *turn = self.state.body_q.numpy()[self.gripper]
        return np.array([x, y, z]), np.array([turn[3], *turn[:3]])

    def base_force(self):
        """Vertical force that holds the base, N."""
        return float(self.observed.body_parent_f.numpy()[0, 1])

    def payload(self):
        """Weight that the drives carry at the gripper, N."""
        shoulder, elbow, _ = np.cumsum(self.state.joint_q.numpy())
        joints = SHOULDER + np.array([[0, 0], [UPPER * np.cos(shoulder), UPPER * np.sin(shoulder)], [0, 0]])
        joints[2] = joints[1] + [FORE * np.cos(elbow), FORE * np.sin(elbow)]
        arms = self.pose()[0][:2] - joints
        # Each drive holds the torque of a force (x, y) at the gripper, and a torque that is the same for all.
        balance = np.column_stack([-arms[:, 1], arms[:, 0], np.ones(3)])
        return float(np.linalg.solve(balance, self.torques)[1])


def dip(run):
    """Yields (time, force at the base, weight of arm and towel, load of the drives, weight of the towel, N, water, kg)."""
    arm, gripper, towel = Arm(), run.bodies["gripper"], 0.4 * WIDTH * HEIGHT
    while run.time < END - 1e-9:
        arm.step(path(run.time), *gripper.wrench)
        gripper.set_pose(*arm.pose(), duration=STEP)
        run.step(STEP)
        water = run.mass("node_liquid").sum()
        carried = GRAVITY * (towel + water)
        yield run.time, arm.base_force(), arm.weight + carried, arm.payload(), carried, water


def main():
    towel_scene = scene(0.015)
    towel_scene["cloth"][0]["porous"] = TERRY
    rows = np.array(list(dip(drench.Simulation(towel_scene))))
    for name, start, end in (("dry", 0.2, 0.3), ("lifted", TURN - 0.3, TURN), ("turned", END - 0.5, END)):
        at = rows[(rows[:, 0] > start) & (rows[:, 0] <= end)].mean(axis=0)
        print(f"{name}: the base carries {at[1]:.3f} N, arm and towel weigh {at[2]:.3f} N; "
              f"the drives carry {at[3]:.4f} N, the towel weighs {at[4]:.4f} N with {1e3 * at[5]:.1f} g of water")


if __name__ == "__main__":
    main()

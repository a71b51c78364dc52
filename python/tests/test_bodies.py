"""Bodies that a program moves, and what acts on them."""

import math
import threading

import numpy as np
import pytest
from test_run import same_state

import drench

DOMAIN = {"min": [-1, -1, -1], "max": [1, 1, 1]}
BOX = {"min": [-0.1, -0.05, -0.1], "max": [0.1, 0.0, 0.1]}
GRIPPER = {
    "time": {"step": 0.002, "end": 10.0},
    "domain": DOMAIN,
    "cloth": [{"name": "towel", "mesh": {"grid": {"size": [0.15, 0.15], "nodes": [11, 11]}},
               "place": {"position": [0, 0.003, 0]}, "areal_density": 0.4, "thickness": 0.002, "damping": 20.0,
               "friction": 0.5}],
    "bodies": [{"name": "plate", "box": {**BOX, "commanded": True}},
               {"sphere": {"center": [0.5, 0.5, 0.5], "radius": 0.05}}],
}
CUP = {
    "time": {"step": 0.002, "end": 10.0},
    "domain": DOMAIN,
    "fluid": {"spacing": 0.02, "sources": [{"block": {"min": [-0.1, 0, -0.1], "max": [0.06, 0.12, 0.1]}}]},
    "bodies": [{"name": "cup", "box": {"min": [-0.1, 0, -0.1], "max": [0.1, 0.3, 0.1], "inside": True, "commanded": True}}],
}


def test_a_body_moves_as_it_is_told():
    run = drench.Simulation(GRIPPER)
    plate = run.bodies["plate"]
    assert len(run.bodies) == 2 and plate.index == 0 and run.bodies[1].name == ""
    assert np.allclose(plate.position, [0, -0.025, 0]) and np.allclose(plate.orientation, [1, 0, 0, 0])
    run.run_until(0.1)
    assert np.allclose(plate.position, [0, -0.025, 0], atol=1e-12)  # it stands still until then
    plate.set_velocity([0.1, 0, 0], [0, 0, math.pi / 2])
    run.run_until(0.3)
    assert np.allclose(plate.position, [0.02, -0.025, 0], atol=1e-9)
    assert np.allclose(plate.velocity, [0.1, 0, 0]) and np.allclose(plate.angular_velocity, [0, 0, math.pi / 2])
    assert np.allclose(plate.orientation, [math.cos(math.pi / 20), 0, 0, math.sin(math.pi / 20)], atol=1e-9)
    half = math.sqrt(0.5)
    plate.set_pose([0, 0.1, 0.05], [half, half, 0, 0], duration=0.2)
    run.run_until(0.6)
    assert np.allclose(plate.position, [0, 0.1, 0.05], atol=1e-9)
    assert np.allclose(np.abs(plate.orientation), [half, half, 0, 0], atol=1e-9)
    assert np.allclose(plate.velocity, 0) and np.allclose(plate.angular_velocity, 0)


def test_cloth_at_rest_weighs_on_the_body():
    run = drench.Simulation(GRIPPER)
    plate = run.bodies["plate"]
    run.run_until(1.5)
    forces = []
    for _ in range(50):
        run.step()
        forces.append(plate.cloth_wrench.force)
    weight = 0.4 * 0.15 * 0.15 * 9.81
    assert np.allclose(np.mean(forces, axis=0), [0, -weight, 0], atol=0.01 * weight)
    assert np.allclose(plate.liquid_wrench.force, 0) and np.allclose(plate.wrench.force, plate.cloth_wrench.force)


def test_liquid_and_body_exchange_momentum():
    """A cup with liquid is shaken: the liquid gets its weight and the opposite of the wrench, and nothing else."""
    run = drench.Simulation(CUP)
    cup = run.bodies["cup"]

    def momentum():
        state = run.state()
        return run.quantum * (state["fluid_mass"].astype(float)[:, None] * state["fluid_velocity"]).sum(axis=0)

    mass = run.quantum * run.state()["fluid_mass"].sum()
    start, given = momentum(), np.zeros(3)
    for k in range(150):
        cup.set_velocity([0.3 * math.cos(0.1 * k), 0.2 * math.sin(0.05 * k), 0.1])
        step = run.step()
        given += step.dt * (mass * np.array([0, -9.81, 0]) - cup.wrench.force)
    size = mass * 9.81 * run.time
    assert np.abs(momentum() - start).max() > 0.01 * size
    assert np.allclose(momentum() - start, given, atol=1e-5 * size)


def test_a_force_moves_a_dynamic_body():
    scene = {**CUP, "bodies": [{"name": "ball", "sphere": {"center": [0, 0.5, 0], "radius": 0.05, "dynamic": True,
                                                           "density": 500}},
                               {"plane": {"point": [0, 0, 0], "normal": [0, 1, 0]}}]}
    run = drench.Simulation(scene)
    ball = run.bodies["ball"]
    mass = 500 * 4 / 3 * math.pi * 0.05**3
    ball.apply_wrench([0.2, 9.81 * mass, 0], [0, 1e-3, 0])
    run.run_until(0.1)
    assert np.allclose(ball.velocity, [0.1 * 0.2 / mass, 0, 0], rtol=1e-6, atol=1e-6)
    assert np.allclose(ball.angular_velocity, [0, 0.1 * 1e-3 / (0.4 * mass * 0.05**2), 0], rtol=1e-6, atol=1e-6)
    assert np.allclose(ball.wrench.force, 0, atol=1e-9)
    ball.apply_wrench([5, 0, 0], [0, 1, 0])  # of the next step
    assert np.allclose(ball.wrench.force, 0, atol=1e-9) and np.allclose(ball.wrench.torque, 0, atol=1e-9)


def test_a_checkpoint_keeps_the_commands(tmp_path):
    run = drench.Simulation(GRIPPER)
    run.bodies["plate"].set_velocity([0, 0.05, 0], [0.3, 0, 0])
    run.run_until(0.05)
    run.save_checkpoint(tmp_path / "now.ckpt")
    run.run_until(0.1)
    again = drench.Simulation(GRIPPER, resume=tmp_path / "now.ckpt")
    again.run_until(0.1)
    assert same_state(run.state(), again.state())


def test_what_cannot_be_commanded_is_refused():
    run = drench.Simulation(GRIPPER)
    with pytest.raises(ValueError, match="commanded: true"):
        run.bodies[1].set_velocity([1, 0, 0])
    with pytest.raises(ValueError, match="dynamic: true"):
        run.bodies["plate"].apply_wrench([1, 0, 0])
    with pytest.raises(ValueError, match="not measured"):
        run.bodies[1].wrench  # noqa: B018
    with pytest.raises(ValueError, match="not finite"):
        run.bodies["plate"].set_velocity([math.nan, 0, 0])
    with pytest.raises(ValueError, match="above 0"):
        run.bodies["plate"].set_pose([0, 0, 0], [0, 0, 0, 0])
    with pytest.raises(KeyError, match="plate"):
        run.bodies["gripper"]
    with pytest.raises(drench.SceneError, match="commanded"):
        drench.Scene({**GRIPPER, "bodies": [{"box": {**BOX, "commanded": True, "velocity": [1, 0, 0]}}]})


def test_runs_in_threads_have_the_bits_of_runs_alone():
    scenes = [GRIPPER, CUP, {**CUP, "fluid": {**CUP["fluid"], "viscosity": 0.01}},
              {**GRIPPER, "cloth": [{**GRIPPER["cloth"][0], "self_collision": True}]}]
    steps = 30

    def steps_of(run):
        for _ in range(steps):
            run.step()
        return run.state()

    alone = [steps_of(drench.Simulation(scene)) for scene in scenes]
    found = [None] * len(scenes)

    def work(k):
        found[k] = steps_of(drench.Simulation(scenes[k]))

    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(scenes))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k, state in enumerate(found):
        assert state is not None and same_state(state, alone[k]), k

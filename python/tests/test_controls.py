"""Pins, jets and wind that a program changes between steps."""

import math

import numpy as np
import pytest
from test_run import same_state

import drench

CLOTH = {
    "time": {"step": 0.002, "end": 10.0},
    "domain": {"min": [-2, -2, -2], "max": [2, 2, 2]},
    "cloth": [{"name": "sheet", "mesh": {"grid": {"size": [0.4, 0.4], "nodes": [9, 9]}},
               "pin": [{"box": {"min": [-0.21, -0.01, -0.21], "max": [-0.19, 0.01, 0.21]}},
                       {"box": {"min": [0.19, -0.01, -0.21], "max": [0.21, 0.01, 0.21]},
                        "spin": {"axis": [1, 0, 0], "degrees_per_second": 90}}]}],
}


def pinned(run, pin):
    return run.fields["node_position"].copy()[run.pin_nodes("sheet", pin)]


def test_pins_go_where_they_are_sent():
    run = drench.Simulation(CLOTH)
    start, still = pinned(run, 0), pinned(run, 1)
    assert len(start) == 9
    run.run_until(0.1)
    assert np.array_equal(pinned(run, 0), start)  # an entry without a motion stands still
    run.set_pin_velocity("sheet", 0, [0.1, 0.2, 0.0])
    run.run_until(0.3)
    assert np.allclose(pinned(run, 0), start + [0.02, 0.04, 0], atol=1e-6)
    assert np.allclose(run.fields["node_velocity"].copy()[run.pin_nodes(0, 0)], [0.1, 0.2, 0], atol=1e-4)
    run.set_pin_velocity(0, 0, [0, 0, 0])
    run.run_until(0.4)
    assert np.allclose(pinned(run, 0), start + [0.02, 0.04, 0], atol=1e-6)
    assert not np.allclose(pinned(run, 1), still, atol=1e-3)  # this one turns all the while


def test_pins_that_turn_go_on_from_where_they_are():
    run = drench.Simulation(CLOTH)
    start = pinned(run, 1)
    run.run_until(0.5)
    before = pinned(run, 1)
    angle = math.radians(45)
    turned = np.column_stack([start[:, 0], math.cos(angle) * start[:, 1] - math.sin(angle) * start[:, 2],
                              math.sin(angle) * start[:, 1] + math.cos(angle) * start[:, 2]])
    assert np.allclose(before, turned, atol=1e-5)
    run.set_pin_velocity("sheet", 1, [0, 1, 0])
    run.run_until(0.6)
    assert np.allclose(pinned(run, 1), before + [0, 0.1, 0], atol=1e-6)


def test_a_velocity_set_each_step_follows_a_sine():
    run = drench.Simulation(CLOTH)
    start, amplitude, omega = pinned(run, 0), 0.02, 2 * math.pi * 2
    heights = []
    while run.time < 0.5 - 1e-9:
        # the mean velocity over the step, so that the step ends on the curve
        ahead = run.time + 0.002
        run.set_pin_velocity("sheet", 0, [0, amplitude * (math.sin(omega * ahead) - math.sin(omega * run.time)) / 0.002, 0])
        run.step()
        heights.append((run.time, float((pinned(run, 0) - start)[:, 1].mean())))
        assert np.isfinite(run.pin_force("sheet", 0)).all()
    assert max(abs(y - amplitude * math.sin(omega * t)) for t, y in heights) < 1e-6


def test_the_force_on_pins_carries_the_cloth():
    scene = {**CLOTH, "cloth": [{**CLOTH["cloth"][0], "damping": 10.0}]}
    scene["cloth"][0]["pin"] = [{"corners": True}]
    run = drench.Simulation(scene)
    run.run_until(4.0)
    forces = []
    for _ in range(100):
        run.step()
        forces.append(run.pin_force(0))
    weight = 0.2 * 0.4 * 0.4 * 9.81  # the default areal density, kg/m²
    total = np.mean(forces, axis=0)
    assert abs(total[1]) == pytest.approx(weight, rel=0.02), total


def test_resume_goes_on_with_changed_pins_jets_and_wind(tmp_path, scene):
    run = drench.Simulation(scene)
    run.run_until(0.02)
    run.set_pin_velocity("sheet", 0, [0, 0.3, 0])
    run.set_pin_velocity("sheet", 1, [0, -0.1, 0])
    run.set_jet(0, [0.5, -1.5, 0])
    run.set_wind([1, 0, 0])
    run.run_until(0.05)
    run.save_checkpoint(tmp_path / "a.drench")
    run.run_until(0.1)
    other = drench.Simulation(scene, resume=tmp_path / "a.drench")
    other.run_until(0.1)
    assert same_state(other.state(), run.state())
    first = drench.Simulation(scene)
    first.save_checkpoint(tmp_path / "b.drench")
    run.resume(tmp_path / "b.drench")  # and back to a run that nobody has changed
    run.run_until(0.05)
    first.run_until(0.05)
    assert same_state(first.state(), run.state())


def test_the_command_refuses_such_a_checkpoint(tmp_path, scene, program):
    import subprocess

    from drench.scene import to_text
    file = tmp_path / "scene.yaml"
    file.write_text(to_text(scene))
    run = drench.Simulation(file)
    run.set_wind([1, 0, 0])
    run.save_checkpoint(tmp_path / "a.drench")
    ended = subprocess.run([program, "run", file, "--resume", tmp_path / "a.drench", "--no-output"], capture_output=True, text=True)
    assert ended.returncode == 2 and "changed by a program" in ended.stderr and ended.stderr.count("\n") == 1


def jet_scene():
    return {"time": {"step": 0.002, "end": 10.0}, "domain": {"min": [-1, -1, -1], "max": [1, 1, 1]}, "gravity": [0, 0, 0],
            "fluid": {"spacing": 0.02, "sources": [
                {"jet": {"center": [0, 0.5, 0], "radius": 0.05, "velocity": [0, -1, 0]}}]}}


def test_a_jet_flows_as_it_is_told():
    run = drench.Simulation(jet_scene())
    area, litre = math.pi * 0.05 ** 2, run.quantum
    supplied = lambda: run.last.mass_supplied * litre / 1000  # m³
    run.run_until(0.1)
    one = 1000 * 0.02 ** 3 / 1000  # m³ of a particle
    assert supplied() == pytest.approx(area * 1.0 * 0.1, abs=2 * one)
    run.set_jet(0, [0, -2, 0])
    run.run_until(0.2)
    assert supplied() == pytest.approx(area * (0.1 + 0.2), abs=2 * one)
    run.set_jet(0, [0, 0, 0])
    run.run_until(0.3)
    assert supplied() == pytest.approx(area * 0.3, abs=2 * one)
    run.set_jet(0, [3, 0, 0], center=[-0.5, 0.5, 0])
    run.run_until(0.35)
    assert supplied() == pytest.approx(area * (0.3 + 0.15), abs=2 * one)
    newest = run.state()["fluid_position"][-5:]
    assert (newest[:, 0] < -0.2).all()


def wheel_scene():
    return {"time": {"step": 0.002, "end": 10.0}, "domain": {"min": [-1, -1, -1], "max": [1, 1, 1]},
            "fluid": {"spacing": 0.02, "sources": [{"block": {"min": [0.8, 0.8, 0.8], "max": [0.84, 0.84, 0.84]}}]},
            "bodies": [{"name": "wheel", "sphere": {"center": [0, 0, 0], "radius": 0.1, "dynamic": True, "mass": 2}}],
            "joints": [{"hinge": {"body": "wheel", "point": [0, 0, 0], "axis": [0, 0, 1], "motor": {"torque": 5}}}]}


def test_a_motor_turns_as_it_is_told(tmp_path):
    run = drench.Simulation(wheel_scene())
    wheel = run.bodies["wheel"]
    run.run_until(0.02)
    assert wheel.angular_velocity[2] == pytest.approx(0, abs=1e-6)  # a brake
    run.set_motor(0, 3.0)
    run.run_until(0.1)
    assert wheel.angular_velocity[2] == pytest.approx(3, abs=1e-3)
    assert np.allclose(wheel.position, 0, atol=1e-4)
    run.save_checkpoint(tmp_path / "a.drench")
    again = drench.Simulation(wheel_scene(), resume=tmp_path / "a.drench")
    for one in (run, again):
        one.run_until(0.14)
    assert same_state(run.state(), again.state()) and again.bodies["wheel"].angular_velocity[2] == pytest.approx(3, abs=1e-3)
    for wrong, words in ((lambda: run.set_motor(1, 0), "no joint 1"), (lambda: run.set_motor(0, math.nan), "finite")):
        with pytest.raises(ValueError, match=words):
            wrong()


def test_wind_blows_in_a_scene_without_it():
    run = drench.Simulation(CLOTH)
    run.run_until(0.02)
    assert "wind" not in run.stage_milliseconds()
    run.set_wind([0, 0, 20])
    run.run_until(0.1)
    blown, calm = run.fields["node_position"].copy(), drench.Simulation(CLOTH)
    calm.run_until(0.1)
    assert "wind" in run.stage_milliseconds()
    assert (blown - calm.fields["node_position"].copy())[:, 2].max() > 0.005


@pytest.mark.parametrize("call, words", [
    (lambda run: run.set_pin_velocity("curtain", 0, [0, 0, 0]), "no cloth 'curtain'"),
    (lambda run: run.set_pin_velocity(3, 0, [0, 0, 0]), "no cloth 3"),
    (lambda run: run.set_pin_velocity(0, 7, [0, 0, 0]), "no pin 7"),
    (lambda run: run.set_pin_velocity(0, 0, [0, math.nan, 0]), "finite"),
    (lambda run: run.set_pin_velocity(0, 0, [0, 1]), "three numbers"),
    (lambda run: run.set_jet(0, [0, 1, 0]), "no jet 0"),
    (lambda run: run.set_wind([math.inf, 0, 0]), "finite"),
])
def test_wrong_calls_are_value_errors(call, words):
    with pytest.raises(ValueError, match=words):
        call(drench.Simulation(CLOTH))


def test_a_jet_outside_the_domain_is_refused_and_nothing_changes():
    run = drench.Simulation(jet_scene())
    with pytest.raises(drench.SetupError, match="outside the domain"):
        run.set_jet(0, [0, -1, 0], center=[5, 0, 0])
    same = drench.Simulation(jet_scene())
    run.run_until(0.05)
    same.run_until(0.05)
    assert same_state(run.state(), same.state())


def test_keys_of_a_dict_move_pins_bodies_and_the_wind():
    import copy
    scene = copy.deepcopy(CLOTH)
    scene["cloth"][0]["pin"][0]["offset"] = {"keys": [[0, [0, 0, 0]], [0.2, [0, 0.04, 0]], [0.4, [0, 0, 0]]], "interpolation": "smooth"}
    scene["bodies"] = [{"sphere": {"center": [0, -1, 0], "radius": 0.1, "velocity": [[0.0, [0, 0, 0]], [0.2, [1, 0, 0]]]}}]
    scene["wind"] = {"velocity": [[0, [0, 0, 0]], [0.1, [0, 0, np.float32(4)]]]}
    run = drench.Simulation(scene)
    start = pinned(run, 0)
    run.run_until(0.2)
    assert np.allclose(pinned(run, 0), start + [0, 0.04, 0], atol=1e-6)
    assert np.allclose(run.fields["body_position"].copy()[0], [0.1, -1, 0], atol=1e-6)  # ∫ 5 t dt
    calm = drench.Simulation(scene, {"wind.velocity": [0, 0, 0]})
    calm.run_until(0.2)
    assert (run.fields["node_position"].copy() - calm.fields["node_position"].copy())[:, 2].max() > 1e-3  # pushed along
    run.run_until(0.4)
    assert np.allclose(pinned(run, 0), start, atol=1e-6)
    assert np.allclose(run.fields["body_position"].copy()[0], [0.3, -1, 0], atol=1e-6)
    scene["bodies"][0]["sphere"]["velocity"] = [[0.2, [0, 0, 0]], [0.1, [1, 0, 0]]]
    with pytest.raises(drench.SceneError, match="is not later than the previous entry"):
        drench.Simulation(scene)

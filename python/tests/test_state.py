"""What a program may change between steps, copies of runs, and scenes from arrays."""

import copy
import pickle

import numpy as np
import pytest
from conftest import SCENE
from test_run import same_state

import drench


def test_a_state_set_in_a_run_shows_in_it(scene):
    run = drench.Simulation(scene)
    total = run.step().mass_total
    view = run.fields["node_velocity"]
    run.set({"node_velocity": [0, 0.5, 0], "node_position": view.copy() * 0 + run.fields["node_position"].copy() + [0, 0.01, 0]})
    with pytest.raises(drench.StaleView):
        view.sum()
    assert np.allclose(run.fields["node_velocity"], [0, 0.5, 0])
    run.set("saturation", 0.5, at=run.cloth_nodes("sheet"))
    assert np.allclose(run.saturation(), 0.5, atol=1e-6)
    assert np.allclose(run.mass("node_liquid"), 0.5 * run.capacity(), atol=1e-12)
    assert run.step().mass_total == total


def test_particles_are_set_by_id_whatever_their_order(scene):
    run = drench.Simulation(scene)
    for _ in range(20):
        run.step()
    ids = run.fields["fluid_id"].copy()
    speed = ids[:, None] * [1e-4, 0, 0]
    run.set("fluid_velocity", speed, at=ids)
    state = run.state()
    assert np.allclose(state["fluid_velocity"][:, 0], 1e-4 * state["fluid_id"], atol=1e-6)
    with pytest.raises(ValueError, match="of which particles"):
        run.set("fluid_velocity", speed)
    with pytest.raises(ValueError, match="no particle with id 123456"):
        run.set("fluid_velocity", [0, 0, 0], at=[123456])


def test_particles_come_and_go_within_the_mass_budget(scene):
    run = drench.Simulation(scene)
    step = run.step()
    total, count, supplied = step.mass_total, step.particles, step.mass_supplied
    grid = 0.02 * np.stack(np.meshgrid(*3 * [np.arange(3)], indexing="ij"), axis=-1).reshape(-1, 3) + [0.2, 0.1, 0.2]
    ids = run.add_particles(grid, velocity=[0, -1, 0])
    assert len(ids) == 27 and set(ids) <= set(run.fields["fluid_id"])
    run.remove_particles(ids[:7])
    step = run.step()
    assert step.particles >= count + 20 and step.mass_total == total
    assert step.mass_supplied - supplied >= 27 * run.full_particle and step.mass_drained == 7 * run.full_particle
    with pytest.raises(ValueError, match="outside the domain"):
        run.add_particles([[0, 5, 0]])
    with pytest.raises(ValueError, match=r"shape \(3,\)"):
        run.add_particles([0, 0, 0])


@pytest.mark.parametrize("wrong, what", [
    ({"name": "node_pin_force", "values": 0}, "cannot be set"),
    ({"name": "node_velocity", "values": [1, 2]}, "shape"),
    ({"name": "node_velocity", "values": np.nan}, "not a finite number"),
    ({"name": "node_liquid", "values": 0.5}, "integer"),
    ({"name": "node_liquid", "values": -1}, "allowed: at least 0"),
    ({"name": "saturation", "values": "wet"}, "could not convert"),
])
def test_wrong_values_are_refused_and_change_nothing(scene, wrong, what):
    run = drench.Simulation(scene)
    before = run.state()
    with pytest.raises((ValueError, KeyError), match=what):
        run.set(**wrong)
    assert same_state(run.state(), before)


def test_copies_of_a_run_continue_with_its_bits(scene):
    run = drench.Simulation(scene)
    for _ in range(5):
        run.step()
    run.set_wind([1, 0, 0])
    copies = [run.clone(), copy.deepcopy(run), pickle.loads(pickle.dumps(run))]
    other = drench.Simulation(scene)
    other.load_state_dict(run.state_dict())
    start = drench.Simulation(scene).state()
    for _ in range(5):
        run.step()
    for copied in (*copies, other):
        assert copied.steps == 5
        for _ in range(5):
            copied.step()
        assert same_state(copied.state(), run.state())
    run.reset()
    assert run.steps == 0 and run.last is None and same_state(run.state(), start)


def test_views_have_numpys_reductions(scene):
    field = drench.Simulation(scene).fields["node_position"]
    assert field.mean() == field.numpy().mean() and field.max(axis=0).shape == (3,)
    with pytest.raises(AttributeError, match="use numpy"):
        field.reshape(-1)


def sheet(n):
    side = np.linspace(-0.1, 0.1, n)
    points = np.array([[x, 0.0, z] for x in side for z in side])
    square = [[i * n + j, i * n + j + 1, (i + 1) * n + j + 1, (i + 1) * n + j] for i in range(n - 1) for j in range(n - 1)]
    return points, np.array(square)


def test_scenes_from_arrays_are_those_from_files(tmp_path):
    points, faces = sheet(6)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.05 - [0, 0.2, 0]
    box = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    drops = np.array([[0, 0.1, 0], [0.02, 0.1, 0]])
    scene = {
        "time": {"step": 0.002, "end": 0.1}, "domain": SCENE["domain"],
        "fluid": {"spacing": 0.02, "sources": [{"particles": drops, "velocities": np.array([[0, -1, 0], [0, 1, 0]])}]},
        "cloth": [{"name": "napkin", "mesh": {"points": points, "faces": faces, "uv": points[:, ::2] * 5 + 0.5, "scale": 0.5}}],
        "bodies": [{"mesh": {"points": corners, "faces": box}}],
    }
    run = drench.Simulation(scene)
    assert np.allclose(run.state()["node_position"], points * 0.5, atol=1e-7)
    assert np.allclose(run.state()["fluid_velocity"][:, 1], [-1, 1]) and np.allclose(run.state()["fluid_position"], drops)
    assert len(run.triangles) == 2 * len(faces)
    run.scene.save(tmp_path / "saved.yaml")
    assert len(list((tmp_path / "saved_arrays").iterdir())) == 3
    others = [drench.Simulation(tmp_path / "saved.yaml"), pickle.loads(pickle.dumps(run)), run.clone()]
    for _ in range(3):
        run.step()
    for other in others:
        for _ in range(3):
            other.step()
        assert same_state(other.state(), run.state())
    with pytest.raises(ValueError, match="cloth.0.mesh.points"):
        drench.Scene({**scene, "cloth": [{"mesh": {"points": [[0, 1]], "faces": faces}}]})
    with pytest.raises(ValueError, match="faces: is missing"):
        drench.Scene({**scene, "cloth": [{"mesh": {"points": points}}]})

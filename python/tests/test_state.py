"""What a program may change between steps, copies of runs, and scenes from arrays."""

import copy
import pickle
import sys

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
    ({"name": "node_liquid", "values": 1e30}, "not possible"),
    ({"name": "node_velocity", "values": np.inf}, "not a finite number"),
    ({"name": "node_velocity", "values": 1j}, "needs numbers"),
    ({"name": "node_velocity", "values": 0, "at": [289]}, "there is no row 289; there are 289 rows"),
    ({"name": "node_velocity", "values": 0, "at": [3, 3]}, "listed twice"),
    ({"name": "node_velocity", "values": 0, "at": [-1, 288]}, "listed twice"),
    ({"name": "node_velocity", "values": 0, "at": [0.5]}, "at needs an index"),
    ({"name": "node_velocity", "values": 0, "at": "sheet"}, "at needs an index"),
    ({"name": "node_velocity", "values": 0, "at": [[1, 2], [3, 4]]}, "at needs an index"),
    ({"name": "node_velocity", "values": 0, "at": [True, False]}, "2 entries in a mask"),
    ({"name": "fluid_spin", "values": 0, "at": [0]}, "no such field"),
    ({"name": "saturation", "values": "wet"}, "needs numbers"),
    ({"name": "saturation", "values": None}, "needs numbers"),
    ({"name": "saturation", "values": -1}, "saturation: -1; allowed: at least 0"),
    ({"name": "saturation", "values": 10}, "a saturation of 10; allowed: up to "),
    ({"name": "node_position", "values": 1e9}, r"allowed: \[-10000, 10000\]"),
    ({"name": "node_velocity", "values": 1e30}, r"allowed: \[-1000, 1000\]"),
    ({"name": "saturation", "values": [1, 2]}, r"shape \(2,\)"),
    ({"name": {"node_velocity": 0}, "values": 1}, "no second argument"),
    ({"name": {"node_velocity": 1, "speed": 1}}, "speed cannot be set"),
])
def test_wrong_values_are_refused_and_change_nothing(scene, wrong, what):
    run = drench.Simulation(scene)
    before = run.state()
    with pytest.raises((ValueError, KeyError), match=what):
        run.set(**wrong)
    assert same_state(run.state(), before)


@pytest.mark.skipif(drench.precision == "double", reason="1e300 fits")
def test_a_value_beyond_single_precision_is_refused(scene):
    with pytest.raises(ValueError, match="single-precision"):
        drench.Simulation(scene).set("node_velocity", 1e300)


@pytest.mark.parametrize("wrong, what", [
    ({"position": [[0, np.nan, 0]]}, "position: not a finite number"),
    ({"position": [["a", "b", "c"]]}, "position: needs numbers"),
    ({"position": None}, "position: needs numbers"),
    ({"position": [[0, 0.2, 0]], "velocity": np.zeros((2, 3))}, "velocity: shape"),
    ({"position": [[0, 0.2, 0]], "mass": -1e-3}, "allowed: at least 1"),
    ({"position": [[0, 0.2, 0]], "mass": np.inf}, "mass: not a finite number"),
    ({"position": [[0, 0.2, 0]], "mass": 1.0}, "two full particles"),
])
def test_wrong_particles_are_refused_and_change_nothing(scene, wrong, what):
    run = drench.Simulation(scene)
    before = run.state()
    with pytest.raises(ValueError, match=what):
        run.add_particles(**wrong)
    for ids in ([1, 1], [1.0], [10**9], 1, ["a"], [True]):
        with pytest.raises(ValueError, match="id"):
            run.remove_particles(ids)
    assert same_state(run.state(), before)


def test_particles_are_added_where_there_are_none(scene):
    del scene["fluid"]["sources"]
    run = drench.Simulation(scene)
    run.set("fluid_velocity", [0, 0, 0], at=run.fields["fluid_id"].copy())
    run.remove_particles([])
    ids = run.add_particles([[0.2, 0.2, 0.2], [0.22, 0.2, 0.2]])
    total = run.step().mass_total
    assert run.last.particles == 2
    run.remove_particles(ids)
    assert run.step().particles == 0
    assert list(run.add_particles([[0.2, 0.2, 0.2]])) == [2]
    assert run.step().particles == 1 and run.last.mass_total == total


def test_only_porous_cloth_is_wetted(scene):
    scene["cloth"].append({"name": "film", "mesh": {"grid": {"size": [0.1, 0.1], "nodes": [3, 3]}},
                           "place": {"position": [0, 0.3, 0]}})
    run = drench.Simulation(scene)
    run.set("saturation", 0.5)
    assert np.allclose(run.saturation()[run.cloth_nodes("sheet")], 0.5, atol=1e-6)
    assert not run.saturation()[run.cloth_nodes("film")].any()
    with pytest.raises(ValueError, match="not porous"):
        run.set("saturation", 0.5, at=run.cloth_nodes("film"))


def test_wrong_nodes_bodies_and_times_are_refused(scene):
    box = {"min": [0.2, 0.1, 0.2], "max": [0.25, 0.15, 0.25], "commanded": True}
    scene["bodies"].append({"name": "gripper", "box": box})
    run = drench.Simulation(scene)
    before = run.state_dict()
    for nodes, what in (([], "empty"), ([0.0], "indices"), ([2**40], "there is no"), ([289], "no node 289"), ([-1], "no node -1")):
        with pytest.raises(ValueError, match=what):
            run.attach("sheet", nodes, "gripper")
    for cloth in (0.5, None, "towel", 7, -1):
        with pytest.raises(ValueError, match="cloth"):
            run.attach(cloth, [100], "gripper")
    for body in (1.5, None, slice(2), "arm", 9, -1):
        with pytest.raises(KeyError):
            run.attach("sheet", [100], body)
    run.detach("sheet")  # nothing is attached
    run.detach("sheet", [])
    with pytest.raises(ValueError, match="not attached"):
        run.detach("sheet", [100])
    for time in (np.nan, np.inf):
        with pytest.raises(ValueError, match="finite time"):
            run.run_until(time)
    with pytest.raises(ValueError, match="whole number"):
        run.set_pin_velocity("sheet", 0.5, [0, 0, 0])
    with pytest.raises(ValueError, match="needs numbers"):
        run.bodies["gripper"].set_pose("up")
    with pytest.raises(TypeError, match="needs a function"):
        run.on_step(3)
    after = run.state_dict()
    assert same_state(after, before) and list(after["changes"]) == list(before["changes"])
    run.attach("sheet", [99, 100], run.bodies["gripper"])
    assert list(run.bodies["gripper"].attached_nodes) == [99, 100]


def test_a_state_comes_back_from_a_file(scene, tmp_path):
    run, other = drench.Simulation(scene), drench.Simulation(scene)
    for _ in range(3):
        run.step()
    run.set_wind([1, 0, 0])
    np.savez(tmp_path / "state.npz", **run.state_dict())
    with np.load(tmp_path / "state.npz") as saved:
        other.load_state_dict(saved)
    run.step()
    other.step()
    assert same_state(run.state(), other.state())
    state = run.state_dict()
    for wrong, what in (({}, "missing"), (None, "a dict"), ({**state, "step": 1.5}, "step: needs"),
                        ({**state, "time": "now"}, "time: needs"), ({**state, "node_position": np.zeros(3)}, "dimensions"),
                        ({**state, "node_position": np.zeros((3, 3))}, "3 rows"), ({**state, "changes": [np.nan]}, "finite"),
                        ({k: v for k, v in state.items() if k != "changes"}, "changes: is missing")):
        with pytest.raises(ValueError, match=what):
            run.load_state_dict(wrong)
        assert same_state(run.state_dict(), state)


def test_a_run_that_is_reset_or_copied_reports_the_frame_of_the_start(scene):
    run, frames = drench.Simulation(scene), []
    run.on_frame(lambda run, frame: frames.append(frame.number))
    copied = run.clone()
    copied.on_frame(lambda run, frame: frames.append(frame.number))
    copied.step()
    assert frames == [0]
    for _ in range(2):
        frames.clear()
        for _ in range(11):
            run.step()
        assert frames == [0, 1]
        run.reset()


def test_a_run_is_copied_while_it_is_recorded(scene, tmp_path):
    run = drench.Simulation(scene)
    with run.record(tmp_path / "out"):
        run.step()
        for copied in (run.clone(), pickle.loads(pickle.dumps(run))):
            copied.step()
            assert copied.steps == 2
        for refused in (run.reset, lambda: run.load_state_dict(run.state_dict()), lambda: run.record(tmp_path / "other")):
            with pytest.raises(RuntimeError, match="recorded"):
                refused()
        run.step()
    assert same_state(run.state(), copied.state())


def test_without_tqdm_nothing_is_written(scene, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    with pytest.raises(ImportError, match="tqdm"):
        drench.Simulation(scene).write(tmp_path / "out", progress=True)
    assert not (tmp_path / "out").exists()


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


def test_regions_are_painted_by_attributes():
    points, faces = sheet(6)
    cloth = {"mesh": {"points": points, "faces": faces, "attributes": {"felt": np.where(points[:, 0] > 0, 1.0, 0.0)}},
             "areal_density": 0.2, "regions": [{"attribute": "felt", "areal_density": 0.6}]}
    scene = drench.Scene({**SCENE, "cloth": [cloth]})
    assert "attribute: \"felt\"" in scene.to_yaml()
    drench.Simulation(scene).step()


@pytest.mark.parametrize("mesh, what", [
    ({"points": [[0, 1]]}, "cloth.0.mesh.points: needs numbers of shape"),
    ({"points": np.zeros((0, 3))}, "cloth.0.mesh.points: needs numbers of shape"),
    ({"points": [[0, 0, 0], [1, 0]]}, "rows of the same length"),
    ({"points": np.full((4, 3), np.nan)}, "not a finite number"),
    ({"points": np.full((4, 3), 1j)}, "needs numbers"),
    ({"faces": None}, "needs a list of faces"),
    ({"faces": []}, "is empty"),
    ({"faces": [0, 1, 2]}, "face 0 is 0"),
    ({"faces": [[0, 1]]}, "at least three"),
    ({"faces": np.array([[0.0, 1.0, 2.0]])}, "indices of points"),
    ({"faces": np.array([[0, 1, 4]])}, "indices from 0 to 3"),
    ({"faces": [[0, 1, 2, 3], [0, 1, -1]]}, "indices from 0 to 3"),
    ({"faces": [[0, 1, 2**40]]}, "indices from 0 to 3"),
    ({"uv": [[0, 0]]}, "1 rows; needed: one per point, 4"),
    ({"attributes": [1, 2]}, "attributes: is list; needed: a dict"),
    ({"attributes": {"wax": [0, 1]}}, r"attributes.wax: is of shape \(2,\); needed: one number per point, 4"),
    ({"attributes": {"x": np.zeros(4)}}, "attributes: 'x' is not a name"),
    ({"file": "sheet.ply"}, "file and points"),
])
def test_wrong_arrays_are_refused(mesh, what):
    square = {"points": [[0, 0, 0], [0.1, 0, 0], [0.1, 0, 0.1], [0, 0, 0.1]], "faces": [[0, 1, 2, 3]]}
    drench.Scene({**SCENE, "cloth": [{"mesh": square}]})
    with pytest.raises(ValueError, match=what):
        drench.Scene({**SCENE, "cloth": [{"mesh": {**square, **mesh}}]})


def test_incomplete_arrays_are_refused():
    with pytest.raises(ValueError, match="faces: is missing"):
        drench.Scene({**SCENE, "cloth": [{"mesh": {"points": np.eye(3)}}]})
    for source, what in (({"particles": np.zeros((0, 3))}, "shape"), ({"particles": [[0, np.nan, 0]]}, "finite"),
                         ({"particles": np.eye(3), "velocities": np.eye(3)[:1]}, "one per particle, 3")):
        with pytest.raises(ValueError, match=what):
            drench.Scene({**SCENE, "fluid": {"spacing": 0.02, "sources": [source]}})

"""Views of the backend's arrays: no copy, never dangling, and an error where they are stale."""

import gc

import numpy as np
import pytest

import drench

on_host = pytest.mark.skipif(drench.info()["backend"] == "Cuda", reason="the arrays are on a GPU")


@pytest.fixture
def run(scene):
    run = drench.Simulation(scene)
    for _ in range(3):
        run.step()
    return run


def test_every_field_of_the_scene_has_a_view(run):
    state = run.state()
    names = {name for name, values in state.items() if isinstance(values, np.ndarray) and values.size and name != "jet_particles"}
    assert names == set(run.fields)
    for name in run.fields:
        view = run.fields[name]
        assert view.shape == state[name].shape, name
        assert view.unit, name


@on_host
def test_a_view_is_the_backends_own_array(run):
    view = run.fields["fluid_position"]
    array = view.numpy()
    assert array.__array_interface__["data"] == (view.address, True)
    again = run.fields["fluid_position"].numpy()
    assert again.__array_interface__["data"][0] == view.address
    assert np.shares_memory(array, again) and not array.flags.owndata
    assert np.shares_memory(np.asarray(view), array)
    assert np.shares_memory(np.from_dlpack(view), array)


@on_host
def test_the_backend_writes_where_the_view_reads(scene):
    del scene["fluid"], scene["bodies"]
    scene["cloth"][0].pop("porous")
    run = drench.Simulation(scene)
    velocity = run.fields["node_velocity"]
    array, before = velocity.numpy(), velocity.copy()
    run.step()
    assert run.fields["node_velocity"].address == velocity.address  # this one stays where it is
    assert not np.array_equal(array, before)
    assert np.array_equal(array, run.fields["node_velocity"])


@on_host
def test_a_view_is_read_only(run):
    array = run.fields["node_velocity"].numpy()
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 1
    with pytest.raises(ValueError):
        array.flags.writeable = True
    view = run.fields["node_velocity"]
    with pytest.raises(TypeError):
        view += 1
    assert (view * 2)[0, 0] == 2 * view[0, 0]


@on_host
def test_a_view_shows_the_state(run):
    state = run.state()
    order = np.argsort(run.fields["fluid_id"])
    assert np.array_equal(np.sort(run.fields["fluid_id"]), state["fluid_id"])
    for name in run.fields:
        values = run.fields[name].numpy()
        values = values[order] if name.startswith("fluid_") else values
        assert np.array_equal(values.astype(state[name].dtype), state[name]), name
        assert np.array_equal(run.fields[name].copy(), run.fields[name].numpy()), name
    assert run.fields["body_orientation"].shape == (2, 4)


@on_host
def test_a_step_makes_views_stale(run):
    view, kept = run.fields["fluid_position"], run.fields["fluid_position"].copy()
    first = view[0].copy()
    run.step()
    assert not view.current
    uses = [lambda: view[0], view.numpy, view.copy, lambda: np.asarray(view), lambda: view + 1, lambda: list(view),
            lambda: np.from_dlpack(view), lambda: np.sqrt(view)]
    for use in uses:
        with pytest.raises(drench.StaleView, match="fluid_position is stale"):
            use()
    assert "stale" in repr(view)
    assert np.array_equal(kept[0], first)
    assert run.fields["fluid_position"].current


@on_host
def test_an_array_outlives_its_run(scene):
    run = drench.Simulation(scene)
    arrays = [run.fields[name].numpy() for name in run.fields]
    sums = [float(array.sum()) for array in arrays]
    del run
    gc.collect()
    others = [drench.Simulation(scene) for _ in range(2)]  # something else may have the memory now
    for other in others:
        other.step()
    assert [float(array.sum()) for array in arrays] == sums


@on_host
def test_arrays_stay_readable_while_particles_come_and_go(scene):
    scene["fluid"]["sources"][1]["jet"].update(radius=0.1, velocity=[0, -4, 0])
    scene["time"]["end"] = 10.0
    run = drench.Simulation(scene)
    old = []
    counts = set()
    for _ in range(60):
        run.step()
        counts.add(len(run.fields["fluid_position"]))
        old.append(run.fields["fluid_position"].numpy())
    assert max(counts) > 2 * min(counts)  # so the arrays were made anew
    assert len({array.__array_interface__["data"][0] for array in old}) > 2
    assert all(np.isfinite(array).all() for array in old)


def test_a_run_without_particles_has_empty_fields():
    from test_controls import jet_scene
    run = drench.Simulation(jet_scene())
    assert run.fields["fluid_position"].shape == (0, 3) and len(run.fields["fluid_id"]) == 0
    assert run.fields["fluid_position"].copy().shape == (0, 3)
    run.run_until(0.05)
    assert len(run.fields["fluid_id"]) > 0


def test_an_unknown_field_names_those_that_there_are(run):
    with pytest.raises(KeyError, match="fluid_position"):
        run.fields["fluid_positions"]


def test_numpy_functions_take_a_view(run):
    if run.fields["fluid_position"].memory != "host":
        pytest.skip("the arrays are on a GPU")
    view = run.fields["fluid_velocity"]
    speed = np.linalg.norm(view, axis=1)
    assert speed.shape == (len(view),)
    assert np.mean(view, axis=0).shape == (3,)
    assert np.asarray(view, dtype=np.float64).dtype == np.float64
    assert view.__dlpack_device__()[0] == 1

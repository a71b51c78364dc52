"""Worlds that step together."""

import copy
import pickle
import threading
import time

import numpy as np
import pytest

import drench

from test_run import same_state

SHEET = {
    "drench": 1, "time": {"step": 0.002, "end": 0.2},
    "fluid": {"spacing": 0.012, "sources": [{"block": {"min": [-0.04, 0.02, -0.04], "max": [0.04, 0.08, 0.04]}}]},
    "cloth": [{"mesh": {"grid": {"size": [0.2, 0.2], "nodes": [11, 11]}}, "pin": [{"corners": True}], "porous": {}}],
}
DRY = {"drench": 1, "time": {"step": 0.002, "end": 0.2},
       "cloth": [{"mesh": {"grid": {"size": [0.2, 0.2], "nodes": [9, 9]}}, "pin": [{"corners": True}]}]}


def alone(scene, overrides=None, steps=20):
    run = drench.Simulation(scene, overrides)
    for _ in range(steps):
        run.step()
    return run.state()


def test_worlds_have_the_bits_that_they_have_alone():
    overrides = [{"fluid.viscosity": 0.001 * k} for k in range(5)]
    batch = drench.Batch(SHEET, overrides=overrides)
    for _ in range(20):
        reports = batch.step()
    assert [report.step for report in reports] == [world.steps for world in batch] == [20] * 5
    for world, changed in zip(batch, overrides):
        assert same_state(world.state(), alone(SHEET, changed))


def test_worlds_of_different_scenes():
    batch = drench.Batch([SHEET, DRY, DRY])
    batch.run_until(0.03)
    assert np.allclose(batch.time, 0.03) and batch.time.shape == (3,)
    run = drench.Simulation(SHEET)
    run.run_until(0.03)
    assert same_state(batch[0].state(), run.state())
    assert same_state(batch[1].state(), batch[2].state())
    assert batch[1:3] == [batch[1], batch[2]] and len(batch) == 3
    with pytest.raises(ValueError, match="between 81 and 121 rows"):
        batch.stack("node_position")


def test_some_worlds_step_and_are_reset():
    batch = drench.Batch(DRY, 3)
    start = batch.stack("node_position")
    assert start.shape == (3, 81, 3)
    reports = batch.step(worlds=[0, 2])
    assert reports[1] is None and reports[0].step == 1
    assert batch[0].steps == 1 and batch[1].steps == 0
    batch.reset([2])
    now = batch.stack("node_position")
    assert np.array_equal(now[2], start[2]) and not np.array_equal(now[0], start[0])
    assert batch.step(longest=[0.001, 0.0005, 0.002])[1].dt == pytest.approx(0.0005)


def test_commands_and_callbacks_belong_to_their_world():
    seen = []
    batch = drench.Batch(DRY, 2)
    batch[1].on_step(lambda run, step: seen.append((run is batch[1], step.step)))
    batch[0].set({"node_velocity": [0, 1, 0]})
    batch.step()
    batch.step()
    assert seen == [(True, 1), (True, 2)]
    assert not same_state(batch[0].state(), batch[1].state())


def test_a_world_that_fails_does_not_stop_the_others():
    collapses = {"time.step": 0.1, "time.end": 100, "fluid.solver": {"max_iterations": 2, "min_iterations": 1},
                 "bodies": [{"box": {"min": [-0.06, -0.1, -0.04], "max": [0.06, 0.4, 0.04], "inside": True}}]}
    batch = drench.Batch(SHEET, overrides=[{}, collapses, {}])
    with pytest.raises(drench.BatchError, match="world 1: ") as caught:
        for _ in range(50):
            batch.step()
    assert list(caught.value.errors) == [1] and isinstance(caught.value.errors[1], drench.RunFailure)
    assert isinstance(caught.value, drench.Error)
    steps = batch[0].steps
    assert same_state(batch[0].state(), alone(SHEET, steps=steps)) and batch[2].steps == steps
    batch.reset([1])
    batch.step()
    assert batch[1].steps == 1 and batch[0].steps == steps + 1


@pytest.mark.parametrize("arguments, text", [
    ({"scene": DRY}, "needs n"), ({"scene": DRY, "n": 0}, "1 or more"), ({"scene": [DRY, DRY], "n": 3}, "2 scenes"),
    ({"scene": DRY, "n": 2, "overrides": [{}]}, "2 worlds and 1 overrides")])
def test_what_is_no_batch_is_refused(arguments, text):
    with pytest.raises(ValueError, match=text):
        drench.Batch(**arguments)


def test_worlds_that_there_are_not():
    batch = drench.Batch(DRY, 2)
    with pytest.raises(IndexError, match="no world 2"):
        batch.step(worlds=[2])
    with pytest.raises(ValueError, match="2 worlds, and 3"):
        batch.step(longest=[1, 1, 1])
    with pytest.raises(ValueError, match="longer than 0"):
        batch.step(longest=[0.001, -1])
    assert batch[0].steps == 0, "no world steps if one of them is given what is not allowed"


def test_a_world_may_step_alone_but_not_while_the_batch_steps():
    batch = drench.Batch(SHEET, 2, {"fluid.spacing": 0.006})
    errors = []
    begun = threading.Event()

    def work():
        begun.set()
        for _ in range(5):
            try:
                batch.step()
            except RuntimeError as error:  # the other thread was first
                errors.append(str(error))

    thread = threading.Thread(target=work)
    thread.start()
    begun.wait()
    while thread.is_alive():
        try:
            batch[0]._run.step()
        except RuntimeError as error:
            errors.append(str(error))
        time.sleep(0.001)
    thread.join()
    assert errors and all("another thread" in error for error in errors)


def test_a_callback_that_raises_leaves_the_other_worlds_in_order():
    def refuse(run, step):
        raise KeyError("mine")

    batch = drench.Batch(DRY, 3)
    batch[0].on_step(refuse)
    with pytest.raises(drench.BatchError, match="world 0: 'mine'") as caught:
        batch.step()
    assert [world.last.step for world in batch] == [1, 1, 1]
    again = pickle.loads(pickle.dumps(caught.value))
    assert list(again.errors) == [0] and str(again) == str(caught.value)


def test_what_no_batch_can_run_to():
    batch = drench.Batch(DRY, 2)
    for time_ in (float("inf"), float("nan")):
        with pytest.raises(ValueError, match="finite"):
            batch.run_until(time_)
    with pytest.raises(TypeError, match="flatnonzero"):
        batch.reset([True, False])


def test_a_long_batch_repeats_itself():
    first, second = drench.Batch(SHEET, 4), drench.Batch(copy.deepcopy(SHEET), 4)
    for batch in (first, second):
        batch.run_until(0.1)
    for a, b in zip(first, second):
        assert same_state(a.state(), b.state())

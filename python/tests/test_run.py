"""Steps, frames, checkpoints, threads, and the command's bits."""

import math
import subprocess
import threading
import time

import numpy as np
import pytest
from conftest import checkpoint_records

import drench
from drench.scene import to_text

#: What the command alone writes: counts of its own frames, and the commit that either was built from.
OF_THE_COMMAND = {"frames", "shortened", "commit"}


def same_state(a, b):
    return all(np.array_equal(a[name], b[name]) for name in a)


@pytest.mark.parametrize("mode", ["fixed", "cfl"])
def test_a_hundred_steps_have_the_commands_bits(tmp_path, scene, program, mode):
    scene["time"]["mode"] = mode
    file, out = tmp_path / "scene.yaml", tmp_path / "out"
    file.write_text(to_text(scene))
    subprocess.run([program, "run", file, "--steps", "100", "--quiet", "-o", out], check=True)
    command = checkpoint_records(out / "checkpoint_000100.drench")
    run = drench.Simulation(file)
    for step in run:
        if step.step == 100:
            break
    run.save_checkpoint(tmp_path / "python.drench")
    ours = checkpoint_records(tmp_path / "python.drench")
    if ours["precision"] != command["precision"] or ours["backend"] != command["backend"]:
        pytest.skip(f"the command is of {command['precision']} precision by {command['backend']}")
    assert set(ours) == set(command) and len(ours) > 30
    different = [name for name in ours if ours[name] != command[name]]
    assert set(different) <= OF_THE_COMMAND
    # and the way back: the command's checkpoint goes on here
    other = drench.Simulation(file, resume=out)
    assert other.steps == 100 and same_state(other.state(), run.state())
    assert other.step() == run.step() and same_state(other.state(), run.state())


def test_a_step_tells_its_numbers(scene):
    run = drench.Simulation(scene)
    assert run.last is None
    step = run.step()
    assert step["step"] == step.step == 1 and run.last is step
    assert step.particles == len(run.fields["fluid_id"])
    assert step.mass_total == step.mass_fluid + step.mass_cloth + step.mass_drained + step.mass_evaporated - step.mass_supplied
    assert len(step) > 35 and "density_iterations" in dir(step)
    with pytest.raises(AttributeError, match="density_iterations"):
        step.iterations
    assert sum(run.stage_milliseconds().values()) > 0 and "pressure" in run.stage_milliseconds()


def test_a_run_ends_where_the_scene_says(scene):
    scene["time"]["end"] = 0.011
    run = drench.Simulation(scene)
    steps = [step.time for step in run]
    assert run.finished and len(steps) == run.steps
    assert math.isclose(run.time, 0.011, abs_tol=1e-9)
    assert list(run) == []
    assert run.run_until(0.0135).time == pytest.approx(0.0135)


def test_step_has_a_bound(scene):
    run = drench.Simulation(scene)
    assert run.step(0.0005).dt == pytest.approx(0.0005)
    with pytest.raises(ValueError, match="longer than 0"):
        run.step(0.0)


def test_callbacks_hear_steps_and_frames(scene):
    scene["time"]["end"] = 0.05
    run, steps, frames = drench.Simulation(scene), [], []
    run.on_step(lambda run, step: steps.append((step.step, run.fields["fluid_position"].current)))

    @run.on_frame
    def frame(run, frame):
        frames.append((frame.number, round(frame.time, 9), run.steps))

    for _ in run:
        pass
    assert [number for number, _ in steps] == list(range(1, run.steps + 1)) and all(current for _, current in steps)
    assert [(number, t) for number, t, _ in frames] == [(0, 0.0), (1, 0.02), (2, 0.04)] and frames[0][2] == 0


def test_a_callback_cannot_step_and_its_error_comes_out(scene):
    run = drench.Simulation(scene)
    run.on_step(lambda run, step: run.step())
    with pytest.raises(RuntimeError, match="callback"):
        run.step()
    run._on_step.clear()
    run.on_step(lambda run, step: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        run.step()
    assert run.steps == 2


def test_checkpoints_go_on_bit_for_bit(tmp_path, scene):
    run = drench.Simulation(scene)
    run.run_until(0.03)
    run.save_checkpoint(tmp_path / "a.drench")
    run.run_until(0.07)
    other = drench.Simulation(scene, resume=tmp_path / "a.drench")
    frames = []
    other.on_frame(lambda run, frame: frames.append(frame.number))
    other.run_until(0.07)
    assert frames == [2, 3] and other.steps == run.steps and same_state(other.state(), run.state())
    view = run.fields["fluid_position"]
    run.resume(tmp_path / "a.drench")
    assert not view.current and run.time == pytest.approx(0.03)
    run.run_until(0.07)
    assert same_state(other.state(), run.state())


def test_a_checkpoint_of_another_scene_is_refused(tmp_path, scene):
    drench.Simulation(scene).save_checkpoint(tmp_path / "a.drench")
    with pytest.raises(drench.CheckpointError, match="stretch"):
        drench.Simulation(scene, {"cloth.0.stretch": 123}, resume=tmp_path / "a.drench")
    (tmp_path / "b.drench").write_text("no checkpoint")
    with pytest.raises(drench.CheckpointError, match="b.drench"):
        drench.Simulation(scene, resume=tmp_path / "b.drench")
    with pytest.raises(RuntimeError, match="cannot be written"):
        drench.Simulation(scene).save_checkpoint(tmp_path / "none" / "a.drench")


def test_pythons_other_threads_run_while_it_computes(scene):
    run = drench.Simulation(scene, {"fluid.spacing": 0.01})
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.0005)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    steps = 0
    while (end := time.perf_counter()) < begin + 0.2:  # nothing of Python in between but this
        run._run.step()
        steps += 1
    done.set()
    thread.join()
    during = [t for t in ticks if begin < t < end]
    assert len(during) > 1.5 * steps > 0, "with the lock held one tick a step is the most"


def test_a_second_thread_gets_an_error_and_no_crash(scene):
    run = drench.Simulation(scene, {"fluid.spacing": 0.01})
    errors, steps, lock = [], [], threading.Lock()

    def work():
        for _ in range(30):
            try:
                report = run._run.step()
                with lock:
                    steps.append(report["step"])
            except RuntimeError as error:
                errors.append(str(error))
                time.sleep(0.001)

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(steps) == list(range(1, len(steps) + 1))
    assert errors and set(errors) == {"the run computes a step in another thread"}


def test_a_run_may_be_stepped_from_another_thread(scene):
    here, there = drench.Simulation(scene), drench.Simulation(scene)
    here.run_until(0.02)
    thread = threading.Thread(target=lambda: there.run_until(0.02))
    thread.start()
    thread.join()
    assert same_state(here.state(), there.state())


def test_a_run_that_fails_says_why(scene):
    scene["cloth"][0].update(stretch=1e9, bend=1.0)
    scene["fluid"]["sources"][1]["jet"]["velocity"] = [0, -1, 0]
    scene["fluid"]["solver"] = {"max_iterations": 2, "min_iterations": 1}
    scene["gravity"] = [0, -9.81, 0]
    run = drench.Simulation(scene, {"time.step": 0.2, "time.end": 200.0})
    with pytest.raises(drench.RunFailure) as failure:
        for _ in range(500):
            run._run.step()
    assert failure.value.kind and failure.value.stage and failure.value.report["step"] >= 0
    assert failure.value.time >= 0 and str(failure.value)


def test_a_callback_costs_less_than_a_hundredth_of_a_step(scene):
    """Of a step of 10 ms; what the package adds to one, with a callback that looks at a field."""
    run = drench.Simulation(scene)
    run.step()
    seen = []
    run.on_step(lambda run, step: seen.append(run.fields["fluid_position"].shape[0]))

    def added():
        begin = time.perf_counter()
        run._bounded(None)
        run._first_frame()
        run._call(run._on_step, run.last)
        run._frame_if_due()
        return time.perf_counter() - begin

    costs = sorted(added() for _ in range(300))
    assert costs[len(costs) // 2] < 1e-4, f"{1e6 * costs[len(costs) // 2]:.1f} µs"

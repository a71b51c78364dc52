"""How a process ends that still has runs, views and arrays, and which libraries it can have beside drench."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

START = """
import sys
sys.path.insert(0, {tests!r})
import drench
from conftest import SCENE
def ARRAY(view):
    if view.memory == "host":
        import numpy
        return view.numpy(), numpy.from_dlpack(view)
    return torch_or_end().from_dlpack(view)
def torch_or_end():
    try:
        import torch
        return torch
    except ImportError:
        sys.exit(0)
run = drench.Simulation(SCENE)
run.step()
"""

ENDS = {
    "a run": "",
    "nothing": "del run",
    "an array": "array = ARRAY(run.fields['fluid_position']); del run",
    "a view": "view = run.fields['fluid_position']; del run",
    "a view that NumPy has": "array = ARRAY(run.fields['node_position']); run.step()",
    "a cycle": "run.on_step(lambda r, s: run); run.me = run",
    "a callback at the end": "import atexit; atexit.register(lambda: print(run.fields['fluid_position'].copy()[0, 0], run.step()))",
    "a thread": "import threading; t = threading.Thread(target=lambda: [run.step() for _ in range(20)]); t.start()",
    "a step after the end": "import atexit, drench._core; r = run._run\natexit._run_exitfuncs()\n"
                            "try: r.step()\nexcept RuntimeError: pass\nelse: sys.exit(1)",
    "an exit in a callback": "run.on_step(lambda r, s: sys.exit(0)); run.step()",
}


def ended(code):
    return subprocess.run([sys.executable, "-X", "faulthandler", "-c", START.format(tests=str(Path(__file__).parent)) + code],
                          capture_output=True, text=True)


@pytest.mark.parametrize("what", ENDS)
def test_python_ends_well_with(what):
    process = ended(ENDS[what])
    assert process.returncode == 0 and process.stderr == "", process.stderr


@pytest.mark.parametrize("first", ["drench", "vtk"])
def test_another_vtk_in_the_process_does_no_harm(first):
    pytest.importorskip("pyvista")
    code = "import pyvista\n" \
           "bowl = drench.Simulation(drench.scenes / 'bowl.yaml')  # reads a mesh by its own VTK\nbowl.step()\n" \
           "assert pyvista.Sphere().clean().n_points > 100\n" \
           "assert run.to_pyvista()['cloth'].compute_normals().n_points == 289\n"
    start = "import pyvista\n" if first == "vtk" else ""
    process = subprocess.run([sys.executable, "-c", start + START.format(tests=str(Path(__file__).parent)) + code],
                             capture_output=True, text=True)
    assert process.returncode == 0, process.stderr


FORK = """
import os
child = os.fork()
if child == 0:
    try:
        run.step()
        drench.Simulation(SCENE).step()
        os._exit(0)
    except RuntimeError as error:
        os._exit(1 if "spawn" in str(error) else 2)
run.step()
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
@pytest.mark.parametrize("threads", [1, 2])
def test_a_forked_process_computes_or_says_why_not(threads):
    import drench
    if drench.info()["backend"] != "OpenMP":
        pytest.skip("a build with threads")
    code = START.format(tests=str(Path(__file__).parent)) + FORK
    process = subprocess.run([sys.executable, "-c", code], env={**os.environ, "OMP_NUM_THREADS": str(threads)}, timeout=60)
    assert process.returncode == (0 if threads == 1 else 1)

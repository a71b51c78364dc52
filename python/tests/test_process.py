"""How a process ends that still has runs, views and arrays, and which libraries it can have beside drench."""

import subprocess
import sys

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
    from pathlib import Path
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
    from pathlib import Path
    process = subprocess.run([sys.executable, "-c", start + START.format(tests=str(Path(__file__).parent)) + code],
                             capture_output=True, text=True)
    assert process.returncode == 0, process.stderr

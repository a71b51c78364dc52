"""Water interacting with absorbent cloth: a particle liquid coupled with cloth that absorbs, wicks and drips. All in SI units.

    import drench
    run = drench.Simulation("scene.yaml")
    for step in run:
        print(step.time, step.particles, run.fields["fluid_position"].numpy().mean(axis=0))
"""

from pathlib import Path

try:
    from ._core import (CheckpointError, DeviceError, Error, RunFailure, SceneError, SetupError, StaleView, __version__, info,
                        precision, schema, set_threads)
except ImportError as _missing:
    if "libcuda" not in str(_missing):
        raise
    raise ImportError("this drench is built for NVIDIA GPUs, and the machine has no NVIDIA driver (libcuda.so.1): install the "
                      "driver, or the package drench for CPUs instead") from _missing
from .batch import Batch, BatchError
from .bodies import Bodies, Body, Wrench
from .fields import FieldView
from .recording import Recording, write_picture, write_report
from .scene import Scene
from .simulation import Frame, Simulation, Step

for _error in (Error, BatchError, CheckpointError, DeviceError, RunFailure, SceneError, SetupError, StaleView):
    _error.__module__ = "drench"  # as users name them

#: The folder of the scenes that come with drench.
scenes = Path(__file__).parent / "scenes"

__all__ = ["Batch", "BatchError", "Bodies", "Body", "CheckpointError", "DeviceError", "Error", "FieldView", "Frame", "Recording",
           "RunFailure", "Scene", "SceneError", "SetupError", "Simulation", "StaleView", "Step", "__version__", "info", "precision", "scenes",
           "schema", "set_threads", "Wrench", "write_picture", "write_report"]

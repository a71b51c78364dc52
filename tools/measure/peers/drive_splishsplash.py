"""SPlisHSPlasH's DFSPH (PyPI: pysplishsplash) on the block: see driving.py.

Its own block sampler, cubic lattice; particles of volume d³, support 2 d. Walls are volume maps (Bender et al. 2019), as in
its own scenes, or a layer of particles (Akinci et al. 2012), of a box that is larger by d on each side: nearer, the block
bursts from the corners in its first steps."""

import ctypes
import importlib.util
import json
import time
from importlib.metadata import version
from pathlib import Path

from driving import recorder


def load():
    """The wheel brings its own libGLdispatch, and crashes where the system's libGL brings another one first."""
    libraries = Path(importlib.util.find_spec("pysplishsplash").origin).parent / "pysplishsplash.libs"
    for library in libraries.glob("libGLdispatch*"):
        ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
    import pysplishsplash
    return pysplishsplash


def write_box(path):
    """A unit cube around the origin."""
    corners = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    faces = [(1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)]
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) +
                    "".join(f"f {a} {b} {c}\nf {a} {c} {d}\n" for a, b, c, d in faces))


METHODS = {"Akinci": 0, "volume maps": 2}


def scene(block):
    d = block.spacing
    percent = 100 * block.tolerance
    return {
        "Configuration": {
            "particleRadius": d / 2, "gravitation": [0, -block.gravity, 0], "timeStepSize": block.step, "cflMethod": 0,
            "simulationMethod": 4, "boundaryHandlingMethod": METHODS[block.walls], "pause": False,
            "stopAt": (block.steps - 0.5) * block.step,
            "DFSPH": {"minIterations": 2, "maxIterations": 100, "maxError": percent, "maxIterationsV": 100,
                      "maxErrorV": percent, "enableDivergenceSolver": True}},
        "Materials": [{"id": "Fluid", "density0": block.density, "viscosityMethod": 1,
                       "Standard viscosity": {"viscosity": block.viscosity, "viscosityBoundary": block.viscosity}}],
        "RigidBodies": [{"geometryFile": "box.obj", "translation": [side / 2 for side in block.box],
                         "scale": [side + 2 * d for side in block.box], "isDynamic": False, "isWall": True,
                         "mapInvert": True, "mapThickness": 0.0, "mapResolution": [25, 25, 25]}],
        # Its sampler leaves a particle free on either side, and has its first one at start + d.
        "FluidBlocks": [{"denseMode": 0, "start": [-d / 2] * 3, "end": [(n + 0.5) * d for n in block.counts]}]}


def main():
    block = recorder()
    sph = load()
    import numpy
    write_box(block.folder / "box.obj")
    (block.folder / "scene.json").write_text(json.dumps(scene(block)))
    base = sph.Exec.SimulatorBase()
    base.init(useGui=False, sceneFile=str((block.folder / "scene.json").resolve()),
              outputDir=str((block.folder / "output").resolve()))
    base.initSimulation()
    simulation = sph.Simulation.getCurrent()
    began = time.perf_counter()

    def after_step():
        nonlocal began
        ended = time.perf_counter()
        solver, liquid = simulation.getTimeStep(), simulation.getFluidModel(0)
        block.record_step(1e3 * (ended - began), solver.getValueUInt(solver.SOLVER_ITERATIONS),
                          solver.getValueUInt(solver.SOLVER_ITERATIONS_V))
        if block.is_sampled():
            count = liquid.numActiveParticles()  # more are kept in reserve
            block.record_sample(numpy.asarray(liquid.getFieldBuffer("position"))[:count],
                                numpy.asarray(liquid.getFieldBuffer("density"))[:count] / block.density)
        began = time.perf_counter()

    base.setTimeStepCB(after_step)
    base.runSimulation()
    liquid = simulation.getFluidModel(0)
    block.finish(f"SPlisHSPlasH {version('pysplishsplash')}, {block.walls}", liquid.numActiveParticles(), liquid.getVolume(0))
    base.cleanup()


if __name__ == "__main__":
    main()

"""SPlisHSPlasH's DFSPH on the column of tools/measure/still_water: still_splishsplash.py FOLDER, which has column.json; writes result.json
there. The box stands off the liquid by a part of a spacing in which it comes to rest between its walls as wide as it was cut;
Akinci's particles need a whole one, nearer the column bursts."""

import json
import sys
from pathlib import Path

from drive_splishsplash import load, write_box

METHODS = {"Akinci": (0, 1), "volume maps": (2, 0.6), "tube maps": (3, 0.06)}  # and the gap, in spacings


def scene(column):
    d = column["height"] / column["layers"]
    method, gap = METHODS[column["walls"]]
    sides = [column["wide"] * d, 0.7, column["wide"] * d]
    percent = 100 * column["tolerance"]
    counts = (column["wide"], column["layers"], column["wide"])
    return {
        "Configuration": {
            "particleRadius": d / 2, "gravitation": [0, -column["gravity"], 0], "timeStepSize": column["step"], "cflMethod": 0,
            "simulationMethod": 4, "boundaryHandlingMethod": method, "pause": False,
            "stopAt": (3 * column["period"] - 0.5) * column["step"],
            "DFSPH": {"minIterations": 2, "maxIterations": 1000, "maxError": percent, "maxIterationsV": 1000,
                      "maxErrorV": percent, "enableDivergenceSolver": True}},
        "Materials": [{"id": "Fluid", "density0": 1000, "viscosityMethod": 1,
                       "Standard viscosity": {"viscosity": 0.003, "viscosityBoundary": 0.003}}],
        "RigidBodies": [{"geometryFile": "box.obj", "translation": [side / 2 for side in sides],
                         "scale": [side + 2 * gap * d for side in sides], "isDynamic": False, "isWall": True,
                         "mapInvert": True, "mapThickness": 0.0, "mapResolution": [25, 25, 25]}],
        "FluidBlocks": [{"denseMode": 0, "start": [-d / 2] * 3, "end": [(n + 0.5) * d for n in counts]}]}


def main():
    folder = Path(sys.argv[1])
    column = json.loads((folder / "column.json").read_text())
    sph = load()
    import numpy
    write_box(folder / "box.obj")
    (folder / "scene.json").write_text(json.dumps(scene(column)))
    base = sph.Exec.SimulatorBase()
    base.init(useGui=False, sceneFile=str((folder / "scene.json").resolve()), outputDir=str((folder / "output").resolve()))
    base.initSimulation()
    simulation = sph.Simulation.getCurrent()
    heights, pressures, energies, iterations, steps = [], [], [], [], [0]

    def after_step():
        steps[0] += 1
        if steps[0] <= 2 * column["period"]:
            return
        liquid, solver = simulation.getFluidModel(0), simulation.getTimeStep()
        count = liquid.numActiveParticles()
        heights.append(numpy.array(liquid.getFieldBuffer("position"))[:count, 1])
        # Its warm start keeps p/ρ² times the square of the step, per unit of density.
        pressures.append(numpy.array(liquid.getFieldBuffer("p / rho^2"))[:count] / column["step"]**2)
        speeds = numpy.asarray(liquid.getFieldBuffer("velocity"))[:count]
        energies.append(0.5 * 1000 * liquid.getVolume(0) * float((speeds**2).sum()))
        iterations.append(solver.getValueUInt(solver.SOLVER_ITERATIONS))

    base.setTimeStepCB(after_step)
    base.runSimulation()
    result = {"heights": [float(y) for y in numpy.mean(heights, 0)], "pressures": [float(p) for p in numpy.mean(pressures, 0)],
              "energy": max(energies), "iterations": float(numpy.mean(iterations))}
    (folder / "result.json").write_text(json.dumps(result))
    base.cleanup()


main()

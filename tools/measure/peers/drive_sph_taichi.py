"""SPH_Taichi's DFSPH (github.com/erizmr/SPH_Taichi, with PyPI's taichi) on the block: see driving.py.

Particles of volume d³ as in drench, support 2 d. No particles stand for the walls, which are a support inside its domain: a
particle that leaves the box is put back on its face. Surface tension, which is fixed in its source, is off."""

import contextlib
import io
import json
import sys
import time
from importlib.metadata import version

from driving import counted, recorder


def scene(block):
    d, wall = block.spacing, block.support
    return {
        "Configuration": {
            "domainStart": [0, 0, 0], "domainEnd": [side + 2 * wall for side in block.box], "particleRadius": d / 2,
            "density0": block.density, "simulationMethod": 4, "gravitation": [0, -block.gravity, 0],
            "timeStepSize": block.step, "stiffness": 50000, "exponent": 7, "boundaryHandlingMethod": 0},
        "FluidBlocks": [{
            "objectId": 0, "start": [0, 0, 0], "end": [(n - 0.5) * d for n in block.counts],
            "translation": [wall + d / 2] * 3, "scale": [1, 1, 1], "velocity": [0, 0, 0], "density": block.density,
            "color": [50, 100, 200]}]}


class HostScan:
    """taichi's own prefix sum runs on GPUs alone."""

    def run(self, field):
        field.from_numpy(field.to_numpy().cumsum(dtype="int32"))


def main():
    block = recorder()
    sys.path.insert(0, block.source)
    import numpy
    import taichi as ti
    gpu = block.device == "gpu"
    ti.init(arch=ti.cuda if gpu else ti.cpu, cpu_max_num_threads=block.threads)
    from config_builder import SimConfig
    from particle_system import ParticleSystem
    path = block.folder / "scene.json"
    path.write_text(json.dumps(scene(block)))
    system = ParticleSystem(SimConfig(scene_file_path=str(path)))
    volume = block.spacing**3  # 0.8 of it is SPH_Taichi's own: the block would shrink by a fifth first
    system.m_V.fill(volume)
    system.m.fill(volume * block.density)
    if not gpu:
        system.prefix_sum_executor = HostScan()
    solver = system.build_solver()
    solver.surface_tension, solver.viscosity = 0.0, block.viscosity
    solver.max_error = solver.max_error_V = 100 * block.tolerance
    density, divergence = counted(solver, "pressure_solve_iteration"), counted(solver, "divergence_solver_iteration")
    solver.initialize()
    for _ in range(block.steps):
        density[0] = divergence[0] = 0
        ti.sync()
        began = time.perf_counter()
        with contextlib.redirect_stdout(io.StringIO()):  # it prints each solve
            solver.step()
        ti.sync()
        block.record_step(1e3 * (time.perf_counter() - began), density[0], divergence[0])
        if block.is_sampled():
            block.record_sample(system.x.to_numpy() - numpy.float32(block.support), system.density.to_numpy() / block.density)
    block.finish(f"SPH_Taichi, taichi {version('taichi')}", system.fluid_particle_num, volume)


main()

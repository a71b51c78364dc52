"""Genesis' DFSPH (PyPI: genesis-world, and torch) on the block: see driving.py. Its z is up.

Its own regular sampler; particles of volume d³ as in drench, support 2 d. No particles stand for the walls: a particle that
leaves the box is put back on its face. Surface tension is off."""

import os
import time
from importlib.metadata import version

from driving import counted, recorder

TWICE = 2  # in 1.4.5 a step with DFSPH adds the acceleration twice, to the velocity before and after the forces


def main():
    block = recorder()
    os.environ["QD_CPU_MAX_NUM_THREADS"] = str(block.threads)
    import genesis as gs
    import quadrants as qd
    gs.init(backend=gs.gpu if block.device == "gpu" else gs.cpu, precision="32", logging_level="warning", seed=0)
    percent = 100 * block.tolerance
    x, y, z = block.box
    wide, high, deep = (n * block.spacing for n in block.counts)
    scene = gs.Scene(
        sim_options=gs.options.SimOptions(dt=block.step, substeps=1, gravity=(0, 0, -block.gravity / TWICE)),
        sph_options=gs.options.SPHOptions(particle_size=block.spacing, pressure_solver="DFSPH", lower_bound=(0, 0, 0),
                                          upper_bound=(x, z, y), max_density_error_percent=percent,
                                          max_divergence_error=percent),
        show_viewer=False)
    scene.add_entity(material=gs.materials.SPH.Liquid(rho=block.density, mu=block.viscosity / TWICE, gamma=0.0,
                                                      sampler="regular"),
                     morph=gs.morphs.Box(lower=(0, 0, 0), upper=(wide, deep, high)))
    solver = scene.sim.sph_solver
    solver._particle_volume = block.spacing**3  # 0.8 of it is Genesis' own: the block would shrink by a fifth first
    scene.build()
    density = counted(solver, "_density_solve_iteration")
    divergence = counted(solver, "_divergence_solver_iteration")
    for _ in range(block.steps):
        density[0] = divergence[0] = 0
        qd.sync()
        began = time.perf_counter()
        scene.step()
        qd.sync()
        block.record_step(1e3 * (time.perf_counter() - began), density[0], divergence[0])
        if block.is_sampled():
            block.record_sample(solver.particles.pos.to_numpy()[:, 0, [0, 2, 1]],
                         solver.particles.rho.to_numpy()[:, 0] / block.density)
    block.finish(f"Genesis {version('genesis-world')}", solver.n_particles, solver.particle_volume)


main()

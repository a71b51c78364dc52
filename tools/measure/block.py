"""The block of liquid that tools/bench and tools/measure/scaling measure: 0.5 × 1 × 0.5 m collapses in the corner of a closed box
of 1 m, y up. Δt is 1 ms at 1/64 m and in proportion to the spacing, and so is the viscosity: CFL number and viscous passes
are the same at all."""

from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Block:
    columns: int  # particles along the short sides; twice as many upwards
    spacing: float  # m
    step: float  # s
    viscosity: float  # m²/s
    tolerance: float = 1e-3  # of both pressure solves, 1

    @property
    def particles(self):
        return 2 * self.columns**3

    @property
    def support(self):
        return 2 * self.spacing

    def description(self):
        """What a program that simulates the block has to know; SI units, counts and box along x, y, z."""
        return {**asdict(self), "counts": [self.columns, 2 * self.columns, self.columns], "box": [1, 1, 1],
                "support": self.support, "density": 1000, "gravity": 9.81}

    def scene(self):
        """For drench."""
        return f"""drench: 1
time: {{step: {self.step:.6g}, end: 100}}
domain: {{min: [-0.1, -0.1, -0.1], max: [1.1, 1.1, 1.1]}}
output: {{every: 0}}
fluid:
  spacing: {self.spacing:.10g}
  viscosity: {self.viscosity:.6g}
  solver: {{density_error: {self.tolerance:.6g}, divergence_error: {self.tolerance:.6g}}}
  sources: [{{block: {{min: [0, 0, 0], max: [0.5, 1, 0.5]}}}}]
bodies: [{{box: {{min: [0, 0, 0], max: [1, 1, 1], inside: true}}}}]
"""


def block_of(particles, tolerance=1e-3):
    """The block with the number of particles next to the one asked for."""
    columns = max(2, round((particles / 2) ** (1 / 3)))
    d = 0.5 / columns
    return Block(columns, d, float(f"{0.064 * d:.6g}"), float(f"{0.64 * d:.6g}"), tolerance)

"""Shakes a wet cloth at one edge, along a sine, and reads the force that it takes.

    python shake_cloth.py [--until 2] [--amplitude 0.02] [--frequency 2] [--csv force.csv]
"""

import argparse
import csv
import math

import numpy as np

import drench

SCENE = {
    "time": {"step": 0.002, "end": 10.0},
    "domain": {"min": [-0.5, -1, -0.5], "max": [0.5, 0.5, 0.5]},
    "output": {"every": 0},
    "fluid": {"spacing": 0.02, "sources": [{"block": {"min": [-0.08, 0.03, -0.08], "max": [0.08, 0.11, 0.08]}}]},
    "cloth": [{"name": "towel", "mesh": {"grid": {"size": [0.4, 0.4], "nodes": [17, 17]}},
               "pin": [{"box": {"min": [-0.21, -0.01, -0.21], "max": [-0.19, 0.01, 0.21]}},
                       {"box": {"min": [0.19, -0.01, -0.21], "max": [0.21, 0.01, 0.21]}}],
               "porous": {}}],
}


def height(time, amplitude, frequency):
    """m, of the edge that is shaken."""
    return amplitude * math.sin(2 * math.pi * frequency * time)


def shake(run, until, amplitude, frequency):
    """A row (time, height, force x y z) a step."""
    while run.time < until - 1e-9:
        # the mean velocity over the step to come, so that the edge is on the curve at its end
        dt = run.scene.time_step
        rise = height(run.time + dt, amplitude, frequency) - height(run.time, amplitude, frequency)
        run.set_pin_velocity("towel", 1, [0, rise / dt, 0])
        run.step(dt)
        yield run.time, height(run.time, amplitude, frequency), *run.pin_force("towel", 1)


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--until", type=float, default=2.0, help="s")
    options.add_argument("--amplitude", type=float, default=0.02, help="m")
    options.add_argument("--frequency", type=float, default=2.0, help="Hz")
    options.add_argument("--csv", default="force.csv")
    given = options.parse_args()

    run = drench.Simulation(SCENE)
    rows = list(shake(run, given.until, given.amplitude, given.frequency))
    with open(given.csv, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time", "height", "force_x", "force_y", "force_z"])
        writer.writerows(rows)
    force = np.linalg.norm([row[2:] for row in rows], axis=1)
    print(f"largest force {force.max():.2f} N, mean {force.mean():.2f} N; "
          f"{run.last.mass_cloth * run.quantum * 1000:.0f} g of water in the cloth; {given.csv}")


if __name__ == "__main__":
    main()

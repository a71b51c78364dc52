"""A gripper dips a towel into water and lifts it out; the force on the gripper shows what the towel has taken up.

    python dip_towel.py [--csv wrench.csv]
"""

import argparse
import csv

import numpy as np

import drench

WIDTH, LENGTH, ROD = 0.16, 0.24, 0.012  # m: of the towel; edge of the rod that it hangs over
UP, DOWN = 0.32, 0.16  # m: heights of the rod
SCENE = {
    "time": {"step": 0.002, "end": 10.0},
    "domain": {"min": [-0.5, -0.1, -0.5], "max": [0.5, 0.8, 0.5]},
    "output": {"every": 0},
    "fluid": {"spacing": 0.015, "sources": [{"block": {"min": [-0.12, 0, -0.12], "max": [0.12, 0.12, 0.12]}}]},
    "cloth": [{"name": "towel", "mesh": {"grid": {"size": [LENGTH, WIDTH], "nodes": [25, 17]}},
               "place": {"position": [0, UP + ROD / 2 + 0.002, 0]}, "areal_density": 0.4, "thickness": 0.002,
               "friction": 0.8, "damping": 2.0, "porous": {}}],
    "bodies": [{"box": {"min": [-0.12, 0, -0.12], "max": [0.12, 0.7, 0.12], "inside": True}},
               {"name": "gripper", "box": {"min": [-ROD / 2, UP - ROD / 2, -0.1], "max": [ROD / 2, UP + ROD / 2, 0.1],
                                           "commanded": True}}],
}


def weight(run):
    """Of the towel and of what it has taken up, N."""
    liquid = run.quantum * float(run.state()["node_liquid"].sum())
    return 9.81 * (0.4 * WIDTH * LENGTH + liquid)


def dip(run):
    """A row (time, height of the gripper, force of cloth and of liquid on it, weight of the towel) a step."""
    gripper = run.bodies["gripper"]
    for height, duration, until in ((UP, 1.0, 1.0), (DOWN, 0.8, 2.0), (UP, 0.8, 5.0)):
        gripper.set_pose([0, height, 0], duration=duration)
        while run.time < until - 1e-9:
            run.step(until - run.time)
            yield (run.time, gripper.position[1], gripper.cloth_wrench.force[1], gripper.liquid_wrench.force[1],
                   weight(run))


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--csv", default="wrench.csv")
    given = options.parse_args()
    run = drench.Simulation(SCENE)
    rows = list(dip(run))
    with open(given.csv, "w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(["time", "height", "cloth_force", "liquid_force", "towel_weight"])
        table.writerows(rows)
    data = np.array(rows)
    for name, start, end in (("dry", 0.8, 1.0), ("wet", 4.0, 5.0)):
        at = data[(data[:, 0] > start) & (data[:, 0] <= end)]
        print(f"{name}: the gripper carries {-at[:, 2].mean():.3f} N of cloth, the towel weighs {at[:, 4].mean():.3f} N")


if __name__ == "__main__":
    main()

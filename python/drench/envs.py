"""A Gymnasium environment: a gripper dips a towel into a tub and lifts a wanted mass of water out of it.

    import gymnasium
    env = gymnasium.make("drench.envs:TowelDip-v0")

Needs the package gymnasium.
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from .simulation import Simulation

WIDTH, HEIGHT = 0.12, 0.16  # m: of the towel
WATER = 0.12  # m: depth of the water
REST = 0.34  # m: height of the gripper at the start
SPEED = 0.5  # m/s: of the gripper at an action of 1
REACH = np.array([[-0.05, 0.16, -0.05], [0.05, 0.36, 0.05]])  # m: where the gripper may be
TOP = REST - 0.01  # m: of the towel at the start


def scene(spacing: float = 0.02) -> dict[str, Any]:
    """The scene with particles of diameter `spacing`, m: a tub, a towel, and a gripper that holds its upper edge."""
    return {
        "time": {"step": 0.004, "end": 1e5},
        "domain": {"min": [-0.3, -0.1, -0.3], "max": [0.3, 0.6, 0.3]},
        "output": {"every": 0},
        "fluid": {"spacing": spacing, "sources": [{"block": {"min": [-0.12, 0, -0.12], "max": [0.12, WATER, 0.12]}}]},
        "cloth": [{"name": "towel", "mesh": {"grid": {"size": [WIDTH, HEIGHT], "nodes": [10, 13]}},
                   "place": {"position": [0, TOP - HEIGHT / 2, 0], "rotate": {"axis": [1, 0, 0], "degrees": 90}},
                   "areal_density": 0.4, "thickness": 0.002, "damping": 2.0, "porous": {},
                   "pin": [{"box": {"min": [-1, TOP - 1e-3, -1], "max": [1, TOP + 1e-3, 1]}, "body": "gripper"}]}],
        "bodies": [{"box": {"min": [-0.12, 0, -0.12], "max": [0.12, 0.5, 0.12], "inside": True}},
                   {"name": "gripper", "box": {"min": [-0.07, REST - 0.008, -0.01], "max": [0.07, REST + 0.008, 0.01],
                                               "commanded": True}}],
    }


class TowelDip(gymnasium.Env):
    """Lift a wanted mass of water out of a tub with a towel.

    Action, 3 numbers from −1 to 1: the velocity of the gripper over 0.5 m/s. It stops at the limits of its reach.
    Observation, 12 numbers: position (m) and velocity (m/s) of the gripper, force on it (N), mean saturation of the towel (1),
    the mass of water in it and the wanted mass (both over the towel's capacity).
    Option `target` of reset(): the wanted mass, from 0 to 1; by default random from 0.3 to 0.9.
    Reward: minus the difference of these two masses, plus 1 at the end of the episode if it is below 0.05 and the towel hangs
    above the water.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, spacing: float = 0.02, frame: float = 0.04, seconds: float = 4.0, render_mode: str | None = None):
        """spacing: particle diameter, m; frame: time between two actions, s; seconds: length of an episode."""
        self.render_mode = render_mode
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (3,), np.float32)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (12,), np.float32)
        self.frame, self.seconds = frame, seconds
        self.run = Simulation(scene(spacing))
        self.capacity = float(self.run.capacity().sum())  # kg
        self.target = 0.5

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        target = float((options or {}).get("target", self.np_random.uniform(0.3, 0.9)))
        if not 0 < target < 1:
            raise ValueError(f"target: {target}; allowed: above 0 and below 1, the water in the towel over its capacity")
        if self.run.steps > 0:
            self.run.reset()
        self.target = target
        return self._observation(), self._info()

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        gripper, end = self.run.bodies["gripper"], self.run.time + self.frame
        wanted = gripper.position + SPEED * self.frame * np.clip(np.asarray(action, dtype=float), -1, 1)
        gripper.set_velocity((np.clip(wanted, *REACH) - gripper.position) / self.frame)
        self.run.run_until(end)
        error = abs(self._carried() - self.target)
        over = self.run.time >= self.seconds - 1e-9
        above = gripper.position[1] - REST + TOP - HEIGHT > WATER
        reward = -error + (1.0 if over and error < 0.05 and above else 0.0)
        return self._observation(), float(reward), False, over, self._info()

    def _carried(self) -> float:
        return float(self.run.mass("node_liquid").sum()) / self.capacity

    def _observation(self) -> np.ndarray:
        gripper = self.run.bodies["gripper"]
        parts = [gripper.position, gripper.velocity, gripper.wrench.force,
                 [float(self.run.saturation().mean()), self._carried(), self.target]]
        return np.concatenate(parts).astype(np.float32)

    def _info(self) -> dict[str, Any]:
        return {"time": self.run.time, "water": self._carried() * self.capacity}


gymnasium.register("TowelDip-v0", entry_point="drench.envs:TowelDip")

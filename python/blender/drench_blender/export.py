"""Writes the scene file and the meshes of a simulation.

Coordinates are in metres and in the axes of Blender's world, with z up; the scene's key `gravity` gives the program the
direction, so nothing is rotated."""

import numpy as np

from . import meshes, roles, text
from .problem import Names, Problem

MOST_FRAMES = 100_000


class Times:
    """The frames of a simulation, and their times in s from the first frame. `fps`: per second of simulated time."""

    def __init__(self, scene):
        own = scene.drench
        self.first = own.frame_start if own.use_range else scene.frame_start
        self.last = own.frame_end if own.use_range else scene.frame_end
        self.fps = scene.render.fps / scene.render.fps_base / roles.number(own.time_scale)
        if self.last <= self.first:
            raise Problem(f"the frame range {self.first} to {self.last} is too short: the last frame must be after "
                          "the first")
        if self.count > MOST_FRAMES:
            raise Problem(f"{self.count} frames are too many: use at most {MOST_FRAMES}")

    @property
    def count(self):
        return self.last - self.first + 1

    def time(self, frame):
        return (frame - self.first) / self.fps


class Exporter:
    """One export of a scene into `folder`; `progress` is called with the part that is done, 0 to 1."""

    def __init__(self, context, folder, progress=lambda part: None):
        self.context, self.scene, self.folder, self.progress = context, context.scene, folder, progress
        self.unit = meshes.unit(self.scene)
        self.spacing = roles.number(self.scene.drench.spacing * self.unit)  # m
        self.times = Times(self.scene)
        self.parts = roles.parts(self)

    def write(self):
        """Writes the files and returns what playback needs to know about them."""
        cloths = [part.thing for part in self.parts if isinstance(part, roles.Cloth)]
        for thing in cloths:
            meshes.check_modifiers(thing)
        (self.folder / "meshes").mkdir(parents=True, exist_ok=True)
        here = self.scene.frame_current, self.scene.frame_subframe
        try:
            things = [part.thing for part in self.parts]
            if self.scene.drench.domain is not None:
                things.append(self.scene.drench.domain)
            with meshes.visible(things, self.context.view_layer), meshes.without_results(cloths):
                for frame in range(self.times.first, self.times.last + 1):
                    self._go_to(frame)
                    self.progress((frame - self.times.first) / self.times.count)
                    if not self._needs_more(frame):
                        break
        finally:
            self.scene.frame_set(here[0], subframe=here[1])
        for part in self.parts:
            part.finish()
        self.domain = self.domain or self._automatic_domain()
        for part in self._of(roles.Collider):
            part.set_domain(self.domain[1])
        scene = self._scene()
        (self.folder / "scene.yaml").write_text(text.scene_text(scene), encoding="utf-8")
        liquid = "fluid" in scene
        return {**self._record(), "fluid": liquid, "surface": liquid and scene["output"]["surface"]}

    def mesh(self, thing):
        return meshes.Mesh(thing, self.graph, self.unit)

    def _go_to(self, frame):
        self.scene.frame_set(frame)
        self.graph = self.context.evaluated_depsgraph_get()

    def _needs_more(self, frame):
        """Gives the frame to each part; false if none of them may change later."""
        if frame == self.times.first:
            self.domain = self._chosen_domain()
        for part in self.parts:
            part.first(self) if frame == self.times.first else part.later(self, frame)
        return any(part.may_move for part in self.parts)

    def _of(self, kind):
        return [part for part in self.parts if isinstance(part, kind)]

    def gravity(self):
        """m/s². Blender's value is taken as it is, whatever the unit of length."""
        return [roles.number(g) for g in self.scene.gravity] if self.scene.use_gravity else [0.0, 0.0, 0.0]

    def _scene(self):
        own, times = self.scene.drench, self.times
        every = 1 / times.fps
        scene = {"drench": 1,
                 "time": {"step": every / own.substeps, "end": times.time(times.last),
                          "mode": "cfl" if own.adaptive else "fixed"},
                 "gravity": self.gravity(),
                 "domain": {"min": self.domain[0].tolist(), "max": self.domain[1].tolist()},
                 "output": {"every": every, "checkpoint_every": own.checkpoint_frames * every}}
        sources = [part.entry for part in self._of(roles.Source)]
        wet = any(part.thing.drench.saturation > 0 and part.thing.drench.absorbs for part in self._of(roles.Cloth))
        if sources or wet:
            viscosity, tension = roles.liquid_values(own)
            scene["fluid"] = {"spacing": self.spacing, "viscosity": viscosity, "surface_tension": tension,
                              **({"sources": sources} if sources else {})}
            scene["output"]["surface"] = own.surface
        if self.spacing < 1e-6:
            raise Problem("the particle spacing is below 1e-6 m: increase it, or check the unit scale of the scene")
        for key, kind in (("cloth", roles.Cloth), ("bodies", roles.Collider)):
            if entries := [part.entry for part in self._of(kind)]:
                scene[key] = entries
        return scene

    def _chosen_domain(self):
        """(lowest, highest corner) in m of the object that the user chose, at the first frame; None without one."""
        thing = self.scene.drench.domain
        if thing is None:
            return None
        low, high = self.mesh(thing).box() if thing.type == "MESH" else self._empty_box(thing)
        if (high - low).min() <= 0:
            raise Problem(f"the domain '{thing.name}' is flat: use a box")
        return low, high

    def _empty_box(self, thing):
        corners = np.array([thing.matrix_world @ (thing.empty_display_size * v) for v in roles.CUBE]) \
            if thing.type == "EMPTY" else None
        if corners is None:
            raise Problem(f"the domain '{thing.name}' is neither a mesh nor an empty: choose one of them")
        return self.unit * corners.min(0), self.unit * corners.max(0)

    def _automatic_domain(self):
        """(lowest, highest corner) in m of a box around cloth, liquid, emitters and what they may reach."""
        boxes = [part.box for part in self._of((roles.Cloth, roles.Source))]
        low, high = np.min([b[0] for b in boxes], 0), np.max([b[1] for b in boxes], 0)
        reach = (high - low).max()
        for part in self._of(roles.Collider):
            near = part.near(low, high, reach)
            low, high = np.minimum(low, near[0]), np.maximum(high, near[1])
        margin = 0.2 * (high - low).max() + 4 * self.spacing
        low, high = low - margin, high + margin
        gravity = np.array(self.gravity())
        if gravity.any():  # cloth sags under liquid, and drops should fall out of sight before they are removed
            fall = reach * gravity / np.linalg.norm(gravity)
            low, high = np.minimum(low, low + fall), np.maximum(high, high + fall)
        return low, high

    def _record(self):
        cloths, colliders, sources = (self._of(kind) for kind in (roles.Cloth, roles.Collider, roles.Source))
        names = Names(*([part.thing.name for part in parts] for parts in (
            cloths, colliders, sources, *(self._of(kind) for kind in (roles.Liquid, roles.Nozzle, roles.Rain,
                                                                      roles.Faces, roles.Spray)))))
        return {"first_frame": self.times.first, "frames": self.times.count, "every": 1 / self.times.fps,
                "unit": self.unit, "speed": roles.number(self.scene.drench.time_scale),
                "names": names.as_dict(), "cloths": [part.saved() for part in cloths]}

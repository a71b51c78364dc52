"""What each role of an object adds to the scene file. A part sees every frame of the export in turn."""

import math

import numpy as np

from . import meshes, text
from .problem import Problem
from .properties import LIQUIDS

CUBE = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
MOVED = 1e-6  # of its size: how far an object may move and still counts as fixed
FIRM = 1e5  # N/m: of pins that hold rigidly until they are released


def number(value):
    """A setting without the noise of Blender's single precision: 0.2 instead of 0.20000000298."""
    return float(f"{value:.7g}")


def liquid_values(own):
    """(kinematic viscosity in m²/s, surface tension in N/m)"""
    viscosity = number(own.viscosity) if own.liquid == "OWN" else LIQUIDS[own.liquid][0]
    return viscosity, number(own.surface_tension)


def scene_objects(scene, role):
    """The objects of a role, by name, so that the order does not depend on how they were made."""
    found = [thing for thing in scene.objects if thing.drench.role == role]
    return sorted(found, key=lambda thing: thing.name)


def emitter(thing, number):
    return {"NOZZLE": Nozzle, "SPRAY": Spray, "FACES": Faces, "RAIN": Rain}[thing.drench.emitter_shape](thing, number)


def parts(exporter):
    """The parts of a scene, in a fixed order."""
    kinds = (("CLOTH", Cloth), ("LIQUID", Liquid), ("EMITTER", emitter), ("COLLIDER", Collider))
    found = [kind(thing, number) for role, kind in kinds
             for number, thing in enumerate(scene_objects(exporter.scene, role))]
    if not any(isinstance(part, (Cloth, Source)) for part in found):
        raise Problem("there is nothing to simulate: give an object the role Cloth, Liquid or Emitter "
                      "(Properties, tab Physics, panel Drench)")
    for part in found:
        if isinstance(part, (Cloth, Liquid, Collider)) and part.thing.type != "MESH":
            raise Problem(f"'{part.thing.name}' is not a mesh: convert it (Object, Convert, Mesh)")
    return found


class Part:
    """An object in a simulation. `may_move`: does it need the later frames?"""

    may_move = False

    def __init__(self, thing, number):
        self.thing, self.number, self.own = thing, number, thing.drench

    def later(self, exporter, frame):
        pass

    def finish(self):
        pass


def remove_later_files(folder, stem, count):
    """Removes the files of a sequence beyond the first `count`."""
    for path in sorted(folder.glob(f"{stem}_*.ply"))[count:]:
        path.unlink()


class Sequence:
    """Files of a mesh that may move: one per frame, removed at the end if it stood still. Points in m."""

    def __init__(self, folder, stem, points, triangles):
        self.folder, self.stem, self.start, self.triangles = folder / "meshes", stem, points, triangles
        self.size = max(float(np.linalg.norm(np.ptp(points, axis=0))), 1e-9)
        self.count, self.moves = 0, False
        self.add(points)

    def path(self, number):
        return self.folder / f"{self.stem}_{number:06d}.ply"

    def add(self, points):
        text.write_ply(self.path(self.count), points, self.triangles)
        self.count += 1
        self.moves = self.moves or np.abs(points - self.start).max() > MOVED * self.size

    def finish(self):
        """Keeps the first file alone if the mesh did not move."""
        if not self.moves:
            remove_later_files(self.folder, self.stem, 1)

    def keys(self, fps):
        """Keys of a mesh or a pin."""
        return {"sequence": f"meshes/{self.stem}_{{:06d}}.ply", "fps": fps}

    def first(self):
        return f"meshes/{self.path(0).name}"


class Cloth(Part):
    def first(self, exporter):
        mesh = exporter.mesh(self.thing)
        mesh.need_faces(self.thing)
        self.mesh = meshes.ClothMesh(mesh, self.own.weld)
        if len(self.mesh.triangles) == 0:
            raise Problem(f"'{self.thing.name}': all faces have an area of zero: correct its scale or its mesh")
        crowded = meshes.crowded_edges(self.mesh.triangles)
        if crowded:
            raise Problem(f"'{self.thing.name}': more than two faces share an edge, {crowded} times: separate the faces there "
                          "(Select > All by Trait > Non Manifold, then Split)")
        points = self.mesh.points(mesh)
        self.rest, self.triangles = mesh.points, mesh.triangles
        self.box = points.min(0), points.max(0)
        self.warp = self._warp(points, mesh.matrix)
        self.pinned = self._pinned_nodes(exporter)
        self.files = Sequence(exporter.folder, text.file_name("cloth", self.number, self.thing.name), points,
                              self.mesh.triangles)
        self.moves = False
        self.may_move = len(self.pinned) > 0
        self.times, self.fps = exporter.times, exporter.times.fps

    def later(self, exporter, frame):
        if not self.may_move:
            return
        mesh = exporter.mesh(self.thing)
        if len(mesh.points) != self.mesh.vertices or not np.array_equal(mesh.triangles, self.triangles):
            raise Problem(f"'{self.thing.name}' has other vertices or faces at frame {frame} than at frame "
                          f"{exporter.times.first}: remove the modifier or animation that changes them")
        points = self.mesh.points(mesh)
        pins = points[self.pinned]
        self.files.add(points)
        self.moves = self.moves or np.abs(pins - self.files.start[self.pinned]).max() > MOVED * self.files.size
        self.box = np.minimum(self.box[0], pins.min(0)), np.maximum(self.box[1], pins.max(0))

    def finish(self):
        self.files.moves = self.moves  # nodes without a pin do not follow the animation
        self.files.finish()

    def _warp(self, points, matrix):
        """A local axis of the object. It is tilted a little, because no triangle may be normal to it."""
        axes = (matrix[:3, :3] / np.maximum(np.linalg.norm(matrix[:3, :3], axis=0), 1e-30)).T
        choice = self.own.warp
        if choice == "AUTO":
            a, b, c = (points[self.mesh.triangles[:, k]] for k in range(3))
            normal = np.cross(b - a, c - a)
            across = np.abs(normal @ axes[2]).sum() / np.linalg.norm(normal, axis=1).sum()
            choice = "Y" if across > 0.8 else "Z"
        warp = axes["XYZ".index(choice)] + 1e-3 * np.array([0.61, 0.37, 0.23])
        return (warp / np.linalg.norm(warp)).tolist()

    def _pinned_nodes(self, exporter):
        """Numbers of the nodes whose vertices have a weight of at least 0.5 in the pin group."""
        name = self.own.pin_group
        if not name:
            return []
        group = self.thing.vertex_groups.get(name)
        if group is None:
            raise Problem(f"'{self.thing.name}' has no vertex group '{name}': choose its pin group again")
        seen = self.thing.evaluated_get(exporter.graph)
        mesh = seen.to_mesh()
        held = [v.index for v in mesh.vertices
                if any(g.group == group.index and g.weight >= 0.5 for g in v.groups)]
        seen.to_mesh_clear()
        pinned = sorted({int(node) for node in self.mesh.node[held] if node >= 0})
        if not pinned:
            raise Problem(f"'{self.thing.name}': no vertex has a weight of 0.5 or more in the pin group '{name}': "
                          "assign vertices to it, or clear the pin group")
        return pinned

    def _springs(self):
        """Keys of soft pins. Only they can be released, so pins that are rigid until then are very stiff springs."""
        own, keys = self.own, {}
        if own.use_pin_stiffness or own.use_pin_release:
            keys["stiffness"] = number(own.pin_stiffness if own.use_pin_stiffness else FIRM)
        if own.use_pin_release:
            keys["release"] = max(0.0, self.times.time(own.pin_release))
        return keys

    @property
    def entry(self):
        own = self.own
        entry = {"name": entry_name(self.thing.name, self.number), "mesh": {"file": self.files.first()},
                 "weld": "off", "clean": "off"}  # so that nodes stay in the order of the file
        if own.fabric:
            entry["fabric"] = own.fabric
        if own.use_density or not own.fabric:
            entry["areal_density"] = number(own.density)
        if own.use_thickness or not own.fabric:
            entry["thickness"] = number(own.thickness * 1e-3)
        if not own.fabric:
            entry["stretch"], entry["bend"] = number(own.stretch), number(own.bend * 1e-6)
        else:
            entry["warp"] = self.warp  # only fabrics have different yarns
        entry.update(damping=number(own.damping), friction=number(own.friction))
        if self.pinned:
            pin = {"nodes": self.pinned, **self._springs()}
            entry["pin"] = [{**pin, **self.files.keys(self.fps)} if self.moves else pin]
        if own.self_collision:
            entry["self_collision"] = True
        if own.absorbs:
            entry["friction_wet"] = number(own.friction_wet)
            if own.saturation > 0:
                box = {"min": [-1e4] * 3, "max": [1e4] * 3}
                entry["initial_saturation"] = [{"box": box, "value": number(own.saturation)}]
            entry["porous"] = {}
        return entry

    def saved(self):
        """For playback: vertices per node and back; positions at rest for vertices that no face uses. m."""
        return {"object": self.thing.name, "nodes": len(self.mesh.vertex), "node": self.mesh.node.tolist(),
                "loose": {int(v): self.rest[v].tolist() for v in np.flatnonzero(self.mesh.node < 0)}}


def entry_name(name, number):
    """At most 100 bytes, unique, without control characters."""
    plain = "".join(c if c.isprintable() else " " for c in name)
    return plain if len(plain.encode()) <= 100 and plain == name else f"cloth {number}"


class Source(Part):
    """Liquid or an emitter: `entry` of fluid.sources."""


def box_block(low, high, spacing):
    """The largest block in a box whose sides are multiples of the spacing, at least one; in its middle. m."""
    middle, size = (low + high) / 2, high - low
    size = np.maximum(np.floor(size / spacing + 1e-4), 1) * spacing
    return middle - size / 2, middle + size / 2


class Liquid(Source):
    def first(self, exporter):
        mesh = exporter.mesh(self.thing)
        mesh.need_faces(self.thing)
        self.box = mesh.box()
        if self.own.liquid_shape == "BOX":
            low, high = box_block(*self.box, exporter.spacing)
            kind, shape = "block", {"min": low.tolist(), "max": high.tolist()}
        else:
            self.files = Sequence(exporter.folder, text.file_name("liquid", self.number, self.thing.name), mesh.points,
                                  mesh.triangles)
            kind, shape = "mesh", {"file": self.files.first()}
        velocity = [number(v) for v in self.own.liquid_velocity]
        self.entry = {kind: {**shape, **({"velocity": velocity} if any(velocity) else {})}}


class Emitter(Source):
    may_move = True

    def matrix_at(self, exporter):
        return np.array(self.thing.evaluated_get(exporter.graph).matrix_world, np.float64)

    def speed_at(self, exporter):
        """m/s"""
        return number(self.thing.evaluated_get(exporter.graph).drench.emitter_speed)

    def keyframes(self, values):
        """The value of every frame as keyframes."""
        return [[k / self.times.fps, value] for k, value in enumerate(values)]

    def need_speed(self, speeds):
        if max(speeds) == 0:
            raise Problem(f"'{self.thing.name}' has a speed of zero: increase its speed, or remove its role")

    def range(self):
        """Keys `start` and `end`, s, of an emitter with a limited range of frames."""
        if not self.own.use_emitter_range:
            return {}
        start, end = self.own.emitter_start, self.own.emitter_end
        if end <= start or end <= self.times.first:
            raise Problem(f"'{self.thing.name}': its last frame, {end}, must be after its first frame, {start}, "
                          f"and after the start of the simulation, {self.times.first}")
        return {"start": max(0.0, self.times.time(start)), "end": self.times.time(end)}


class Rain(Emitter):
    """Drops from the level rectangle that the object covers, at its highest point along gravity."""

    def first(self, exporter):
        self.matrix = matrix = self.matrix_at(exporter)
        if self.thing.type == "MESH":
            low, high = exporter.mesh(self.thing).box()
        else:
            size = self.thing.empty_display_size if self.thing.type == "EMPTY" else 1
            corners = exporter.unit * (size * np.array(CUBE) @ matrix[:3, :3].T + matrix[:3, 3])
            low, high = corners.min(0), corners.max(0)
        self.box, self.times = (low, high), exporter.times
        down = int(np.abs(exporter.gravity()).argmax()) if np.any(exporter.gravity()) else 1
        level = [axis for axis in range(3) if axis != down]
        size = (high - low)[level]
        if not size.min() > 0:
            raise Problem(f"'{self.thing.name}' covers no level area for rain to fall from: use a plane or an empty that "
                          "is not flat across gravity")
        self.rain = {"center": ((low + high) / 2).tolist(), "size": size.tolist(), "rate": number(self.own.emitter_rate),
                     "diameter": number(self.own.emitter_drop)}

    def later(self, exporter, frame):
        moved = np.abs(self.matrix_at(exporter) - self.matrix)[:3].max()
        if moved > MOVED * max(1, np.abs(self.matrix[:3, 3]).max()):
            raise Problem(f"'{self.thing.name}' moves at frame {frame}, but rain stays where it is at the first frame: "
                          "remove the animation of its location, rotation and scale")
        if number(self.thing.evaluated_get(exporter.graph).drench.emitter_rate) != self.rain["rate"]:
            raise Problem(f"'{self.thing.name}' has another rate at frame {frame}, but the rate of rain is constant: "
                          "remove its animation, or use several emitters with limited frames")

    @property
    def entry(self):
        return {"rain": {**self.rain, **self.range()}}


class PointEmitter(Emitter):
    """An emitter at the origin of the object, along its local Z axis. Its location may be animated."""
    radius = 0.0  # m

    def first(self, exporter):
        self.times, self.centers, self.velocities = exporter.times, [], []
        self.later(exporter, exporter.times.first)

    def later(self, exporter, frame):
        matrix = self.matrix_at(exporter)
        axis = matrix[:3, 2] * (1 if self.own.emitter_axis == "+Z" else -1)
        length = np.linalg.norm(axis)
        if length == 0:
            raise Problem(f"'{self.thing.name}' has a scale of zero: give it another scale")
        self.centers.append(exporter.unit * matrix[:3, 3])
        self.velocities.append(self.speed_at(exporter) * axis / length)

    @property
    def box(self):
        return np.min(self.centers, 0) - self.radius, np.max(self.centers, 0) + self.radius

    def changes_velocity(self):
        return np.abs(np.subtract(self.velocities, self.velocities[0])).max() > MOVED * self.fastest()

    def fastest(self):
        """m/s"""
        return np.linalg.norm(self.velocities, axis=1).max()

    def motion(self):
        """The key `motion`, where the object moves."""
        offsets = np.subtract(self.centers, self.centers[0])
        if np.abs(offsets).max() <= MOVED * max(1, np.abs(self.centers).max()):
            return {}
        return {"motion": {"offset": self.keyframes(offsets.tolist())}}


class Nozzle(PointEmitter):
    """A round nozzle, whose speed and rotation may be animated too."""

    def first(self, exporter):
        self.radius = number(exporter.unit * self.own.emitter_radius)
        super().first(exporter)

    @property
    def entry(self):
        self.need_speed([self.fastest()])
        velocity = (self.keyframes(v.tolist() for v in self.velocities) if self.changes_velocity()
                    else self.velocities[0].tolist())
        return {"jet": {"center": self.centers[0].tolist(), "radius": self.radius, "velocity": velocity,
                        **self.motion(), **self.range()}}


class Spray(PointEmitter):
    """Drops in all directions of a cone, such as those of a shower head or a spray bottle."""

    def later(self, exporter, frame):
        super().later(exporter, frame)
        flow = number(self.thing.evaluated_get(exporter.graph).drench.emitter_flow)
        if frame == exporter.times.first:
            self.flow = flow
        if self.changes_velocity() or flow != self.flow:
            raise Problem(f"'{self.thing.name}' has another direction, speed or flow at frame {frame}, but those of a "
                          "spray are constant: remove their animation, or use several emitters with limited frames")

    @property
    def entry(self):
        self.need_speed([self.fastest()])
        direction = self.velocities[0] / self.fastest()
        return {"spray": {"center": self.centers[0].tolist(), "direction": direction.tolist(),
                          "half_angle": number(math.degrees(self.own.emitter_angle) / 2),
                          "speed": number(self.fastest()), "flow": self.flow, **self.motion(), **self.range()}}


class Faces(Emitter):
    """The faces of a mesh, which may move and change its shape. Its speed may be animated."""

    def first(self, exporter):
        mesh = exporter.mesh(self.thing)
        mesh.need_faces(self.thing)
        keep = meshes.has_area(mesh.points, mesh.triangles)
        self.used, numbers = np.unique(mesh.triangles[keep], return_inverse=True)
        if len(self.used) == 0:
            raise Problem(f"'{self.thing.name}': all faces have an area of zero: correct its scale or its mesh")
        self.mesh, self.box, self.times = mesh, mesh.box(), exporter.times
        self.files = Sequence(exporter.folder, text.file_name("emitter", self.number, self.thing.name),
                              mesh.points[self.used], numbers.reshape(-1, 3))
        self.speeds = [self.speed_at(exporter)]

    def later(self, exporter, frame):
        mesh = exporter.mesh(self.thing)
        if len(mesh.points) != len(self.mesh.points) or not np.array_equal(mesh.triangles, self.mesh.triangles):
            raise Problem(f"'{self.thing.name}' has other vertices or faces at frame {frame} than at frame "
                          f"{exporter.times.first}: remove the modifier or animation that changes them")
        self.files.add(mesh.points[self.used])
        self.speeds.append(self.speed_at(exporter))
        low, high = mesh.box()
        self.box = np.minimum(self.box[0], low), np.maximum(self.box[1], high)

    def finish(self):
        self.files.finish()

    @property
    def entry(self):
        self.need_speed(self.speeds)
        constant = min(self.speeds) == max(self.speeds)
        return {"mesh_jet": {**(self.files.keys(self.times.fps) if self.files.moves else {"file": self.files.first()}),
                             "speed": self.speeds[0] if constant else self.keyframes(self.speeds), **self.range()}}


class Collider(Part):
    def first(self, exporter):
        mesh = exporter.mesh(self.thing)
        self.top = None
        if self.own.collider_shape == "PLANE":
            normal = mesh.matrix[:3, 2]
            if np.linalg.norm(normal) == 0:
                raise Problem(f"'{self.thing.name}' has a scale of zero: give it another scale")
            self.point, self.normal = exporter.unit * mesh.matrix[:3, 3], normal / np.linalg.norm(normal)
            return
        mesh.need_faces(self.thing)
        self.box, self.mesh, self.fps = mesh.box(), mesh, exporter.times.fps
        if self.own.collider_shape == "MESH":
            keep = meshes.has_area(mesh.points, mesh.triangles)
            self.used, numbers = np.unique(mesh.triangles[keep], return_inverse=True)
            if len(self.used) == 0:
                raise Problem(f"'{self.thing.name}': all faces have an area of zero: correct its scale or its mesh")
            self.files = Sequence(exporter.folder, text.file_name("body", self.number, self.thing.name),
                                  mesh.points[self.used], numbers.reshape(-1, 3))
            self.may_move = self.own.collider_animated

    def later(self, exporter, frame):
        if not self.may_move:
            return
        mesh = exporter.mesh(self.thing)
        if len(mesh.points) != len(self.mesh.points) or not np.array_equal(mesh.triangles, self.mesh.triangles):
            raise Problem(f"'{self.thing.name}' has other vertices or faces at frame {frame} than at frame "
                          f"{exporter.times.first}: remove the modifier or animation that changes them, or turn off "
                          "Follow Animation")
        self.files.add(mesh.points[self.used])
        low, high = mesh.box()
        self.box = np.minimum(self.box[0], low), np.maximum(self.box[1], high)

    def finish(self):
        if self.own.collider_shape == "MESH":
            self.files.finish()

    def near(self, low, high, reach):
        """The part of its box, m, that lies within `reach` of the liquid's box."""
        if self.own.collider_shape == "PLANE":
            middle = (low + high) / 2
            foot = middle - np.dot(middle - self.point, self.normal) * self.normal
            return (foot, foot) if np.abs(foot - middle).max() < 2 * reach else (low, high)
        return np.clip(self.box[0], low - reach, high + reach), np.clip(self.box[1], low - reach, high + reach)

    def set_domain(self, high):
        """m: the highest corner of the domain, up to which an open container reaches."""
        self.top = high[2]

    @property
    def entry(self):
        if self.own.collider_shape == "PLANE":
            shape = {"plane": {"point": self.point.tolist(), "normal": self.normal.tolist()}}
        elif self.own.collider_shape == "CONTAINER":
            low, high = (corner.tolist() for corner in self.box)
            if self.own.collider_open:
                high[2] = max(high[2], float(self.top) + 1.0)
            shape = {"box": {"min": low, "max": high, "inside": True}}
        else:
            shape = {"mesh": self.files.keys(self.fps) if self.files.moves else {"file": self.files.first()}}
        return {"name": entry_name(self.thing.name, self.number), **shape}

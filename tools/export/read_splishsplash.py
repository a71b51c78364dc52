"""Writes a scene file of SPlisHSPlasH (.json) as a scene of drench, with its mesh and particle files. read_json.py calls it.
The meaning of every key is that of SPlisHSPlasH's own source (Simulator/SimulatorBase.cpp, SPlisHSPlasH/)."""

import difflib
import math
import sys
from collections import Counter
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

from bgeo_particles import read_bgeo
from json_lines import Array, Object, read_json
from refusal import fail
from scene_files import (Missing, Output, add, along_axes, bounds, find_file, is_number, minus, read_obj, rotation, times,
                         turned, volume_of)

VIEW = "only for SPlisHSPlasH's window and export"
SOLVER = "a setting of SPlisHSPlasH's solvers and boundaries"
UNKNOWN = "SPlisHSPlasH does not know it either"
CONFIGURATION = {
    **dict.fromkeys(["pause", "cameraPosition", "cameraLookat", "numberOfStepsPerRenderUpdate", "renderWalls", "colorMapType",
                     "enablePartioExport", "enableVTKExport", "enableRigidBodyExport", "enableRigidBodyVTKExport", "dataExportFPS",
                     "particleAttributes", "enableStateExport", "stateExportFPS", "enableObjectSplitting"], VIEW),
    **dict.fromkeys(["enableZSort", "boundaryHandlingMethod", "gradKernel", "cflMinTimeStepSize", "WCSPH", "PCISPH", "PBF", "IISPH",
                     "ICSPH", "Projective Fluids", "enableDivergenceSolver"], SOLVER),
    "scriptFile": "drench runs no scripts of SPlisHSPlasH"}
USED_CONFIGURATION = {"particleRadius", "gravitation", "cflMethod", "cflFactor", "cflMaxTimeStepSize", "timeStepSize",
                      "simulationMethod", "kernel", "DFSPH", "stopAt", "pauseAt", "sim2D"}
BLOCKS = {"Configuration", "Materials", "RigidBodies", "HingeJoints", "FluidBlocks", "FluidModels", "Emitters"}
OTHER_BLOCKS = {"AnimationFields": "drench has no fields of formulas", "Simulation": "settings of PositionBasedDynamics",
                "TargetVelocityMotorHingeJoints": "a hinge with a motor; add joints with hinge.motor to the scene",
                "TargetAngleMotorHingeJoints": "drench's motors hold a speed; add joints with hinge.motor to the scene"}
JOINTS = ("Joints", "Springs", "Models", "Scenes")  # endings of blocks of PositionBasedDynamics
BODY = {**dict.fromkeys(["color", "isWall", "id", "tag", "boundingBoxMin", "boundingBoxMax"], ""),
        **dict.fromkeys(["mapThickness", "mapResolution", "mapFile", "samplingMode", "particleFile", "invertSDF", "testMesh",
                         "collisionObjectType", "collisionObjectScale", "thicknessSDF", "resolutionSDF", "collisionObjectFileName"],
                        "")}
USED_BODY = {"geometryFile", "translation", "rotationAxis", "rotationAngle", "scale", "isDynamic", "mapInvert", "density",
             "velocity", "isAnimated", "friction", "restitution"}
MATERIAL = {**dict.fromkeys(["colorField", "colorMapType", "renderMinValue", "renderMaxValue", "visible"], VIEW)}
PHYSICAL_VISCOSITY = {1: "Standard viscosity", 5: "Takahashi et al. 2015 (improved)", 6: "Weiler et al. 2018"}  # kinematic, in m²/s
UNPHYSICAL_VISCOSITY = {2: "Bender and Koschier 2017", 3: "Peer et al. 2015", 4: "Peer et al. 2016"}
FORCES = {"surfaceTensionMethod": "its coefficient is not in N/m; set fluid.surface_tension, for water 0.072",
          "vorticityMethod": "see the section fluid.micropolar of drench", "dragMethod": "see wind.liquid_drag of drench",
          "elasticityMethod": "drench has no elastic solids", "xsph": SOLVER}
BLOCK_KEYS = {"id", "denseMode", "start", "end", "translation", "scale", "initialVelocity", "initialAngularVelocity", "visMesh"}
MODEL_KEYS = {"id", "particleFile", "translation", "rotationAxis", "rotationAngle", "scale", "initialVelocity",
              "initialAngularVelocity", "visMesh", "denseMode", "invert", "resolutionSDF"}
EMITTER_KEYS = {"id", "width", "height", "translation", "rotationAxis", "rotationAngle", "velocity", "type", "emitStartTime",
                "emitEndTime", "comment", "tag", "boundingBoxMin", "boundingBoxMax"}
HINGED = ("bodyID1", "bodyID2")
END = 5.0  # s, where the scene does not say


class Section:
    """An object of the file, with messages that name it."""

    def __init__(self, file, data, name):
        if not isinstance(data, Object):
            fail(f"{file}: {name} is not an object in braces; correct it")
        self.file, self.data, self.name = file, data, name

    def line(self, key=None):
        return self.data.lines.get(key, self.data.line)

    def where(self, key=None):
        return f"{self.file}:{self.line(key)}"

    def get(self, key, default, good, what):
        value = self.data.get(key, default)
        if not good(value):
            fail(f"{self.where(key)}: {self.name}.{key}: is not {what}; correct it")
        return value

    def number(self, key, default):
        return float(self.get(key, default, is_number, "a number"))

    def whole(self, key, default):
        return int(self.number(key, default))  # SPlisHSPlasH cuts fractions off too

    def switch(self, key, default=False):
        return bool(self.get(key, default, lambda v: isinstance(v, bool) or v in (0, 1), "true or false"))

    def text(self, key, default=""):
        return self.get(key, default, lambda v: isinstance(v, str), "a text")

    def vector(self, key, default):
        good = self.get(key, Array(0) + list(default), lambda v: isinstance(v, list) and len(v) == 3 and all(map(is_number, v)),
                        "a list of three numbers")
        return tuple(map(float, good))

    def matrix(self):
        return rotation(self.vector("rotationAxis", (1, 0, 0)), self.number("rotationAngle", 0.0))


class Importer:
    def __init__(self, source, folder):
        self.source, self.missing = source, Missing()
        self.root = Section(source, read_json(source), "the file")
        self.check_blocks()
        self.settings = Section(source, self.root.data.get("Configuration", Object(1)), "Configuration")
        if self.settings.switch("sim2D"):
            fail(f"{self.settings.where('sim2D')}: Configuration.sim2D: drench simulates in three dimensions only; "
                 "set it to false and give the scene a depth")
        self.diameter = 2 * self.settings.number("particleRadius", 0.025)
        if self.diameter <= 0:
            fail(f"{self.settings.where('particleRadius')}: Configuration.particleRadius: is not above 0; correct it")
        self.materials = {m.text("id", "Fluid"): m for m in self.sections("Materials")}
        self.extent = []
        self.output = Output(source, folder)

    def check_blocks(self):
        for key in self.root.data:
            if key in BLOCKS:
                continue
            if key in OTHER_BLOCKS or key.endswith(JOINTS):
                other = "of joints, drench has hinges only" if key.endswith("Joints") else "a block of PositionBasedDynamics"
                self.missing.add(OTHER_BLOCKS.get(key, other), key, self.root.line(key))
                continue
            near = difflib.get_close_matches(key, [*BLOCKS, *OTHER_BLOCKS], 1)
            remedy = f"did you mean {near[0]}?" if near else "remove it"
            fail(f"{self.root.where(key)}: unknown block {key}; {remedy}")

    def sections(self, key):
        values = self.root.data.get(key, [])
        if not isinstance(values, list):
            fail(f"{self.root.where(key)}: {key}: is not a list in brackets; correct it")
        return [Section(self.source, value, f"{key}[{k}]") for k, value in enumerate(values)]

    def list_keys(self, section, used, listed):
        for key in section.data:
            if key not in used and listed.get(key, UNKNOWN):
                self.missing.add(listed.get(key, UNKNOWN), key, section.line(key))

    def run(self):
        bodies = [body for section in self.sections("RigidBodies") for body in self.body(section)]
        joints = [joint for section in self.sections("HingeJoints") for joint in self.hinge(section, bodies)]
        sources = [s for section in self.sections("FluidBlocks") for s in self.block(section)]
        sources += [s for section in self.sections("FluidModels") for s in self.model(section)]
        sources += [s for section in self.sections("Emitters") for s in self.emitter(section)]
        if not sources:
            fail(f"{self.source}: holds no liquid that drench can simulate; add FluidBlocks, FluidModels or Emitters of a liquid")
        scene = {"drench": 1, "time": self.time(), "gravity": list(self.settings.vector("gravitation", (0, -9.81, 0))),
                 "domain": self.domain(bodies), "fluid": {"spacing": self.diameter, **self.fluid(), "sources": sources}}
        if bodies:
            scene["bodies"] = bodies
        if joints:
            scene["joints"] = joints
        self.list_keys(self.settings, USED_CONFIGURATION, CONFIGURATION)
        self.output.scene("SPlisHSPlasH", scene, self.missing)

    # Settings.

    def time(self):
        s = self.settings
        end = next((s.number(key, -1.0) for key in ("stopAt", "pauseAt") if s.number(key, -1.0) > 0), None)
        if end is None:
            self.missing.add(f"the scene runs until its window is closed; drench ends it at {END:g} s", "no stopAt")
        step = s.number("timeStepSize", 0.001)
        out = {"step": step, "end": end or END}
        if s.whole("cflMethod", 1) > 0:
            out = {"mode": "cfl", "step": s.number("cflMaxTimeStepSize", 0.005), "end": end or END,
                   "cfl": min(max(0.4 * s.number("cflFactor", 0.5), 0.001), 1.0)}
        if out["step"] <= 0:
            fail(f"{s.where('timeStepSize')}: Configuration: the time step is not above 0; correct it")
        return out

    def fluid(self):
        materials = list(self.materials.values())
        out = {"density": 1000.0}
        if not materials:
            self.missing.add("drench's default, water", "no Materials")
            return out
        if len(materials) > 1:
            for m in materials[1:]:
                self.missing.add("drench has one liquid; the first material is used for all", f"material {m.text('id', 'Fluid')}",
                                 m.line())
        m = materials[0]
        out["density"] = m.number("density0", 1000.0)
        method = m.whole("viscosityMethod", 0)
        if method in PHYSICAL_VISCOSITY:
            name = PHYSICAL_VISCOSITY[method]
            group = Section(self.source, m.data.get(name, Object(m.line())), name)
            out["viscosity"] = min(group.number("viscosity", m.number("viscosity", 0.01)), 100.0)
            self.list_keys(group, {"viscosity"}, dict.fromkeys(group.data, SOLVER))
        elif method:
            self.missing.add("its viscosity is a number without a unit; set fluid.viscosity", UNPHYSICAL_VISCOSITY.get(
                method, f"viscosityMethod {method}"), m.line("viscosityMethod"))
        else:
            out["viscosity"] = 0.0
        out.update(self.solver())
        used = {"id", "density0", "viscosityMethod", "viscosity", "maxEmitterParticles", "emitterReuseParticles", "emitterBoxMin",
                "emitterBoxMax", *FORCES}
        for material in materials:
            methods = {key for key, value in material.data.items() if isinstance(value, dict)}  # of those in use: by `FORCES`
            self.list_keys(material, used | methods, MATERIAL)
            for key, reason in FORCES.items():
                if material.data.get(key):
                    self.missing.add(reason, key, material.line(key))
        return out

    def solver(self):
        s, out = self.settings, {}
        method = s.whole("simulationMethod", 4)
        if method != 4:
            self.missing.add("drench always uses DFSPH", f"simulationMethod {method}", s.line("simulationMethod"))
        if s.whole("kernel", 4) not in (0, 4):
            self.missing.add("drench uses the cubic spline unless fluid.kernel says otherwise", "kernel", s.line("kernel"))
        if method == 4 and "DFSPH" in s.data:
            d = Section(self.source, s.data["DFSPH"], "DFSPH")
            out = {"density_error": clamp(d.number("maxError", 0.01) / 100, 1e-15, 0.5),
                   "divergence_error": clamp(d.number("maxErrorV", 0.1) / 100, 1e-15, 0.5),
                   "max_iterations": int(clamp(max(d.whole("maxIterations", 100), d.whole("maxIterationsV", 100)), 1, 100000)),
                   "min_iterations": int(clamp(d.whole("minIterations", 2), 0, 100))}
            out["min_iterations"] = min(out["min_iterations"], out["max_iterations"])
            if not d.switch("enableDivergenceSolver", True):
                self.missing.add("drench always solves for divergence", "enableDivergenceSolver", d.line("enableDivergenceSolver"))
            return {"solver": out}
        return {}

    # Liquid.

    def is_liquid(self, section, what):
        material = self.materials.get(section.text("id", "Fluid"))
        if material is not None and material.data.get("elasticityMethod"):
            self.missing.add("an elastic solid, which drench does not have", what, section.line())
            return False
        return True

    def moving(self, section):
        if any(section.vector("initialAngularVelocity", (0, 0, 0))):
            self.missing.add("liquid does not start to rotate as a whole", "initialAngularVelocity", section.line("initialAngularVelocity"))
        velocity = section.vector("initialVelocity", (0, 0, 0))
        return {"velocity": list(velocity)} if any(velocity) else {}

    def block(self, section):
        self.list_keys(section, BLOCK_KEYS, {})
        if not self.is_liquid(section, "FluidBlock"):
            return []
        scale, shift = section.vector("scale", (1, 1, 1)), section.vector("translation", (0, 0, 0))
        low, high = (add(tuple(s * x for s, x in zip(scale, section.vector(key, corner))), shift)
                     for key, corner in (("start", (0, 0, 0)), ("end", (1, 1, 1))))
        d = self.diameter
        if section.whole("denseMode", 0):
            self.missing.add("drench fills every block with a cubic lattice", "denseMode", section.line("denseMode"))
        counts = [int(math.floor(x / d + 0.5)) - 1 for x in minus(high, low)]
        if min(counts) <= 1:
            fail(f"{section.where()}: {section.name}: is empty, as in SPlisHSPlasH; a block needs four particles along each side, "
                 f"{4 * d:g} m: enlarge it or remove it")
        start = add(low, (d / 2,) * 3)
        end = add(start, times(counts, d))
        self.extent += [start, end]
        return [{"block": {"min": list(start), "max": list(end), **self.moving(section)}}]

    def model(self, section):
        self.list_keys(section, MODEL_KEYS, {})
        if not self.is_liquid(section, "FluidModel"):
            return []
        name = section.text("particleFile")
        ending = Path(name).suffix.lower()
        if ending not in (".bgeo", ".gz", ".obj"):
            fail(f"{section.where('particleFile')}: {section.name}.particleFile: {name}: files '{ending}' cannot be read; "
                 "allowed: .bgeo, .obj; convert it")
        path = find_file(name, self.source, section.where("particleFile"))
        scale, matrix, shift = section.vector("scale", (1, 1, 1)), section.matrix(), section.vector("translation", (0, 0, 0))
        if ending == ".obj":
            points, triangles = read_obj(path, section.where("particleFile"))
            points = self.placed(points, scale, matrix, shift)
            if section.switch("invert"):
                self.missing.add("the liquid outside of a mesh", "invert", section.line("invert"))
            self.extent += bounds(points)
            return [{"mesh": {"file": self.output.mesh(self.file_name(path), points, triangles), **self.moving(section)}}]
        points, velocities = read_bgeo(path, section.where("particleFile"))
        if not points:
            fail(f"{section.where('particleFile')}: {path}: holds no particles; remove this model")
        points = self.placed(points, (scale[0],) * 3, matrix, shift)
        self.extent += bounds(points)
        start = section.vector("initialVelocity", (0, 0, 0))
        self.moving(section)
        velocities = [add(v, start) for v in velocities] if velocities else [start] * len(points)
        masses = [self.material_density() * self.diameter ** 3] * len(points)
        return [{"particles": {"file": self.output.particles(self.file_name(path), points, velocities, masses)}}]

    def material_density(self):
        first = next(iter(self.materials.values()), None)
        return first.number("density0", 1000.0) if first else 1000.0

    def placed(self, points, scale, matrix, shift):
        return [add(turned(matrix, tuple(s * x for s, x in zip(scale, p))), shift) for p in points]

    def file_name(self, path):
        stem = "".join(c if c.isalnum() else "_" for c in path.name.split(".")[0])
        return f"{stem}_{self.output.meshes}"

    def emitter(self, section):
        self.list_keys(section, EMITTER_KEYS, {})
        if not self.is_liquid(section, "Emitter"):
            return []
        width, height, kind = (section.whole(key, default) for key, default in (("width", 5), ("height", 5), ("type", 0)))
        d, speed = self.diameter, section.number("velocity", 1.0)
        if kind not in (0, 1):
            fail(f"{section.where('type')}: {section.name}.type: {kind} is unknown; allowed: 0 (box), 1 (circle)")
        if speed <= 0 or width < 1 or height < 1:
            fail(f"{section.where()}: {section.name}: needs a width, a height and a velocity above 0; correct it")
        matrix = rotation(section.vector("rotationAxis", (0, 0, 1)), section.number("rotationAngle", 0.0))
        if kind == 0:
            radius, layer = 0.5 * d * math.hypot(width, height), width * height
            mouth = {"size": [width * d, height * d], "up": list(turned(matrix, (0.0, 1.0, 0.0)))}
        else:
            radius = 0.5 * width * d
            mouth = {"radius": max(radius, 0.5 * d)}
            layer = sum(math.hypot(i - (width - 1) / 2, j - (width - 1) / 2) * d <= radius for i in range(width) for j in range(width))
        direction = turned(matrix, (1.0, 0.0, 0.0))
        start, end = max(section.number("emitStartTime", 0.0), 0.0), section.number("emitEndTime", 1e6)
        material = self.materials.get(section.text("id", "Fluid"))
        if material is not None and material.switch("emitterReuseParticles"):
            self.missing.add("the emitter does not take particles back; liquid that leaves the domain is removed",
                             "emitterReuseParticles", material.line("emitterReuseParticles"))
        else:  # the emitters of a material share its particles; 10000 is SPlisHSPlasH's default
            sharing = sum(e.text("id", "Fluid") == section.text("id", "Fluid") for e in self.sections("Emitters"))
            most = (material.whole("maxEmitterParticles", 10000) if material is not None else 10000) / sharing
            end = min(end, start + most / layer * d / speed)
        if end <= start:
            fail(f"{section.where('emitEndTime')}: {section.name}: ends before it starts; correct emitStartTime or emitEndTime")
        center = section.vector("translation", (0, 0, 0))
        reach = times((radius,) * 3, 1.0)
        self.extent += [minus(center, reach), add(center, reach)]
        return [{"jet": {"center": list(center), **mouth, "velocity": list(times(direction, speed)), "start": start, "end": end}}]

    # Solids.

    def body(self, section):
        self.list_keys(section, USED_BODY, BODY)
        name = section.text("geometryFile")
        if not name:
            key = "particleFile" if section.text("particleFile") else None
            self.missing.add("a body needs a mesh in geometryFile", f"{section.name}{f'.{key}' if key else ''}", section.line(key))
            return []
        if not name.lower().endswith(".obj"):
            fail(f"{section.where('geometryFile')}: {section.name}.geometryFile: {name}: files '{Path(name).suffix}' cannot be read; "
                 "allowed: .obj; convert it")
        path = find_file(name, self.source, section.where("geometryFile"))
        points, triangles = read_obj(path, section.where("geometryFile"))
        scale, matrix, shift = section.vector("scale", (1, 1, 1)), section.matrix(), section.vector("translation", (0, 0, 0))
        points = self.placed(points, scale, matrix, shift)
        inside = section.switch("mapInvert")
        self.extent += bounds(points)
        if section.switch("isAnimated"):
            self.missing.add("its motion is in a script; it stands still", "isAnimated", section.line("isAnimated"))
        shape = self.as_shape(section, path, points, triangles, matrix, scale, inside)
        hinged = {joint.data.get(key) for joint in self.sections("HingeJoints") for key in HINGED}
        return [{"name": f"body_{section.data['id']}", **shape} if section.data.get("id") in hinged else shape]

    def hinge(self, section, bodies):
        """A hinge, whose first body floats in drench."""
        self.list_keys(section, {*HINGED, "position", "axis"}, {})
        floats = {body["name"]: any(isinstance(shape, dict) and shape.get("dynamic") for shape in body.values())
                  for body in bodies if "name" in body}
        names = sorted((f"body_{section.data.get(key)}" for key in HINGED), key=lambda name: not floats.get(name))
        if not floats.get(names[0]) or names[1] not in floats:
            self.missing.add("a hinge needs a floating body and another one", section.name, section.line())
            return []
        return [{"hinge": {"body": names[0], "to": names[1], "point": list(section.vector("position", (0, 0, 0))),
                           "axis": list(section.vector("axis", (1, 0, 0)))}}]

    def as_shape(self, section, path, points, triangles, matrix, scale, inside):
        low, high = bounds(points)
        size = max(minus(high, low))
        moves, touch = self.dynamic(section), self.touch(section)
        if along_axes(matrix) and is_box(points, low, high, 1e-5 * size):
            return {"box": {"min": list(low), "max": list(high), **({"inside": True} if inside else moves), **touch}}
        center, radius = round_of(points, triangles)
        if radius and not inside:
            return {"sphere": {"center": list(center), "radius": radius, **moves, **touch}}
        if moves and (inside or not is_closed(triangles)):
            self.missing.add("only bodies of closed meshes float in drench; it stands still", "isDynamic", section.line("isDynamic"))
            moves = {}
        file = self.output.mesh(self.file_name(path), points, triangles)
        return {"mesh": {"file": file, **({"inside": True} if inside else {}), **moves, **touch}}

    def touch(self, section):
        """Friction and restitution, where a body floats."""
        if not any(body.switch("isDynamic") for body in self.sections("RigidBodies")):
            return {}
        return {key: clamp(section.number(key, 0.0), 0.0, most) for key, most in (("friction", 10.0), ("restitution", 1.0))
                if key in section.data}

    def dynamic(self, section):
        if not section.switch("isDynamic"):
            return {}
        out = {"dynamic": True, "density": section.number("density", 1000.0)}
        velocity = section.vector("velocity", (0, 0, 0))
        return {**out, "velocity": list(velocity)} if any(velocity) else out

    def domain(self, bodies):
        boxes = [body["box"] for body in bodies if body.get("box", {}).get("inside")]
        low, high = bounds(self.extent)
        contained = any(body.get("box", body.get("mesh", {})).get("inside") for body in bodies)
        margin = 4 * self.diameter if boxes or contained else max(2 * max(minus(high, low)), 10 * self.diameter)
        if not (boxes or contained):
            self.missing.add("SPlisHSPlasH's space has no end; the domain is five times the size of everything in it", "no container")
        return {"min": list(minus(low, (margin,) * 3)), "max": list(add(high, (margin,) * 3))}


def clamp(x, low, high):
    return min(max(x, low), high)


def is_box(points, low, high, near):
    """Do the points lie on the edges' ends and nowhere else, all eight of them?"""
    corners = {tuple(0 if abs(x - a) <= near else 1 if abs(x - b) <= near else 2 for x, a, b in zip(p, low, high)) for p in points}
    return len(corners) == 8 and not any(2 in corner for corner in corners)


def round_of(points, triangles):
    """Centre and radius of a sphere, or a radius of 0."""
    low, high = bounds(points)
    center = times(add(low, high), 0.5)
    distances = [math.dist(p, center) for p in points]
    radius = max(distances)
    full = abs(volume_of([minus(p, center) for p in points], triangles)) > 0.9 * 4 / 3 * math.pi * radius ** 3
    return center, radius if full and min(distances) > (1 - 1e-3) * radius else 0.0


def is_closed(triangles):
    edges = Counter(tuple(sorted(edge)) for a, b, c in triangles for edge in ((a, b), (b, c), (c, a)))
    return all(count == 2 for count in edges.values())


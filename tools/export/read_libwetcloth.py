"""Writes a scene file of libWetCloth (.xml) as a scene of drench, with its mesh files. `drench import FILE` starts it. The meaning of
every key is that of libWetCloth's own source (App/TwoDSceneXMLParser.cpp, Core/)."""

import difflib
import math
import sys
from pathlib import Path
from xml.parsers import expat

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

from distance_shapes import (Capsule, Cylinder, Intersection, Inverse, RoundedBox, Sphere, Union, scaled_to_volume, surface)
from refusal import fail
from scene_files import (Missing, Output, add, along_axes, bounds, cross, dot, find_file, length, minus, read_obj, rotation, times,
                         turned, run_reader)

CM, GRAM_PER_CM3, DYN_PER_CM, BARYE = 0.01, 1000.0, 1e-3, 0.1  # in SI
SPACING = 0.38 / 0.3535533906  # of the cell times particleCellMultiplier: the mean distance of libWetCloth's liquid particles
THIN = 0.1  # cm²/s: kinematic viscosity up to which liquid flows like water
IMPERMEABLE = 0.95  # restVolumeFraction from which a cloth is a wall

# Elements of a scene and of its parts; what libWetCloth reads and drench does not express, by reason.
VIEW = "only for libWetCloth's window"
GRID = "a setting of libWetCloth's grid and solvers"
SOLID = "drench has no counterpart; its contact of cloth needs none"
DEAD = "libWetCloth does not read it either"
YARN = "drench has no yarn"
SCENE_KEYS = {**dict.fromkeys(["camera", "viewport", "backgroundcolor", "maxsimfreq", "scenetag"], VIEW),
              "hair": YARN, "pose": YARN, "springforce": YARN}
USED_SCENE_KEYS = {"duration", "integrator", "bucketinfo", "liquidinfo", "simplegravity", "ElasticParameters", "particle", "cloth",
                   "distancefield", "script", "description"}
LIQUID_KEYS = {**dict.fromkeys(
    ["flipCoeff", "elastoFlipCoeff", "elastoFlipAsymCoeff", "elastoAdvectCoeff", "correctionStep", "correctionStrength",
     "correctionMultiplier", "surfTensionSmoothingStep", "iterationPrintStep", "checkDivergence", "implicitViscosity", "useBiCGSTAB",
     "useAMGPCGSolid", "usePCR", "useGroupPrecondition", "useLagrangianMPM", "useCosolveAngular", "propagateSolidVelocity",
     "levelsetThickness", "levelsetYoungModulus", "useLevelSetForce", "useTwist", "useVaryingFraction", "initNonuniformFraction"], GRID),
    **dict.fromkeys(["cohesion", "softCohesion", "solidCohesion", "cohesionCoeff"],
                    "libWetCloth's cohesion of wet yarn and cloth; the nearest key is cloth.N.porous.adhesion"),
    **dict.fromkeys(["dragByFutureSolid", "useDrag", "useNonlinearDrag", "yazdchiPower", "applyPressureManifold",
                     "applyPorePressureSolid", "applyPressureSolid", "elastoCaptureRate", "liquidBoundaryFriction"],
                    "drench couples liquid and cloth by its own model (docs/manual/wetting.md)"),
    **dict.fromkeys(["airViscosity", "airDensity", "dragByAir"], "use the section wind of drench")}
USED_LIQUID_KEYS = {"yarnDiameter", "poreRadius", "restVolumeFraction", "computeViscosity", "viscosity", "liquidDensity", "surfTension",
                    "surfTensionCoeff", "restContactAngle", "particleCellMultiplier", "solveSolid", "bendingScheme"}
ELASTIC_KEYS = {**dict.fromkeys(["collisionMultiplier", "attachMultiplier"], SOLID),
                **dict.fromkeys(["baseRotation", "straightHairs", "haircolor", "stretchingMultiplier"], YARN),
                **dict.fromkeys(["postProjectFixed", "useApproxJacobian", "useTournierJacobian"], GRID)}
USED_ELASTIC_KEYS = {"radius", "biradius", "restVolumeFraction", "youngsModulus", "poissonRatio", "density", "viscosity",
                     "accumulateWithViscous", "accumulateViscousOnlyForBendingModes", "frictionAngle"}
DEAD_KEYS = {"collision", "simtype", "halfThickness", "multiLevel", "friction_angle", "fabricThreadCount", "shearModulus",
             "variableRadiusHair"}
PARTS = {"liquidinfo": (USED_LIQUID_KEYS, LIQUID_KEYS), "ElasticParameters": (USED_ELASTIC_KEYS, ELASTIC_KEYS)}
PLACE = {"cx", "cy", "cz", "rx", "ry", "rz", "rw"}
VELOCITY = {"vx", "vy", "vz"}
ATTRIBUTES = {  # of elements that there may be many of: those that are used, those that are not with the reason
    "distancefield": ({"usage", "type", "i", "group", "sampled", "inside", "radius", "ex", "ey", "ez", "corner", "halflength", "filename",
                       "scale", *PLACE, *VELOCITY},
                      {"dx": GRID, "cached": GRID, "cachename": GRID, "params": "solids have the friction of the cloth"}),
    "duration": ({"time", "start", "end", "maxvol", *VELOCITY}, {}),
    "particle": ({"x", "v", "fixed", "group", "state", "fvol", "m", "vol", "radius", "biradius", "vf", "fm"},
                 {"theta": YARN, "omega": YARN}),
    "script": ({"type", "func", "x", "y", "z", "w", "ox", "oy", "oz", "start", "end", "easestart", "easeend", "amplitude", "frequency",
                "group", "global"}, {"base": "only for weno", "dt": "only for weno"}),
    "cloth": ({"params"}, {}), "face": ({"i"}, {})}
CHILDREN = {"camera": {"rotation", "center"}, "distancefield": {"duration"}, "cloth": {"face"}, "hair": {"p"}}


class Element:
    def __init__(self, file, tag, attributes, line):
        self.file, self.tag, self.attributes, self.line, self.children = file, tag, attributes, line, []

    @property
    def where(self):
        return f"{self.file}:{self.line}"

    def all(self, tag):
        return [child for child in self.children if child.tag == tag]

    def first(self, tag):
        return next((child for child in self.children if child.tag == tag), None)

    def words(self, name, kind=float):
        try:
            values = [kind(word) for word in self.attributes[name].split()]
            if kind is float and not all(map(math.isfinite, values)):
                raise ValueError
        except ValueError:
            what = "numbers" if kind is float else "whole numbers"
            fail(f"{self.where}: {self.tag}@{name}: '{self.attributes[name]}' is not a list of {what}; correct it")
        return values

    def number(self, name, default=None):
        if name not in self.attributes:
            if default is None:
                fail(f"{self.where}: {self.tag} needs the attribute {name}; add it")
            return default
        values = self.words(name)
        if len(values) != 1:
            fail(f"{self.where}: {self.tag}@{name}: '{self.attributes[name]}' is not a number; correct it")
        return values[0]

    def vector(self, name, default=None):
        if name not in self.attributes and default is not None:
            return default
        if name not in self.attributes or len(self.words(name)) != 3:
            fail(f"{self.where}: {self.tag}@{name}: needs three numbers, such as '0 1.5 0'")
        return tuple(self.words(name))

    def axes(self, names, default=(0.0, 0.0, 0.0)):
        return tuple(self.number(name, d) for name, d in zip(names, default))

    def value(self, tag, default):
        child = self.first(tag)
        return default if child is None else child.number("value")


def read_xml(file):
    """The tree of the file; its only document element is scene."""
    top, open_elements = Element(str(file), "", {}, 0), []
    parser = expat.ParserCreate()

    def start(tag, attributes):
        element = Element(str(file), tag, attributes, parser.CurrentLineNumber)
        (open_elements[-1] if open_elements else top).children.append(element)
        open_elements.append(element)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: open_elements.pop()
    try:
        parser.Parse(file.read_bytes(), True)
    except expat.ExpatError as error:
        fail(f"{file}:{error.lineno}: is not well-formed XML: {expat.errors.messages[error.code]}; correct this line or the one before")
    except OSError as error:
        fail(f"{file}: cannot be read: {error.strerror}")
    scene = top.children[0]
    if scene.tag != "scene":
        fail(f"{file}:{scene.line}: the file contains <{scene.tag}>; a scene of libWetCloth is a <scene>")
    return scene


def check_names(scene, missing):
    """Every element is one that libWetCloth knows, or one of those that its own scenes carry along."""
    def check(element, known, listed, missing=missing):
        for child in element.children:
            if child.tag in DEAD_KEYS:
                missing.add(DEAD, child.tag, child.line)
            elif child.tag in listed:
                missing.add(listed[child.tag], child.tag, child.line)
            elif child.tag not in known:
                near = difflib.get_close_matches(child.tag, [*known, *listed], 1)
                remedy = f"did you mean <{near[0]}>?" if near else "remove it"
                fail(f"{child.where}: unknown element <{child.tag}> in <{element.tag}>; {remedy}")

    def check_attributes(element):
        used, listed = ATTRIBUTES.get(element.tag, (element.attributes, {}))
        for name in element.attributes:
            if name not in used:
                missing.add(listed.get(name, DEAD), f"{element.tag}@{name}", element.line)
        for child in element.children:
            check_attributes(child)

    check_attributes(scene)
    check(scene, USED_SCENE_KEYS, SCENE_KEYS)
    for child in scene.children:
        if child.tag == "ElasticParameters" and not scene.first("cloth"):
            check(child, {*USED_ELASTIC_KEYS, *ELASTIC_KEYS}, {}, Missing())
        elif child.tag in PARTS:
            check(child, *PARTS[child.tag])
        else:
            check(child, CHILDREN.get(child.tag, ()), {})


class Liquid:
    """What the section liquidinfo says, in cgs."""

    def __init__(self, scene, missing):
        node = self.node = scene.first("liquidinfo") or Element(scene.file, "liquidinfo", {}, scene.line)
        given = {key for key in ("yarnDiameter", "poreRadius", "restVolumeFraction") if node.first(key)}
        diameter, radius = node.value("yarnDiameter", 0.01), node.value("poreRadius", 0.005)
        fraction = node.value("restVolumeFraction", 0.4)
        if {"yarnDiameter", "restVolumeFraction"} <= given:
            radius = 0.5 * diameter * math.sqrt(max(0.0, 1 / fraction - 1))
        elif {"yarnDiameter", "poreRadius"} <= given:
            fraction = diameter ** 2 / (diameter ** 2 + 4 * radius ** 2)
        elif {"poreRadius", "restVolumeFraction"} <= given:
            diameter = 2 * radius * math.sqrt(max(0.0, fraction / (1 - fraction)))
        self.yarn_diameter, self.pore_radius, self.fraction = diameter, radius, fraction
        self.viscosity, self.density = node.value("viscosity", 8.9e-3), node.value("liquidDensity", 1.0)
        self.tension = node.value("surfTensionCoeff", 72.8)
        self.angle = node.value("restContactAngle", math.radians(40.8))
        self.in_bulk = node.value("surfTension", 0) != 0
        self.solid_moves = node.value("solveSolid", 1) != 0
        scheme = node.first("bendingScheme")
        self.half_angles = scheme is not None and scheme.attributes.get("value") == "sintheta"
        if not node.value("computeViscosity", 0) and self.viscosity > THIN * self.density:
            missing.add("libWetCloth applies the viscosity only inside cloth there; drench applies it to all of the liquid",
                        "computeViscosity 0 (its default)")

    def permeabilities(self, fraction):
        """cm²: along and across the threads."""
        p, d = fraction, self.yarn_diameter
        along = (-math.log(p) - 1.476 + 2 * p - 0.5 * p * p) / (16 * p) * d * d
        across = (-math.log(p) - 1.476 + 2 * p - 1.774 * p * p + 4.078 * p ** 3) / (32 * p) * d * d
        return max(along, 1e-20), max(across, 1e-20)

    def suction(self, fraction):
        """dyn/cm²: pore pressure of dry cloth, twice libWetCloth's capillary pressure, as in its flow along cloth."""
        if self.pore_radius < 1e-20 or fraction >= 1:
            return 0.0
        return 2 * fraction / (1 - fraction) * self.tension * math.cos(self.angle) / self.pore_radius


def kinematic_viscosity(liquid):
    return min(liquid.viscosity / liquid.density * 1e-4, 100.0)


# Motion.

class Motion:
    """The scripts of a group: the velocity of its translation and the rate of its rotation over time."""

    def __init__(self):
        self.shifts, self.spins = [], []  # (speed over time, its times, are keyframes there exact?, direction or axis[, origin])
        self.world = False  # is the axis one of space, or of the body?

    def __bool__(self):
        return bool(self.shifts or self.spins)


def ease(script, total):
    """libWetCloth's speed over time, its times, and whether smooth keyframes at them are exact."""
    start, end = script.number("start"), script.number("end")
    part = (end - start) / 3
    a, b = start + script.number("easestart", part), end - script.number("easeend", part)
    if script.attributes.get("func", "cubic") == "cosine":
        amplitude, w = script.number("amplitude", 1.0), 2 * math.pi * script.number("frequency", 1.0)
        return lambda t: cosine_speed(t - start, a - start, end - b, end - start, amplitude, w), [start, a, b, end], False
    top = 2 * total / (end - start + b - a)

    def speed(t):
        if t <= start or t >= end:
            return 0.0
        if t < a:
            return top * smooth_step((t - start) / (a - start))
        return top * smooth_step((end - t) / (end - b)) if t > b else top

    return speed, sorted({start, a, b, end}), True


def smooth_step(s):
    return s * s * (3 - 2 * s)


def cosine_speed(t, a, b, whole, amplitude, w):
    """−A w sin(w t) between the eases; in them the cubics that start and end at rest and give the same displacement."""
    if t <= 0 or t >= whole:
        return 0.0
    if t < a:
        c, s = math.cos(a * w), math.sin(a * w)
        return -3 * t * t * amplitude * (2 * c + a * s * w) / a ** 3 + 2 * t * amplitude * (3 * c + a * s * w) / a ** 2
    if t > whole - b:
        left, at = whole - t, whole - b
        c, s = math.cos(at * w), math.sin(at * w)
        return 3 * left * left * amplitude * (2 * c - b * s * w) / b ** 3 - 2 * left * amplitude * (3 * c - b * s * w) / b ** 2
    return -amplitude * w * math.sin(w * t)


def read_scripts(scene, missing):
    groups = {}
    for script in scene.all("script"):
        kind, func = script.attributes.get("type"), script.attributes.get("func", "cubic")
        if kind not in ("translate", "rotate"):
            fail(f"{script.where}: script@type: '{kind}' is unknown; allowed: translate, rotate")
        if func not in ("cubic", "cosine", "weno"):
            fail(f"{script.where}: script@func: '{func}' is unknown; allowed: cubic, cosine, weno")
        if script.number("end") <= max(script.number("start"), 0.0):
            missing.add("it ends before it starts", f"script {kind}", script.line)
            continue
        if func == "weno":
            missing.add("use keyframes of offset", "script@func weno", script.line)
            continue
        motion = groups.setdefault(int(script.number("group", 0)), Motion())
        vector = script.axes("xyz")
        if length(vector) == 0:
            continue
        if kind == "translate":
            direction = times(vector, 1 / length(vector))
            motion.shifts.append((*ease(script, length(vector)), direction))
        else:
            axis = times(vector, 1 / length(vector))
            motion.world = script.number("global", 0) != 0
            origin = script.axes(("ox", "oy", "oz")) if {"ox", "oy", "oz"} & set(script.attributes) else None
            if motion.spins and (cross(motion.spins[0][3], axis) != (0, 0, 0) or motion.spins[0][4] != origin):
                missing.add("a pin or body rotates about one axis only; the first is used", "script rotate", script.line)
                continue
            if motion.spins:
                axis_sign = math.copysign(1.0, dot(axis, motion.spins[0][3]))
                speed, moments, exact = ease(script, script.number("w", 0.0))
                motion.spins.append((lambda t, s=speed, f=axis_sign: f * s(t), moments, exact, motion.spins[0][3], origin))
            else:
                motion.spins.append((*ease(script, script.number("w", 0.0)), axis, origin))
    return groups


def keyframes(parts, value):
    """Keyframes of the sum of `parts`, (speed, times, exact, …): smooth ones at the times where they follow one another and are exact
    there, else a fine set. `value` makes a key's value of the speeds."""
    spans = sorted((part[1][0], part[1][-1]) for part in parts)
    apart = all(before[1] <= after[0] + 1e-12 for before, after in zip(spans, spans[1:]))
    moments = sorted({t for part in parts for t in part[1]})
    if not (apart and all(part[2] for part in parts) and moments[0] >= 0):
        moments = sorted({max(t, 0.0) for t in moments})
        moments = sorted({a + (b - a) * k / 32 for a, b in zip(moments, moments[1:]) for k in range(33)})
    kept = moments[:1]
    for t in moments:
        if t - kept[-1] > 1e-9:
            kept.append(t)
    return {"keys": [[t, value([part[0](t) for part in parts])] for t in kept], "interpolation": "smooth"}


def velocity_keys(motion):
    directions = [shift[3] for shift in motion.shifts]
    return keyframes(motion.shifts, lambda speeds: [CM * sum(s * d[axis] for s, d in zip(speeds, directions)) for axis in range(3)])


def spin_keys(motion, center=None, axis=None):
    spin = {"axis": list(axis or motion.spins[0][3]),
            "degrees_per_second": keyframes(motion.spins, lambda speeds: math.degrees(sum(speeds)))}
    return spin if center is None else {**spin, "center": [CM * x for x in center]}


def angle_at(motion, t):
    """rad: integral of the rate, by Simpson's rule."""
    n = 200
    h = t / n
    rate = [sum(part[0](k * h) for part in motion.spins) for k in range(n + 1)] if t > 0 else [0.0, 0.0]
    return h / 3 * (rate[0] + rate[-1] + 4 * sum(rate[1:-1:2]) + 2 * sum(rate[2:-1:2])) if t > 0 else 0.0


def body_motion(motion, center, spun_about, matrix, missing, name, line):
    """Keys of a body whose bounding box has its middle at `center` and that libWetCloth rotates about another point."""
    keys = {}
    if motion.shifts:
        keys["velocity"] = velocity_keys(motion)
    if motion.spins:
        origin, axis = motion.spins[0][4], motion.spins[0][3]
        axis = axis if motion.world else turned(matrix, axis)
        keys["spin"] = spin_keys(motion, axis=axis)
        pivot = spun_about if origin is None else origin
        if math.dist(pivot, center) > 1e-9:
            if origin is not None and motion.shifts:
                missing.add("translation together with rotation about an origin; the origin stays", name, line)
            first, last = min(part[1][0] for part in motion.spins), max(part[1][-1] for part in motion.spins)
            arm, keys["offset"] = minus(center, pivot), {"keys": [], "interpolation": "smooth"}
            for k in range(65):
                t = first + (last - first) * k / 64
                moved = minus(turned(rotation(axis, angle_at(motion, t)), arm), arm)
                keys["offset"]["keys"].append([t, [CM * x for x in moved]])
    return keys


# Distance fields.

class Field:
    def __init__(self, element, shape, inside, parts=()):
        self.element, self.shape, self.inside, self.parts, self.used_by = element, shape, inside, parts, None
        self.usage = element.attributes.get("usage", "solid")
        self.group = int(element.number("group", 0))
        self.sampled = element.number("sampled", 1) != 0
        self.pivot = None
        self.matrix = rotation(element.axes(("rx", "ry", "rz"), (0.0, 1.0, 0.0)), element.number("rw", 0.0))
        if self.usage not in ("solid", "source", "terminator"):
            fail(f"{element.where}: distancefield@usage: '{self.usage}' is unknown; allowed: solid, source, terminator")

    @property
    def name(self):
        return f"distancefield {self.element.attributes.get('type')}"

    def leaves(self):
        return [leaf for part in self.parts for leaf in part.leaves()] if self.parts else [self]


def vote(values):
    """libWetCloth's majority vote (Boyer and Moore) of the parts of a field."""
    winner, count = None, 0
    for value in values:
        if count == 0:
            winner, count = value, 1
        else:
            count += 1 if value == winner else -1
    return winner


class MeshShape:
    """A file of a distance field, placed: no distances, only its mesh."""

    def __init__(self, points, triangles):
        self.points, self.triangles = points, triangles

    def box(self):
        return bounds(self.points)


def read_field(e, source):
    center, matrix = e.axes(("cx", "cy", "cz")), rotation(e.axes(("rx", "ry", "rz"), (0.0, 1.0, 0.0)), e.number("rw", 0.0))
    kind = e.attributes.get("type")
    if kind == "sphere":
        return Sphere(center, positive(e, "radius")), center
    if kind == "box":
        half, radius = e.axes(("ex", "ey", "ez")), e.number("radius", 0.0)
        if min(half) + radius <= 0:
            fail(f"{e.where}: distancefield box has no extent; set ex, ey and ez above 0")
        return RoundedBox(center, matrix, half, radius), center
    if kind == "capsule":
        return Capsule(center, matrix, positive(e, "radius"), positive(e, "halflength")), center
    if kind == "cylinder":
        radius, corner = positive(e, "radius"), e.number("corner", 0.0)
        return Cylinder(center, matrix, radius, min(corner, radius), positive(e, "halflength")), center
    if kind == "file":
        if not e.attributes.get("filename"):
            fail(f"{e.where}: distancefield file needs the attribute filename; add it")
        points, triangles = read_obj(find_file(e.attributes["filename"], source, e.where), e.where)
        points = [times(p, e.number("scale", 1.0)) for p in points]
        mean = times(tuple(map(sum, zip(*points))), 1 / len(points))
        pivot = add(center, mean)
        return MeshShape([add(pivot, turned(matrix, minus(p, mean))) for p in points], triangles), pivot
    fail(f"{e.where}: distancefield@type: '{kind}' is unknown; allowed: sphere, box, capsule, cylinder, file, union, intersect")


def positive(e, name):
    value = e.number(name)
    if value <= 0:
        fail(f"{e.where}: {e.tag}@{name}: {value:g} is not above 0; correct it")
    return value


def read_fields(scene, source):
    fields = []
    for e in scene.all("distancefield"):
        kind = e.attributes.get("type")
        if kind in ("union", "intersect"):
            if "i" not in e.attributes:
                fail(f"{e.where}: distancefield {kind} needs the attribute i, numbers of earlier fields; add it")
            numbers = e.words("i", int)
            if any(i < 0 or i >= len(fields) for i in numbers):
                fail(f"{e.where}: distancefield@i: '{e.attributes['i']}' names a field that does not come before it; correct it")
            parts = [fields[i] for i in numbers]
            if any(isinstance(part.shape, MeshShape) for part in parts):
                fail(f"{e.where}: distancefield {kind} of a file cannot be imported; combine the meshes in a modeller and name the result")
            shapes = [Inverse(part.shape) if part.inside else part.shape for part in parts]
            field = Field(e, (Union if kind == "union" else Intersection)(shapes), False, parts)
            for part in parts:
                part.used_by = field
            field.usage = vote([part.usage for part in parts])
            field.sampled = vote([part.sampled for part in parts])
        else:
            shape, pivot = read_field(e, source)
            field = Field(e, shape, e.number("inside", 0) != 0)
            field.pivot = pivot
        fields.append(field)
    top = [field for field in fields if field.used_by is None]
    for group in {field.group for field in top}:  # the members of a group have one usage
        members = [field for field in top if field.group == group]
        usage, sampled = vote([m.usage for m in members]), vote([m.sampled for m in members])
        for m in members:
            m.usage, m.sampled = usage, sampled
    return top


def plain_box(shape):
    """Corners of a box with sharp edges along the axes, or of an intersection of such; else None."""
    if isinstance(shape, RoundedBox) and shape.radius == 0 and along_axes(shape.matrix):
        return shape.box()
    if isinstance(shape, Intersection):
        boxes = [plain_box(part) for part in shape.parts]
        if all(boxes):
            return Intersection(shape.parts).box()
    return None


def overlap(one, other):
    return all(a < d and c < b for a, b, c, d in zip(*one, *other))


def in_metres(points):
    return [times(p, CM) for p in points]


def box_of(corners):
    return {"min": [CM * x for x in corners[0]], "max": [CM * x for x in corners[1]]}


def generated(field, cell):
    if isinstance(field.shape, MeshShape):
        return field.shape.points, field.shape.triangles
    low, high = field.shape.box()
    if not all(a < b for a, b in zip(low, high)) or not all(map(math.isfinite, low + high)):
        fail(f"{field.element.where}: {field.name} has no volume; correct or remove it")
    points, triangles = surface(field.shape, cell)
    if not triangles:
        fail(f"{field.element.where}: {field.name} is smaller than a particle; enlarge it, or set bucketinfo@size smaller")
    return (scaled_to_volume(points, triangles, field.shape.volume()) if hasattr(field.shape, "volume") else points), triangles


class Importer:
    def __init__(self, source, folder):
        self.source, self.missing = source, Missing()
        self.scene = read_xml(source)
        check_names(self.scene, self.missing)
        self.liquid = Liquid(self.scene, self.missing)
        bucket = self.scene.first("bucketinfo") or Element(self.scene.file, "bucketinfo", {}, 0)
        cell = bucket.number("size", 5.0) / bucket.number("numcells", 5)
        if cell <= 0:
            fail(f"{bucket.where}: bucketinfo: size / numcells is not above 0; correct it")
        self.spacing = SPACING * self.liquid.node.value("particleCellMultiplier", 0.3535533906) * cell  # cm
        self.fields = read_fields(self.scene, source)
        self.motions = read_scripts(self.scene, self.missing)
        self.particles = self.scene.all("particle")
        self.positions = [p.vector("x") for p in self.particles]
        self.cloths = [c for c in self.scene.all("cloth") if c.number("params") >= 0 and c.all("face")]
        self.extent = []  # points that the domain has to contain, cm
        self.output = Output(source, folder)

    def run(self):
        sources = self.sources()
        cloths = self.all_cloths()
        bodies = self.bodies()
        if not sources and not cloths:
            fail(f"{self.source}: holds neither liquid nor cloth, so nothing of it can be simulated"
                 + ("; drench has no yarn" if self.scene.all("hair") else ""))
        end = self.scene.first("duration")
        integrator = self.scene.first("integrator")
        if end is None or integrator is None:
            fail(f"{self.source}:{self.scene.line}: the scene needs <{'duration' if end is None else 'integrator'}>; add it")
        for element, name in ((integrator, "dt"), (end, "time")):
            if not element.number(name) > 0:
                fail(f"{element.where}: {element.tag}@{name}: {element.number(name):g} is not above 0; correct it")
        gravity = (0.0, 0.0, 0.0)
        for e in self.scene.all("simplegravity"):
            gravity = add(gravity, e.axes(("fx", "fy", "fz")))
        scene = {"drench": 1, "time": {"mode": "cfl", "step": integrator.number("dt"), "end": end.number("time")},
                 "gravity": [CM * x for x in gravity], "domain": self.domain()}
        if sources or any("porous" in cloth for cloth in cloths):
            scene["fluid"] = {"spacing": CM * self.spacing, "density": GRAM_PER_CM3 * self.liquid.density,
                              "viscosity": kinematic_viscosity(self.liquid)}
            if self.liquid.in_bulk:
                scene["fluid"]["surface_tension"] = DYN_PER_CM * self.liquid.tension
            if sources:
                scene["fluid"]["sources"] = sources
        scene.update({key: value for key, value in (("cloth", cloths), ("bodies", bodies)) if value})
        self.integrator_settings(integrator)
        for e in self.scene.all("description"):
            if "text" not in e.attributes:
                fail(f"{e.where}: description needs the attribute text; add it")
        comments = [" ".join(e.attributes["text"].split()) for e in self.scene.all("description")]
        self.output.scene("libWetCloth", scene, self.missing, comments)

    def integrator_settings(self, integrator):
        for element, used in ((integrator, {"type", "dt"}), (self.scene.first("bucketinfo"), {"size", "numcells"})):
            for name in sorted(set(element.attributes) - used) if element is not None else ():
                self.missing.add(GRID, f"{element.tag}@{name}", element.line)

    # Liquid.

    def sources(self):
        out, fills = [], []
        for field in self.fields:
            if field.usage == "source":
                self.source_of(field, fills, out)
        for cluster, velocity in self.clusters(fills):
            out.append(self.filled(cluster, velocity))
        return out + self.liquid_particles()

    def clusters(self, fills):
        """Sources that may overlap are one shape, so that no place is filled twice."""
        out = []
        for field, velocity in fills:
            near = [k for k, (other, _) in enumerate(out) if overlap(field.shape.box(), other.shape.box())]
            if any(isinstance(f.shape, MeshShape) for f in (field, *(out[k][0] for k in near))) and near:
                self.missing.add("it may overlap with another source, which is then filled twice", field.name, field.element.line)
                near = []
            if any(out[k][1] != velocity for k in near):
                self.missing.add("it overlaps with a source of another velocity, which is used for both", field.name,
                                 field.element.line)
            if near:
                field, velocity = Field(field.element, Union([out[k][0].shape for k in near] + [field.shape]), False), out[near[0]][1]
                out = [pair for k, pair in enumerate(out) if k not in near]
            out.append((field, velocity))
        return out

    def source_of(self, field, fills, out):
        e, shape = field.element, field.shape
        if not field.sampled:
            self.missing.add("libWetCloth does not fill it (sampled 0)", field.name, e.line)
            return
        if field.group in self.motions:
            self.missing.add("sources do not move", f"script of source group {field.group}", e.line)
        if field.inside:
            self.missing.add("liquid outside of a shape", f"{field.name}@inside", e.line)
            return
        self.extent += shape.box()
        for start, end, maximum, velocity in self.durations(field):
            if start <= 0:
                fills.append((field, velocity))
            if end > max(start, 0.0):
                out.append(self.emitter(field, max(start, 0.0), end, maximum, velocity))

    def durations(self, field):
        """(start, end, largest volume, velocity) of the leaves, the first that applies at each time."""
        out = []
        for leaf in field.leaves():
            nodes = leaf.element.all("duration") or [leaf.element]
            out += [(d.number("start", 0.0), d.number("end", 0.0), d.number("maxvol", math.inf), d.axes(("vx", "vy", "vz")))
                    for d in nodes]
        first = next(([d] for d in out if d[0] <= 0 <= d[1]), [])
        return first + [d for d in out if d[1] > 0 and d not in first]

    def filled(self, field, velocity):
        moving = {"velocity": [CM * x for x in velocity]} if any(velocity) else {}
        shape = field.shape
        if box := plain_box(shape):
            if not all(a < b for a, b in zip(*box)):
                fail(f"{field.element.where}: {field.name} has no volume; correct or remove it")
            return {"block": {**box_of(box), **moving}}
        if isinstance(shape, Sphere) and shape.radius >= self.spacing:
            return {"sphere": {"center": [CM * x for x in shape.center], "radius": CM * shape.radius, **moving}}
        points, triangles = generated(field, 0.5 * self.spacing)
        file = self.output.mesh(f"source_{field.element.line}", in_metres(points), triangles)
        return {"mesh": {"file": file, **moving}}

    def emitter(self, field, start, end, maximum, velocity):
        e, shape, speed = field.element, field.shape, length(velocity)
        low, high = shape.box()
        center = times(add(low, high), 0.5)
        if isinstance(shape, Sphere):
            radius = shape.radius
        else:
            size = minus(high, low)
            area = sum(abs(velocity[a]) * size[(a + 1) % 3] * size[(a + 2) % 3] for a in range(3)) / speed if speed else 0
            radius = math.sqrt(area / math.pi)
            if speed:
                self.missing.add("emitters are round; a nozzle of the same area is used", f"{field.name}/duration", e.line)
        if not speed:
            fail(f"{e.where}: {field.name}: a source that lasts needs a velocity; add vx, vy or vz to its duration")
        if math.isfinite(maximum):
            end = min(end, start + maximum / (math.pi * radius ** 2 * speed))
        if start < 0 or end <= start:
            fail(f"{e.where}: {field.name}: its duration has no length; correct start and end")
        return {"jet": {"center": [CM * x for x in center], "radius": CM * radius, "velocity": [CM * x for x in velocity],
                        "start": start, "end": end}}

    def liquid_particles(self):
        """Particles that the file gives one by one."""
        liquid = [(p, x) for p, x in zip(self.particles, self.positions) if p.attributes.get("state") == "liquid"]
        liquid = [(p, x, p.number("fvol", 0.0)) for p, x in liquid]
        liquid = [given for given in liquid if given[2] > 0]
        if not liquid:
            return []
        self.extent += [x for _, x, _ in liquid]
        velocities = [times(p.vector("v", (0.0, 0.0, 0.0)), CM) for p, _, _ in liquid]
        masses = [volume * CM ** 3 * GRAM_PER_CM3 * self.liquid.density for _, _, volume in liquid]
        file = self.output.particles("particles", in_metres([x for _, x, _ in liquid]), velocities, masses)
        return [{"particles": {"file": file}}]

    # Cloth.

    def elastic(self, cloth):
        all_parameters, index = self.scene.all("ElasticParameters"), int(cloth.number("params"))
        if index >= len(all_parameters):
            fail(f"{cloth.where}: cloth@params: {index} is not one of the {len(all_parameters)} ElasticParameters; correct it")
        return all_parameters[index]

    def merged_cloths(self):
        """Cloths that share particles and parameters are one."""
        groups, owner = [], {}
        for cloth in self.cloths:
            faces = []
            for face in cloth.all("face"):
                if "i" not in face.attributes:
                    continue
                corners = face.words("i", int)
                if len(corners) != 3 or not all(0 <= c < len(self.particles) for c in corners):
                    fail(f"{face.where}: face@i: '{face.attributes['i']}' does not name three of the {len(self.particles)} particles; "
                         "correct it")
                faces.append(tuple(corners))
            shared = {owner[c] for face in faces for c in face if c in owner}
            same = [g for g in shared if groups[g][0] is self.elastic(cloth)]
            if shared and not same:
                self.missing.add("it shares particles with a cloth of other parameters; they part", "cloth", cloth.line)
            if same:
                groups[same[0]][2].extend(faces)
            else:
                groups.append((self.elastic(cloth), cloth, faces))
            for c in {c for face in faces for c in face}:
                owner.setdefault(c, same[0] if same else len(groups) - 1)
        return groups

    def all_cloths(self):
        groups = self.merged_cloths()
        return [self.cloth(f"cloth_{k}" if len(groups) > 1 else "cloth", *group) for k, group in enumerate(groups)]

    def cloth(self, name, parameters, element, faces):
        used = sorted({c for face in faces for c in face})
        node_of = {particle: node for node, particle in enumerate(used)}
        points, triangles = [self.positions[p] for p in used], [tuple(node_of[c] for c in face) for face in faces]
        self.extent += bounds(points)
        out = {"name": name, "mesh": {"file": self.output.mesh(name, in_metres(points), triangles)}, "weld": "off", "clean": "off"}
        fraction = parameters.value("restVolumeFraction", self.liquid.fraction)
        if not 0 < fraction <= 1:
            fail(f"{parameters.where}: restVolumeFraction: {fraction:g} is not above 0 and at most 1; correct it")
        thickness = parameters.value("radius", 0.018) + parameters.value("biradius", 0.018)  # cm
        young, poisson = parameters.value("youngsModulus", 6.687e5), parameters.value("poissonRatio", 0.35)
        bend = young * thickness ** 3 / (12 * (1 - poisson ** 2)) * (0.25 if self.liquid.half_angles else 1.0)
        out["areal_density"] = parameters.value("density", 1.3) * GRAM_PER_CM3 * fraction * thickness * CM
        out["thickness"] = thickness * CM
        out["stretch"] = fraction ** 2 * young * BARYE * thickness * CM
        out["bend"] = fraction ** 2 * bend * 1e-7
        out["damping"] = 0.0
        if damping := self.strain_damping(parameters, young):
            out["strain_damping"] = damping
        angle = min(max(parameters.value("frictionAngle", 0.0), 0.0), 90.0)
        out["friction"] = min(math.tan(math.radians(angle)), 10.0)
        if not self.liquid.solid_moves:
            out["dynamics"] = False
        else:
            out["self_collision"] = True
        if self.liquid.solid_moves and (pins := self.pins(used)):
            out["pin"] = pins
        if fraction < IMPERMEABLE:
            out["porous"] = self.porous(fraction)
            if wet := self.initial_saturation(used, points, triangles, thickness, fraction):
                out["initial_saturation"] = wet
        else:
            self.missing.add(f"cloth of solid fraction {IMPERMEABLE:g} or more is a wall without porous", "restVolumeFraction",
                             element.line)
            for p in (self.particles[k] for k in used if self.particles[k].number("fvol", 0.0)):
                self.missing.add("a wall holds no liquid", "particle@fvol", p.line)
        self.list_particles(used)
        return out

    def strain_damping(self, parameters, young):
        if not parameters.value("viscosity", 0.0) or not parameters.value("accumulateWithViscous", 0):
            return 0.0
        if parameters.value("accumulateViscousOnlyForBendingModes", 1):
            self.missing.add("drench damps strain, not bending alone", "ElasticParameters/viscosity",
                             parameters.first("viscosity").line)
            return 0.0
        return min(3 * parameters.value("viscosity", 0.0) / young, 100.0)

    def porous(self, fraction):
        along, across = self.liquid.permeabilities(fraction)
        suction = self.liquid.suction(fraction)
        out = {"solid_fraction": fraction, "permeability": min(across * CM ** 2, 1e-4)}
        if suction > 0:
            g = length(tuple(map(sum, zip(*(e.axes(("fx", "fy", "fz")) for e in self.scene.all("simplegravity")), (0, 0, 0)))))
            out["diffusion"] = "degenerate"
            out["diffusivity"] = min((1 - fraction) * along * suction / self.liquid.viscosity * CM ** 2, 1.0)
            out["capillary_height"] = min(suction / (self.liquid.density * (g or 981.0)) * CM, 1000.0)
        else:
            out["diffusivity"] = 0.0
        return out

    def pins(self, used):
        groups = {}
        for node, p in enumerate(used):
            if int(self.particles[p].number("fixed", 0)) & 1:
                groups.setdefault(int(self.particles[p].number("group", 0)), []).append(node)
        out = []
        still = [node for group, nodes in groups.items() if not self.motions.get(group) for node in nodes]
        if still:
            out.append({"nodes": sorted(still)})
        for group, nodes in sorted(groups.items()):
            if not (motion := self.motions.get(group)):
                continue
            pin = {"nodes": nodes}
            if motion.shifts:
                pin["velocity"] = velocity_keys(motion)
            if motion.spins:
                origin = motion.spins[0][4]
                pin["spin"] = spin_keys(motion, self.middle_of_group(group) if origin is None else origin)
            out.append(pin)
        return out

    def middle_of_group(self, group):
        """About which libWetCloth rotates: the middle of the group's distance fields, or the origin."""
        boxes = [field.shape.box() for field in self.fields if field.group == group]
        if not boxes:
            return (0.0, 0.0, 0.0)
        low, high = zip(*boxes)
        return times(add(tuple(map(min, zip(*low))), tuple(map(max, zip(*high)))), 0.5)

    def initial_saturation(self, used, points, triangles, thickness, fraction):
        """Boxes, one around each wet node, or one around all where they are alike."""
        volumes = [self.particles[p].number("fvol", 0.0) for p in used]
        if not any(volumes):
            return []
        area = [0.0] * len(used)
        for a, b, c in triangles:
            third = length(cross(minus(points[b], points[a]), minus(points[c], points[a]))) / 6
            for n in (a, b, c):
                area[n] += third
        most = 1.18
        values = [v / (a * thickness * (1 - fraction)) if a > 0 else 0.0 for v, a in zip(volumes, area)]
        if max(values) > most:
            self.missing.add(f"more liquid than a saturation of {most:g}", "particle@fvol", self.particles[used[0]].line)
            values = [min(v, most) for v in values]
        if max(values) - min(values) < 1e-9 * max(values):
            margin = (1e-3 * (1 + thickness),) * 3
            low, high = bounds(points)
            return [{"box": box_of((minus(low, margin), add(high, margin))), "value": values[0]}]
        near = 1e-3 * min((math.dist(points[a], points[b]) for t in triangles for a, b in zip(t, t[1:])), default=1.0)
        return [{"box": box_of((minus(x, (near,) * 3), add(x, (near,) * 3))), "value": v} for x, v in zip(points, values) if v > 0]

    def list_particles(self, used):
        for p in (self.particles[k] for k in used):
            if any(p.vector("v", (0.0, 0.0, 0.0))):
                self.missing.add("cloth starts at rest", "particle@v", p.line)
            for name in ("m", "vol", "radius", "vf", "fm"):
                if p.number(name, 0.0) and name in p.attributes:
                    self.missing.add("cloth has one thickness and mass per unit area", f"particle@{name}", p.line)

    # Solids.

    def bodies(self):
        cloth_moves = bool(self.cloths) and self.liquid.solid_moves
        return [body for field in self.fields if field.usage == "solid" for body in self.body(field, cloth_moves)]

    def body(self, field, cloth_moves):
        e, shape = field.element, field.shape
        self.extent += shape.box()
        motion = self.motions.get(field.group) or Motion()
        if not field.sampled and self.cloths:
            self.missing.add("cloth passes through it in libWetCloth, and collides with it in drench", f"{field.name}@sampled 0", e.line)
        low, high = shape.box()
        center = times(add(low, high), 0.5)
        pivot = field.pivot if field.pivot is not None else center
        if field.parts and motion.spins:
            self.missing.add("each part rotates about its own middle in libWetCloth, the whole in drench", field.name, e.line)
        moves = body_motion(motion, center, pivot, field.matrix, self.missing, field.name, e.line) if motion else {}
        if isinstance(shape, Sphere) and not field.inside:
            return [{"sphere": {"center": [CM * x for x in shape.center], "radius": CM * shape.radius, **moves}}]
        boxed = isinstance(shape, RoundedBox) and along_axes(shape.matrix)
        if boxed and (shape.radius < 0.5 * self.spacing or field.inside and cloth_moves):
            if shape.radius:
                self.missing.add("its corners are sharp in drench", f"{field.name}@radius", e.line)
            return [{"box": {**box_of((low, high)), **({"inside": True} if field.inside else {}), **moves}}]
        if field.inside and cloth_moves:
            self.missing.add("beside moving cloth a container is a box; its bounding box is used", f"{field.name}@inside", e.line)
            return [{"box": {**box_of((low, high)), "inside": True, **moves}}]
        points, triangles = generated(field, self.spacing)
        file = self.output.mesh(f"solid_{e.line}", in_metres(points), triangles)
        return [{"mesh": {"file": file, **({"inside": True} if field.inside else {}), **moves}}]

    def domain(self):
        """The terminator, or else the container or the neighbourhood of everything."""
        boxes = []
        for field in (f for f in self.fields if f.usage == "terminator"):
            if not field.inside or isinstance(field.shape, MeshShape):
                self.missing.add("drench removes liquid only outside of its domain", field.name, field.element.line)
                continue
            if not (isinstance(field.shape, RoundedBox) and along_axes(field.shape.matrix)):
                self.missing.add("the domain is a box; its bounding box is used", field.name, field.element.line)
            elif field.shape.radius:
                self.missing.add("its corners are sharp in drench", f"{field.name}@radius", field.element.line)
            boxes.append(field.shape.box())
        if boxes:
            low, high = zip(*boxes)
            return box_of((tuple(map(max, zip(*low))), tuple(map(min, zip(*high)))))
        containers = [f.shape.box() for f in self.fields if f.usage == "solid" and f.inside]
        low, high = bounds(self.extent) if self.extent else ((0.0,) * 3, (0.0,) * 3)
        margin = 4 * self.spacing if containers else max(2 * max(minus(high, low)), 10 * self.spacing)
        if not containers:
            self.missing.add("libWetCloth's space has no end; the domain is five times the size of everything in it",
                             "no terminator")
        return box_of((minus(low, (margin,) * 3), add(high, (margin,) * 3)))


if __name__ == "__main__":
    run_reader("read_libwetcloth.py", __doc__, Importer)

"""The prims of a run in USD: each is given a frame at a time code and writes what has changed."""

import sys

import numpy as np
from pxr import Gf, Sdf, Tf, UsdGeom, UsdShade, Vt

from wet_maps import WetMap

DRY_COLOUR = np.array([0.80, 0.74, 0.64], np.float32)  # linear; of fabric at saturation 0
WET_COLOUR = 0.3 * DRY_COLOUR  # a look: soaked cotton reflects a third to a half of what dry cotton does
DRY_ROUGHNESS, WET_ROUGHNESS = 0.90, 0.30
RIGID = 1e-5  # of a body's size: how far points may be from a turned and shifted copy


def vectors(values):
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, np.float32))


def reals(values):
    return Vt.FloatArray.FromNumpy(np.ascontiguousarray(values, np.float32))


def integers(values):
    return Vt.IntArray.FromNumpy(np.ascontiguousarray(values, np.int32))


def extent(points, margin=0.0):
    if len(points) == 0:
        return vectors(np.zeros((2, 3)))
    return vectors([points.min(0) - margin, points.max(0) + margin])


def vertex_normals(points, triangles):
    """Unit normals of the points, weighted by the areas of the triangles around them."""
    corners = points[triangles].astype(np.float64)
    of_face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.stack([np.bincount(triangles.ravel(), np.repeat(of_face[:, axis], 3), len(points)) for axis in range(3)], 1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return total / np.where(length > 0, length, 1)


def define_material(stage, name, colour, roughness, opacity=1.0, ior=1.5):
    """A UsdPreviewSurface. Colour and roughness are values, or names of primvars that hold them."""
    material = UsdShade.Material.Define(stage, f"/World/materials/{name}")
    surface = UsdShade.Shader.Define(stage, material.GetPath().AppendChild("surface"))
    surface.CreateIdAttr("UsdPreviewSurface")
    for key, value, kind, reader in (("diffuseColor", colour, Sdf.ValueTypeNames.Color3f, "float3"),
                                     ("roughness", roughness, Sdf.ValueTypeNames.Float, "float")):
        to = surface.CreateInput(key, kind)
        if not isinstance(value, str):
            to.Set(value)
            continue
        node = UsdShade.Shader.Define(stage, material.GetPath().AppendChild(key))
        node.CreateIdAttr(f"UsdPrimvarReader_{reader}")
        node.CreateInput("varname", Sdf.ValueTypeNames.String).Set(value)
        result = Sdf.ValueTypeNames.Float3 if reader == "float3" else Sdf.ValueTypeNames.Float
        to.ConnectToSource(node.CreateOutput("result", result))
    surface.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
    surface.CreateInput("ior", Sdf.ValueTypeNames.Float).Set(ior)
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", Sdf.ValueTypeNames.Token))
    return material


def bind(prim, material):
    UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)


def define_mesh(stage, path):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    return mesh


class Liquid:
    """The particles."""

    def __init__(self, stage, beside_surface):
        self.prim = UsdGeom.Points.Define(stage, "/World/liquid")
        if beside_surface:  # what a viewport shows in place of the surface
            self.prim.CreatePurposeAttr(UsdGeom.Tokens.proxy)
        self.prim.CreateDisplayColorAttr(vectors([[0.10, 0.35, 0.65]]))
        self.count = 0

    def write(self, code, frame):
        points, radius = frame.read("Points"), frame.read("radius")
        self.prim.CreatePointsAttr().Set(vectors(points), code)
        self.prim.CreateVelocitiesAttr().Set(vectors(frame.read("velocity")), code)
        self.prim.CreateWidthsAttr().Set(reals(2 * radius), code)
        self.prim.CreateIdsAttr().Set(Vt.Int64Array.FromNumpy(np.ascontiguousarray(frame.read("id"), np.int64)), code)
        self.prim.CreateExtentAttr().Set(extent(points, radius.max() if len(radius) else 0), code)
        self.count = len(points)
        return 40 * self.count


class Surface:
    """The liquid's surface: each frame has other points and triangles."""

    def __init__(self, stage):
        self.prim = define_mesh(stage, "/World/surface")
        self.prim.CreatePurposeAttr(UsdGeom.Tokens.render)
        self.prim.CreateDisplayColorAttr(vectors([[0.10, 0.35, 0.65]]))
        self.prim.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        bind(self.prim, define_material(stage, "liquid", Gf.Vec3f(0.55, 0.75, 0.85), 0.03, opacity=0.4, ior=1.33))

    def write(self, code, frame):
        points, corners = frame.read("Points"), frame.read("connectivity")
        self.prim.CreatePointsAttr().Set(vectors(points), code)
        self.prim.CreateFaceVertexIndicesAttr().Set(integers(corners), code)
        self.prim.CreateFaceVertexCountsAttr().Set(integers(np.full(len(corners) // 3, 3)), code)
        self.prim.CreateNormalsAttr().Set(vectors(frame.read("normal")), code)
        self.prim.CreateVelocitiesAttr().Set(vectors(frame.read("velocity")), code)
        self.prim.CreateExtentAttr().Set(extent(points), code)
        return 36 * len(points) + 4 * len(corners)


def set_texture(prim, coordinates):
    """`coordinates`: u and v of each corner of the faces."""
    kind, corners = Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar("st", kind, corners).Set(Vt.Vec2fArray.FromNumpy(coordinates))


class Cloth:
    """One of the cloths: the points and triangles of the frames that are its own."""

    def __init__(self, stage, path, triangles):
        """`triangles` number the frame's points; they stay for all frames."""
        self.first, last = int(triangles.min()), int(triangles.max())
        self.nodes = slice(self.first, last + 1)
        self.triangles = triangles - self.first
        self.prim = define_mesh(stage, path)
        self.prim.CreateDoubleSidedAttr(True)
        self.prim.CreateFaceVertexIndicesAttr(integers(self.triangles.ravel()))
        self.prim.CreateFaceVertexCountsAttr(integers(np.full(len(triangles), 3)))
        self.prim.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        variables = UsdGeom.PrimvarsAPI(self.prim)
        vertex = UsdGeom.Tokens.vertex
        self.saturation = variables.CreatePrimvar("saturation", Sdf.ValueTypeNames.FloatArray, vertex)
        self.roughness = variables.CreatePrimvar("roughness", Sdf.ValueTypeNames.FloatArray, vertex)
        self.colour = variables.CreatePrimvar("displayColor", Sdf.ValueTypeNames.Color3fArray, vertex)

    def set_texture(self, coordinates):
        """`coordinates`: u and v of each corner of the triangles; a seam's corners differ at one point."""
        set_texture(self.prim, coordinates)

    def write(self, code, frame):
        points, saturation = frame.read("Points")[self.nodes], frame.read("saturation")[self.nodes]
        wet = np.clip(saturation, 0, 1)
        self.prim.CreatePointsAttr().Set(vectors(points), code)
        self.prim.CreateVelocitiesAttr().Set(vectors(frame.read("velocity")[self.nodes]), code)
        self.prim.CreateNormalsAttr().Set(vectors(vertex_normals(points, self.triangles)), code)
        self.prim.CreateExtentAttr().Set(extent(points), code)
        self.saturation.Set(reals(saturation), code)
        self.roughness.Set(reals(DRY_ROUGHNESS + (WET_ROUGHNESS - DRY_ROUGHNESS) * wet), code)
        self.colour.Set(vectors(DRY_COLOUR + np.outer(wet, WET_COLOUR - DRY_COLOUR)), code)
        return 56 * len(points)


def define_cloths(stage, frame, names, textures):
    """A Cloth for each that the frame has, named as in the scene; the same material for all. `textures`: coordinates by number."""
    triangles, owner = frame.read("connectivity").reshape(-1, 3).astype(np.int64), frame.read("cloth")
    material, cloths, taken = define_material(stage, "cloth", "displayColor", "roughness"), [], set()
    UsdGeom.Xform.Define(stage, "/World/cloth")
    for index in np.unique(owner):
        name = Tf.MakeValidIdentifier(names[index]) if index < len(names) else f"cloth_{index}"
        while name in taken:
            name += "_"
        taken.add(name)
        cloths.append(Cloth(stage, f"/World/cloth/{name}", triangles[owner == index]))
        bind(cloths[-1].prim, material)
        texture, corners = textures.get(int(index)), 3 * np.count_nonzero(owner == index)
        if texture is not None and len(texture) == corners:
            cloths[-1].set_texture(texture)
        elif texture is not None:
            print(f"warning: cloth {name}: its mesh file is not the one of the run: no texture coordinates", file=sys.stderr)
    return cloths


class Body:
    """A solid body: a mesh that a matrix moves as long as its points allow that, and points at each frame otherwise."""

    def __init__(self, stage, path, shape, container):
        self.rest, self.counts, self.corners = shape
        self.poses, self.rigid, self.move = [], True, None
        self.now, self.map, self.primvars = self.rest, None, None
        self.prim = define_mesh(stage, path)
        if container:  # its walls would hide what is in it
            self.prim.CreatePurposeAttr(UsdGeom.Tokens.guide)
        self.prim.CreateDisplayColorAttr(vectors([[0.55, 0.55, 0.58]]))
        self.prim.CreatePointsAttr(vectors(self.rest))
        self.prim.CreateExtentAttr(extent(self.rest))
        self.prim.CreateFaceVertexCountsAttr(integers(self.counts))
        self.prim.CreateFaceVertexIndicesAttr(integers(self.corners))

    def set_texture(self, coordinates):
        """`coordinates`: u and v of each corner; triangles that close holes, which come last, have none in the file."""
        if len(coordinates) > len(self.corners):
            return
        all_corners = np.zeros((len(self.corners), 2), np.float32)
        all_corners[:len(coordinates)] = coordinates
        set_texture(self.prim, all_corners)

    def write_wetness(self, code, particles, since):
        """What the liquid of this frame makes of its points (wet_maps.py)."""
        if self.map is None:
            self.map, variables = WetMap(len(self.rest)), UsdGeom.PrimvarsAPI(self.prim)
            self.primvars = [variables.CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.vertex)
                             for name in ("contact_time", "film")]
        if len(self.now) != len(self.map.film):  # a body of another number of points has no map
            return
        self.map.add(self.now.astype(np.float64), particles, since)
        for primvar, values in zip(self.primvars, (self.map.contact, self.map.film)):
            primvar.Set(reals(values), code)

    def write(self, code, shape):
        points = self.now = shape[0]
        pose = self._pose(points, shape) if self.rigid else None
        if pose is not None:
            if self.move is None:
                self.move = self.prim.AddTransformOp()
            self.poses.append((code, pose))
            self.move.Set(pose, code)
            return
        if self.rigid:
            self._leave_poses()
        self._write_shape(code, shape)

    def _pose(self, points, shape):
        """The matrix that carries the first frame's points here (Kabsch 1976), None if none does."""
        if len(points) != len(self.rest) or not np.array_equal(shape[2], self.corners):
            return None
        a, b = self.rest.astype(np.float64), points.astype(np.float64)
        mean_a, mean_b = a.mean(0), b.mean(0)
        left, _, right = np.linalg.svd((a - mean_a).T @ (b - mean_b))
        mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        turn = left @ mirror @ right  # of rows: b = a turn + shift
        shift = mean_b - mean_a @ turn
        if np.abs(a @ turn + shift - b).max() > RIGID * np.ptp(b, 0).max() + 1e-6 * np.abs(b).max():
            return None
        matrix = np.eye(4)
        matrix[:3, :3], matrix[3, :3] = turn, shift
        return Gf.Matrix4d(matrix)

    def _leave_poses(self):
        self.rigid = False
        if self.move is not None:
            self.prim.ClearXformOpOrder()
            self.prim.GetPrim().RemoveProperty(self.move.GetName())
        for code, pose in self.poses:
            matrix = np.array(pose)
            moved = self.rest @ matrix[:3, :3] + matrix[3, :3]
            self._write_shape(code, (moved, self.counts, self.corners))

    def _write_shape(self, code, shape):
        points, counts, corners = shape
        self.prim.CreatePointsAttr().Set(vectors(points), code)
        self.prim.CreateExtentAttr().Set(extent(points), code)
        self.prim.CreateFaceVertexCountsAttr().Set(integers(counts), code)
        self.prim.CreateFaceVertexIndicesAttr().Set(integers(corners), code)


class Bodies:
    """All bodies, each a prim of its own; those that stand still are written once."""

    def __init__(self, stage, textures):
        """`textures`: texture coordinates by number."""
        self.stage, self.textures, self.bodies, self.seen = stage, textures, {}, set()
        UsdGeom.Xform.Define(stage, "/World/bodies")
        self.material = define_material(stage, "body", Gf.Vec3f(0.55, 0.55, 0.58), 0.6)

    def write(self, code, path, frame):
        moving = not path.name.endswith("_static.vtu")
        if not moving and path in self.seen:
            return
        self.seen.add(path)
        points, corners = frame.read("Points"), frame.read("connectivity").astype(np.int64)
        if len(points) == 0:  # no body is shown, and the frame has one cell without points
            return
        ends, owner, container = frame.read("offsets").astype(np.int64), frame.read("body"), frame.read("container")
        counts = np.diff(ends, prepend=0)
        for index in np.unique(owner):
            own = owner == index
            used = corners[np.repeat(own, counts)]
            first = used.min()
            shape = points[first:used.max() + 1], counts[own], used - first
            if index not in self.bodies:
                inside = bool(container[own][0])
                self.bodies[index] = Body(self.stage, f"/World/bodies/body_{index}", shape, inside)
                bind(self.bodies[index].prim, self.material)
                if index in self.textures:
                    self.bodies[index].set_texture(self.textures[index])
            if moving:
                self.bodies[index].write(code, shape)

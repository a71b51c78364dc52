"""The meshes of objects as Blender evaluates them, in metres and in the axes of Blender's world."""

import contextlib

import numpy as np

from .problem import Problem

MODIFIER = "Drench"
WELD = 1e-5  # m: boundary vertices at most this far apart are one node
LEAST_AREA = 1e-12  # of a triangle, relative to the square of its longest side


def unit(scene):
    """Metres per unit of length."""
    return float(f"{scene.unit_settings.scale_length:.7g}") or 1.0


def modifier_index(thing):
    """Place of our modifier in the stack of a cloth; the number of modifiers if it has none."""
    return next((k for k, m in enumerate(thing.modifiers) if m.name == MODIFIER and m.type == "NODES"),
                len(thing.modifiers))


@contextlib.contextmanager
def without_results(cloths):
    """Within it, cloths are evaluated without our modifier and those below, which apply to the simulated cloth."""
    hidden = []
    try:
        for thing in cloths:
            for modifier in list(thing.modifiers)[modifier_index(thing):]:
                if modifier.show_viewport:
                    modifier.show_viewport = False
                    hidden.append(modifier)
        yield
    finally:
        for modifier in hidden:
            modifier.show_viewport = True


@contextlib.contextmanager
def visible(things, view_layer):
    """Within it, hidden objects are evaluated too. Blender does not update objects that are hidden in the viewport."""
    shown = []
    view_layer.update()  # lists objects that a script has just added
    try:
        for thing in things:
            if thing.name not in view_layer.objects:
                raise Problem(f"'{thing.name}' is in a collection that is excluded from the view layer: include the "
                              "collection, or remove the role of the object")
            state = thing.hide_viewport, thing.hide_get(view_layer=view_layer)
            if any(state):
                shown.append((thing, state))
                thing.hide_viewport = False
                thing.hide_set(False, view_layer=view_layer)
            if not thing.visible_get(view_layer=view_layer):
                raise Problem(f"'{thing.name}' is in a hidden collection: show the collection in the viewport")
        yield
    finally:
        for thing, state in shown:
            thing.hide_set(state[1], view_layer=view_layer)
            thing.hide_viewport = state[0]


def check_modifiers(thing):
    """Rejects modifiers above ours that would give another mesh in a render than in the viewport."""
    for modifier in list(thing.modifiers)[:modifier_index(thing)]:
        levels = {"SUBSURF": "render_levels", "MULTIRES": "render_levels"}.get(modifier.type)
        if modifier.show_viewport != modifier.show_render:
            raise Problem(f"'{thing.name}': the modifier {modifier.name} is not active in both viewport and render: "
                          f"activate it in both, or move it below the modifier {MODIFIER}")
        if levels and modifier.show_viewport and modifier.levels != modifier.render_levels:
            raise Problem(f"'{thing.name}': the modifier {modifier.name} has other levels in the render than in the "
                          f"viewport: use the same number, or move it below the modifier {MODIFIER}")


class Mesh:
    """Vertices (m, float64) and triangles of an object at the current frame."""

    def __init__(self, thing, depsgraph, scale):
        if thing.type == "MESH" and thing.mode == "EDIT":
            thing.update_from_editmode()
        seen = thing.evaluated_get(depsgraph)
        try:
            mesh = seen.to_mesh()
        except RuntimeError:
            raise Problem(f"'{thing.name}' has no mesh: use an object whose shape is a mesh") from None
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        mesh.calc_loop_triangles()
        triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        matrix = np.array(seen.matrix_world, np.float64)
        seen.to_mesh_clear()
        self.matrix = matrix
        self.points = scale * (points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])
        self.triangles = triangles.reshape(-1, 3)
        if np.linalg.det(matrix[:3, :3]) < 0:  # a mirrored object: its faces would point inwards
            self.triangles = self.triangles[:, ::-1]
        if not np.isfinite(self.points).all():
            raise Problem(f"'{thing.name}' has vertices that are not finite: check its modifiers and its scale")

    def box(self):
        """(lowest, highest) corner, m."""
        return self.points.min(0), self.points.max(0)

    def need_faces(self, thing):
        if len(self.triangles) == 0:
            raise Problem(f"'{thing.name}' has no faces: use a mesh with faces")


def has_area(points, triangles):
    a, b, c = (points[triangles[:, k]] for k in range(3))
    longest = np.max([((b - a) ** 2).sum(1), ((c - b) ** 2).sum(1), ((a - c) ** 2).sum(1)], axis=0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) > 2 * LEAST_AREA * longest


def boundary_vertices(triangles, count):
    """Mask of the vertices at edges with one triangle."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    edges, uses = np.unique(edges, axis=0, return_counts=True)
    mask = np.zeros(count, bool)
    mask[edges[uses == 1]] = True
    return mask


def crowded_edges(triangles):
    """The number of edges with more than two triangles; repeated triangles count once."""
    triangles = np.unique(np.sort(triangles, axis=1), axis=0)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [0, 2]]])
    return int((np.unique(edges, axis=0, return_counts=True)[1] > 2).sum())


def _welded(points, triangles):
    """For each vertex, the first boundary vertex in the same place, or itself."""
    first = np.arange(len(points))
    free = np.flatnonzero(boundary_vertices(triangles, len(points)))
    if len(free) == 0:
        return first
    from mathutils.kdtree import KDTree
    tree = KDTree(len(free))
    for vertex in free:
        tree.insert(points[vertex], int(vertex))
    tree.balance()
    for vertex in free:
        first[vertex] = min(first[index] for _, index, _ in tree.find_range(points[vertex], WELD) if index <= vertex)
    return first


class ClothMesh:
    """What the program receives of a cloth: nodes without seams and loose vertices. `node` maps each vertex of the
    object to its node, or to -1 if no face uses the vertex; `vertex` is one vertex of each node."""

    def __init__(self, mesh, weld):
        count = len(mesh.points)
        first = _welded(mesh.points, mesh.triangles) if weld else np.arange(count)
        triangles = first[mesh.triangles]
        triangles = triangles[has_area(mesh.points, triangles)]
        self.vertex, numbers = np.unique(triangles, return_inverse=True)
        self.triangles = numbers.reshape(-1, 3).astype(np.int32)
        node = np.full(count, -1, np.int32)
        node[self.vertex] = np.arange(len(self.vertex))
        self.node = node[first]
        self.vertices = count

    def points(self, mesh):
        return mesh.points[self.vertex]

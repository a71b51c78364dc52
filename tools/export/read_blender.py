"""Writes a mesh of a file that Blender reads (.fbx, .gltf, .glb, .abc, .blend) as PLY files that a scene's `sequence` reads.
`drench import FILE` starts it; `tools/setup blender` makes the Python that it needs, with Blender as the module bpy."""

import argparse
import contextlib
import os
import re
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

from refusal import fail

try:
    import bpy
    import numpy as np
except ImportError as error:
    fail(f"this file needs Python's {error.name}: run tools/setup blender, or name a Python that has bpy in DRENCH_BLENDER_PYTHON")

from mesh_files import MeshFiles, add_options, named, number_of_files, told


@contextlib.contextmanager
def silent():
    """Blender's readers print on their own, past Python."""
    sys.stdout.flush()
    kept, nothing = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(nothing)
        os.close(kept)


def read(file):
    """Loads the file into an empty scene."""
    ending, path = file.suffix.lower(), str(file.resolve())
    if ending == ".blend":
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
        return
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if ending == ".fbx":
        new = hasattr(bpy.ops.wm, "fbx_import") and "fbx_import" in dir(bpy.ops.wm)
        bpy.ops.wm.fbx_import(filepath=path) if new else bpy.ops.import_scene.fbx(filepath=path)
    elif ending in (".gltf", ".glb"):
        bpy.ops.import_scene.gltf(filepath=path)
    else:
        bpy.ops.wm.alembic_import(filepath=path, as_background_job=False, set_frame_range=True)


def find_mesh(file, name):
    meshes = [o for o in bpy.context.scene.objects if o.type == "MESH" and len(o.data.polygons) > 0]
    names = [o.name for o in meshes]
    if not meshes:
        fail(f"{file}: holds no mesh")
    if name is None:
        if len(meshes) > 1:
            fail(f"{file}: holds {len(meshes)} meshes: choose one with --prim: {named(names)}")
        return meshes[0]
    for o in meshes:
        if o.name == name:
            return o
    below = [o for o in meshes if any(parent == name for parent in parents(o))]
    if len(below) != 1:
        fail(f"{file}: --prim: unknown mesh {name}; the meshes are {named(names)}")
    return below[0]


def parents(o):
    while o.parent:
        o = o.parent
        yield o.name


class MovingMesh:
    """Points in metres, y up, and triangles, the same at all times."""

    def __init__(self, file, thing):
        self.file, self.thing, self.scene = file, thing, bpy.context.scene
        self.unit = self.scene.unit_settings.scale_length or 1.0
        self.triangles = None
        _, self.triangles = self.evaluate(self.scene.frame_start)
        if len(self.triangles) == 0:
            fail(f"{file}: {thing.name} has no faces")
        self.used, renumbered = np.unique(self.triangles, return_inverse=True)
        self.own, self.triangles = self.triangles, renumbered.reshape(-1, 3)
        if file.suffix.lower() in (".gltf", ".glb"):
            self.merge_copies()

    def merge_copies(self):
        """glTF repeats points where texture or normals part; here they are one again."""
        points = self.points(self.range()[0]).astype(np.float32)
        _, first, copy_of = np.unique(points, axis=0, return_index=True, return_inverse=True)
        order = np.argsort(first)  # points keep their order
        rank = np.empty(len(order), np.int64)
        rank[order] = np.arange(len(order))
        self.used, triangles = self.used[first[order]], rank[copy_of.reshape(-1)][self.triangles]
        whole = (triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2]) & (triangles[:, 2] != triangles[:, 0])
        self.triangles = triangles[whole]

    def evaluate(self, frame):
        whole = int(np.floor(frame))
        self.scene.frame_set(whole, subframe=float(frame - whole))
        thing = self.thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        mesh = thing.to_mesh()
        points = np.empty(3 * len(mesh.vertices), np.float64)
        mesh.vertices.foreach_get("co", points)
        mesh.calc_loop_triangles()
        triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        matrix = np.array(thing.matrix_world)
        thing.to_mesh_clear()
        points = points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
        return points[:, [0, 2, 1]] * (self.unit, self.unit, -self.unit), triangles.reshape(-1, 3)

    def points(self, frame):
        points, triangles = self.evaluate(frame)
        if len(points) <= self.used.max() or len(triangles) != len(self.own):
            fail(f"{self.file}: {self.thing.name} has other faces at frame {frame:g}; allowed: points that move, nothing else")
        points = points[self.used]
        if not np.isfinite(points).all():
            fail(f"{self.file}: {self.thing.name} has points that are not finite at frame {frame:g}")
        return points

    def frames(self, fps):
        """Those at which it is written; one where it stands still."""
        first, last = self.range()
        rate = self.scene.render.fps / self.scene.render.fps_base
        fps = fps or rate
        still = self.points(first)
        probes = np.linspace(first, last, min(int(last - first) + 1, 64))
        if not any(np.abs(self.points(f) - still).max() > 1e-7 * np.ptp(still) for f in probes[1:]):
            return [first], fps
        return [first + k * rate / fps for k in range(number_of_files(self.file, (last - first) / rate, fps))], fps

    def range(self):
        """Of the actions where there are any, else the scene's."""
        ranges = [action.frame_range for action in bpy.data.actions]
        if ranges and self.file.suffix.lower() not in (".blend", ".abc"):
            return float(min(r[0] for r in ranges)), float(max(r[1] for r in ranges))
        return float(self.scene.frame_start), float(self.scene.frame_end)


def import_mesh(options):
    with silent():
        read(options.file)
        thing = find_mesh(options.file, options.prim)
        mesh = MovingMesh(options.file, thing)
        frames, fps = mesh.frames(options.fps)
        name = re.sub(r"[^A-Za-z0-9_]", "_", thing.name)
        files = MeshFiles(options.folder, name, f"{options.file}: {thing.name}", mesh.triangles, frames, mesh.points,
                          lambda frame: f"frame {frame:g}")
    if options.first:
        print("\n".join(files.names(fps)))
        return
    print(told(files, fps, mesh.triangles, thing.name))
    print("\n".join(files.scene_lines(fps)))


def main():
    parser = argparse.ArgumentParser(prog="read_blender.py", description=__doc__)
    options = add_options(parser, "the mesh, by the name of its object")
    if not options.file.is_file():
        fail(f"{options.file}: no such file")
    try:
        import_mesh(options)
    except RuntimeError as error:
        fail(f"{options.file}: cannot be read: {' '.join(str(error).split())}")
    except OSError as error:
        fail(f"{error.filename or options.folder}: cannot be written: {error.strerror}")
    sys.stdout.flush()


if __name__ == "__main__":
    main()

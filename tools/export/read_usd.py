"""Writes a mesh of a USD file as PLY files that a scene's `sequence` reads. `drench import FILE` starts it; `tools/setup export`
makes the Python that it needs, with usd-core and numpy."""

import argparse
import math
import re
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

from refusal import fail, fail_without

MOST_FILES = 100_000  # of a sequence
RIGID = 1e-5  # of a mesh's size: how far the points of a body's sequence may be from a turned and shifted copy


try:
    import numpy as np
    from pxr import Sdf, Tf, Usd, UsdGeom
except ImportError as error:
    fail_without(error.name)


def parse_arguments():
    parser = argparse.ArgumentParser(prog="read_usd.py", description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("folder", type=Path, nargs="?", help="for the PLY files (default: the file's name without its ending)")
    parser.add_argument("--prim", help="the mesh, or what it is the only mesh of")
    parser.add_argument("--fps", type=float, help="files a second (default: the time codes of the stage)")
    options = parser.parse_args()
    options.folder = options.folder or options.file.with_suffix("")
    return options


def named(paths, most=8):
    return ", ".join(str(path) for path in paths[:most]) + (f" and {len(paths) - most} more" if len(paths) > most else "")


def find_mesh(stage, file, prim):
    """The one mesh at or below `prim`, or of the whole stage."""
    root = stage.GetPseudoRoot()
    if prim is not None:
        root = stage.GetPrimAtPath(prim) if Sdf.Path.IsValidPathString(prim) else None
    everything = [p.GetPath() for p in stage.Traverse() if p.IsA(UsdGeom.Mesh)]
    if not everything:
        fail(f"{file}: holds no mesh")
    if not root:
        fail(f"{file}: --prim: there is no {prim}; the meshes are {named(everything)}")
    meshes = [p for p in Usd.PrimRange(root) if p.IsA(UsdGeom.Mesh)]
    if not meshes:
        fail(f"{file}: --prim: {prim} is no mesh; the meshes are {named(everything)}")
    if len(meshes) > 1:
        fail(f"{file}: holds {len(meshes)} meshes: choose one with --prim: {named([p.GetPath() for p in meshes])}")
    return UsdGeom.Mesh(meshes[0])


def fans(counts, corners):
    """Polygons as triangles around their first corner."""
    starts = np.cumsum(counts) - counts
    pieces = np.maximum(counts - 2, 0)
    first = np.repeat(starts, pieces)
    step = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return corners[np.stack([first, first + step + 1, first + step + 2], 1)]


class MovingMesh:
    """Points in metres, in the axes of the stage, and triangles, the same at all times."""

    def __init__(self, stage, mesh, file):
        self.stage, self.mesh, self.file = stage, mesh, file
        self.first_code = stage.GetStartTimeCode() if stage.HasAuthoredTimeCodeRange() else 0.0
        self.faces = self._faces(self._own_codes(mesh.GetPointsAttr())[:1] or [self.first_code])
        if len(self.faces[0]) == 0:
            fail(f"{file}: {mesh.GetPath()} has no faces")
        triangles = fans(*self.faces)
        if mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
            triangles = triangles[:, ::-1]
        self.used, renumbered = np.unique(triangles, return_inverse=True)
        self.triangles = renumbered.reshape(-1, 3)

    def _own_codes(self, attribute):
        return list(attribute.GetTimeSamples())

    def _faces(self, codes):
        counts = np.asarray(self.mesh.GetFaceVertexCountsAttr().Get(codes[0]) or [], np.int64)
        corners = np.asarray(self.mesh.GetFaceVertexIndicesAttr().Get(codes[0]) or [], np.int64)
        return counts, corners

    def check_faces(self):
        """A sequence has one set of triangles."""
        for attribute in (self.mesh.GetFaceVertexCountsAttr(), self.mesh.GetFaceVertexIndicesAttr()):
            for code in self._own_codes(attribute):
                if not all(np.array_equal(a, b) for a, b in zip(self._faces([code]), self.faces)):
                    fail(f"{self.file}: {self.mesh.GetPath()} has other faces at time code {code:g}; allowed: points that move, "
                         "nothing else")

    def moves(self):
        """The first and the last time code at which it moves, None where it stands still."""
        codes = self._own_codes(self.mesh.GetPointsAttr())
        prim = self.mesh.GetPrim()
        while prim and not prim.IsPseudoRoot():
            if xform := UsdGeom.Xformable(prim):
                codes += xform.GetTimeSamples()
            prim = prim.GetParent()
        return (min(codes), max(codes)) if len(set(codes)) > 1 else None

    def points(self, code):
        values = self.mesh.GetPointsAttr().Get(code)
        points = np.asarray(values if values is not None else [], np.float64).reshape(-1, 3)
        if len(points) <= self.used.max():
            fail(f"{self.file}: {self.mesh.GetPath()} has {len(points)} points at time code {code:g}, and its faces name more")
        matrix = np.array(self.mesh.ComputeLocalToWorldTransform(code))
        points = (points[self.used] @ matrix[:3, :3] + matrix[3, :3]) * UsdGeom.GetStageMetersPerUnit(self.stage)
        if not np.isfinite(points).all():
            fail(f"{self.file}: {self.mesh.GetPath()} has points that are no numbers at time code {code:g}")
        return points


def write_ply(path, points, triangles):
    corners = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    corners["count"], corners["corners"] = 3, triangles
    header = ("ply\nformat binary_little_endian 1.0\ncomment metres\n"
              f"element vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + np.ascontiguousarray(points, "<f4").tobytes() + corners.tobytes())


def distance_from_rigid(a, b):
    """m: how far b is from the turned and shifted copy of a that is nearest (Kabsch 1976)."""
    mean_a, mean_b = a.mean(0), b.mean(0)
    left, _, right = np.linalg.svd((a - mean_a).T @ (b - mean_b))
    turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    return np.linalg.norm((a - mean_a) @ turn + mean_b - b, axis=1).max()


def merged_points(points):
    """How many are left where exact copies count once, as the scene's reader counts them."""
    return len(np.unique(points.astype(np.float32), axis=0))


def sampled_codes(mesh, rate, fps):
    span = mesh.moves()
    if span is None:
        return [mesh.first_code]
    first = mesh.stage.GetStartTimeCode() if mesh.stage.HasAuthoredTimeCodeRange() else span[0]
    last = mesh.stage.GetEndTimeCode() if mesh.stage.HasAuthoredTimeCodeRange() else span[1]
    files = math.floor((last - first) * fps / rate + 1e-6) + 1
    if files > MOST_FILES:
        fail(f"{mesh.file}: would be {files} files; allowed: up to {MOST_FILES}, which --fps decides")
    return [first + k * rate / fps for k in range(max(files, 1))]


def write_files(mesh, codes, folder, name):
    """Returns the first points, and how far the mesh is from a rigid one, over its size."""
    folder.mkdir(parents=True, exist_ok=True)
    digits = max(4, len(str(len(codes) - 1)))
    first, off = mesh.points(codes[0]), 0.0
    size, count = np.linalg.norm(np.ptp(first, axis=0)), merged_points(first)
    for k, code in enumerate(codes):
        points = mesh.points(code)
        if merged_points(points) != count:
            fail(f"{mesh.file}: {mesh.mesh.GetPath()}: points lie in the same place at time code {code:g} and not at {codes[0]:g}, "
                 "or the other way round")
        off = max(off, distance_from_rigid(first, points))
        write_ply(folder / f"{name}_{k:0{digits}d}.ply", points, mesh.triangles)
    later = re.compile(re.escape(name) + rf"_(\d{{{digits},}})\.ply")
    for path in folder.iterdir():  # of an import that had more: the scene would go on with them
        if (match := later.fullmatch(path.name)) and int(match[1]) >= len(codes):
            path.unlink()
    return first, off / size if size > 0 else 0.0, digits


def is_closed(triangles):
    """Does every edge have two triangles?"""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return bool((np.unique(edges, axis=0, return_counts=True)[1] == 2).all())


def scene_lines(folder, name, digits, count, fps, points, off, closed):
    """What a scene says to use the files."""
    first = f'"{folder / name}_{0:0{digits}d}.ply"'
    if count == 1:
        return ["bodies:", f"  - mesh: {{file: {first}}}", "# or, for a cloth:", "cloth:", f"  - mesh: {{file: {first}}}"]
    files = f'sequence: "{folder / name}_{{:0{digits}d}}.ply", fps: {fps:.9g}'
    if off <= RIGID or closed:
        changes = [] if off <= RIGID else ["# It changes its shape."]
        return [*changes, "bodies:", f"  - mesh: {{{files}}}"]
    margin = 0.01 * np.linalg.norm(np.ptp(points, axis=0))
    low, high = (", ".join(f"{x:.6g}" for x in corner) for corner in (points.min(0) - margin, points.max(0) + margin))
    return ["# It changes its shape and is not closed: a cloth whose nodes in the box, here all, go where the files have them.", "cloth:",
            f"  - mesh: {{file: {first}}}", f"    pin: [{{box: {{min: [{low}], max: [{high}]}}, {files}}}]"]


def import_mesh(options):
    stage = Usd.Stage.Open(str(options.file))
    mesh = MovingMesh(stage, find_mesh(stage, options.file, options.prim), options.file)
    mesh.check_faces()
    rate = stage.GetTimeCodesPerSecond()
    fps = options.fps or rate
    codes = sampled_codes(mesh, rate, fps)
    name = Tf.MakeValidIdentifier(mesh.mesh.GetPrim().GetName())
    points, off, digits = write_files(mesh, codes, options.folder, name)
    files = "1 file" if len(codes) == 1 else f"{len(codes)} files at {fps:.6g} a second, {(len(codes) - 1) / fps:.6g} s"
    print(f"{options.folder}: {files}, {len(points)} points, {len(mesh.triangles)} triangles of {mesh.mesh.GetPath()}")
    if mesh.mesh.GetSubdivisionSchemeAttr().Get() != UsdGeom.Tokens.none:
        print("warning: the mesh is a cage to be subdivided; its own faces were written", file=sys.stderr)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        print("gravity: [0, 0, -9.81]  # the stage says that z is up")
    print("\n".join(scene_lines(options.folder, name, digits, len(codes), fps, points, off, is_closed(np.asarray(mesh.triangles)))))


def main():
    options = parse_arguments()
    if not options.file.is_file():
        fail(f"{options.file}: no such file")
    try:
        import_mesh(options)
    except Tf.ErrorException:
        fail(f"{options.file}: is not a USD file that can be read")
    except OSError as error:
        fail(f"{error.filename or options.folder}: cannot be written: {error.strerror}")


if __name__ == "__main__":
    main()

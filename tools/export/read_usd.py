"""Writes a mesh of a USD file as PLY files that a scene's `sequence` reads. `drench import FILE` starts it; `tools/setup export`
makes the Python that it needs, with usd-core and numpy."""

import argparse
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))

from refusal import fail, fail_without

try:
    import numpy as np
    from pxr import Sdf, Tf, Usd, UsdGeom
except ImportError as error:
    fail_without(error.name)

from mesh_files import MeshFiles, add_options, named, number_of_files, told, triangulate


def parse_arguments():
    parser = argparse.ArgumentParser(prog="read_usd.py", description=__doc__)
    return add_options(parser, "the mesh, or an object that contains only this mesh")


def find_mesh(stage, file, prim):
    """The one mesh at or below `prim`, or of the whole stage."""
    root = stage.GetPseudoRoot()
    if prim is not None:
        root = stage.GetPrimAtPath(prim) if Sdf.Path.IsValidPathString(prim) else None
    everything = [p.GetPath() for p in stage.Traverse() if p.IsA(UsdGeom.Mesh)]
    if not everything:
        fail(f"{file}: holds no mesh")
    if not root:
        fail(f"{file}: --prim: unknown mesh {prim}; the meshes are {named(everything)}")
    meshes = [p for p in Usd.PrimRange(root) if p.IsA(UsdGeom.Mesh)]
    if not meshes:
        fail(f"{file}: --prim: {prim} is not a mesh; the meshes are {named(everything)}")
    if len(meshes) > 1:
        fail(f"{file}: holds {len(meshes)} meshes: choose one with --prim: {named([p.GetPath() for p in meshes])}")
    return UsdGeom.Mesh(meshes[0])


class MovingMesh:
    """Points in metres, y up, and triangles, the same at all times."""

    def __init__(self, stage, mesh, file):
        self.stage, self.mesh, self.file = stage, mesh, file
        self.first_code = stage.GetStartTimeCode() if stage.HasAuthoredTimeCodeRange() else 0.0
        self.faces = self._faces(self._own_codes(mesh.GetPointsAttr())[:1] or [self.first_code])
        if len(self.faces[0]) == 0:
            fail(f"{file}: {mesh.GetPath()} has no faces")
        corners = self.faces[1]
        points = np.asarray(mesh.GetPointsAttr().Get((self._own_codes(mesh.GetPointsAttr())[:1] or [self.first_code])[0]) or [],
                            np.float64).reshape(-1, 3)
        if len(corners) != self.faces[0].sum() or corners.min() < 0 or corners.max() >= len(points):
            fail(f"{file}: {mesh.GetPath()} has faces that name points it does not have")
        self.holes = np.isin(np.arange(len(self.faces[0])), mesh.GetHoleIndicesAttr().Get() or [])
        if self.holes.all():
            fail(f"{file}: {mesh.GetPath()} has no faces but holes (holeIndices)")
        triangles = triangulate(self.faces[0][~self.holes], corners[~np.repeat(self.holes, self.faces[0])], points)
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
        if UsdGeom.GetStageUpAxis(self.stage) == UsdGeom.Tokens.z:
            points = np.stack([points[:, 0], points[:, 2], -points[:, 1]], 1)
        if not np.isfinite(points).all():
            fail(f"{self.file}: {self.mesh.GetPath()} has points that are not finite at time code {code:g}")
        return points


def sampled_codes(mesh, rate, fps):
    span = mesh.moves()
    if span is None:
        return [mesh.first_code]
    first = mesh.stage.GetStartTimeCode() if mesh.stage.HasAuthoredTimeCodeRange() else span[0]
    last = mesh.stage.GetEndTimeCode() if mesh.stage.HasAuthoredTimeCodeRange() else span[1]
    return [first + k * rate / fps for k in range(number_of_files(mesh.file, (last - first) / rate, fps))]


def import_mesh(options):
    stage = Usd.Stage.Open(str(options.file))
    mesh = MovingMesh(stage, find_mesh(stage, options.file, options.prim), options.file)
    mesh.check_faces()
    rate = stage.GetTimeCodesPerSecond()
    fps = options.fps or rate
    codes = sampled_codes(mesh, rate, fps)
    name = Tf.MakeValidIdentifier(mesh.mesh.GetPrim().GetName())
    files = MeshFiles(options.folder, name, f"{options.file}: {mesh.mesh.GetPath()}", mesh.triangles, codes, mesh.points,
                      lambda code: f"time code {code:g}")
    if mesh.mesh.GetSubdivisionSchemeAttr().Get() != UsdGeom.Tokens.none:
        print("warning: the mesh is a cage to be subdivided; its own faces were written", file=sys.stderr)
    if mesh.holes.any():
        print(f"warning: {mesh.holes.sum()} faces are holes (holeIndices) and were left out", file=sys.stderr)
    if not UsdGeom.StageHasAuthoredMetersPerUnit(stage):
        print("warning: the file has no metersPerUnit: lengths were read in USD's default, 0.01 m; correct them with scale in the scene",
              file=sys.stderr)
    if options.first:
        print("\n".join(files.names(fps)))
        return
    print(told(files, fps, mesh.triangles, mesh.mesh.GetPath()))
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z:
        print("# The USD file declares z as up; the files are rotated to y up.")
    print("\n".join(files.scene_lines(fps)))


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

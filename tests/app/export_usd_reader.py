"""export_usd_reader.py FILE CODE...: what usd-core finds in a USD file at these time codes, as JSON; for export_test.py."""

import json
import sys

from pxr import Usd, UsdGeom, UsdShade


def numbers(value):
    return [] if value is None else [list(v) if hasattr(v, "__len__") else v for v in value]


def point_based(prim, code, cache):
    to_world = cache.GetLocalToWorldTransform(prim)
    points = UsdGeom.PointBased(prim)
    found = {"points": [list(to_world.Transform(p)) for p in points.GetPointsAttr().Get(code) or []],
             "velocity": numbers(points.GetVelocitiesAttr().Get(code)),
             "extent": numbers(points.GetExtentAttr().Get(code)),
             "purpose": UsdGeom.Imageable(prim).ComputePurpose()}
    if prim.IsA(UsdGeom.Points):
        found["ids"] = numbers(UsdGeom.Points(prim).GetIdsAttr().Get(code))
        found["widths"] = numbers(UsdGeom.Points(prim).GetWidthsAttr().Get(code))
    else:
        mesh = UsdGeom.Mesh(prim)
        found["corners"] = numbers(mesh.GetFaceVertexIndicesAttr().Get(code))
        found["counts"] = numbers(mesh.GetFaceVertexCountsAttr().Get(code))
        found["normals"] = numbers(mesh.GetNormalsAttr().Get(code))
    for variable in UsdGeom.PrimvarsAPI(prim).GetPrimvars():
        found["primvar:" + variable.GetPrimvarName()] = numbers(variable.Get(code))
        found["interpolation:" + variable.GetPrimvarName()] = str(variable.GetInterpolation())
    return found


def material_of(prim):
    """{input: value, or the primvar that it is read from} of the surface that is bound."""
    material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()
    if not material:
        return {}
    surface, _, _ = material.ComputeSurfaceSource()
    inputs = {}
    for to in surface.GetInputs():
        source = to.GetConnectedSources()[0]
        name = to.GetBaseName()
        if source:
            inputs[name] = UsdShade.Shader(source[0].source.GetPrim()).GetInput("varname").Get()
        else:
            value = to.Get()
            inputs[name] = list(value) if hasattr(value, "__len__") else value
    return inputs


def main():
    stage = Usd.Stage.Open(sys.argv[1])
    found = {"rate": stage.GetTimeCodesPerSecond(), "up": str(UsdGeom.GetStageUpAxis(stage)),
             "metres": UsdGeom.GetStageMetersPerUnit(stage), "root": str(stage.GetDefaultPrim().GetPath()),
             "start": stage.GetStartTimeCode(), "end": stage.GetEndTimeCode(), "materials": {}, "frames": []}
    for code in map(float, sys.argv[2:]):
        cache = UsdGeom.XformCache(code)
        prims = [prim for prim in stage.Traverse() if prim.IsA(UsdGeom.PointBased)]
        found["frames"].append({str(prim.GetPath()): point_based(prim, code, cache) for prim in prims})
        found["materials"] = {str(prim.GetPath()): material_of(prim) for prim in prims}
    json.dump(found, sys.stdout)


main()

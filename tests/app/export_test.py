#!/usr/bin/python3 -I
"""export_test.py SOURCE BUILD PART: what `drench export` writes of a small run is what its frames hold, as VTK reads them.

particles  BGEO and PLY, read back here; --fps; refusals; frames without particles, which meshio and splashsurf read
           too where python3 and PATH have them
usd        read back by usd-core, and a mesh of it imported; needs tools/setup export
blender    read back by Blender; needs tools/setup blender besides
Exit code 77, skipped, without what a part needs."""

import json
import math
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from support import BINARY, SOURCE, drench, environment, expect, rejects, skip  # noqa: E402

PART = sys.argv[3]
ENVIRONMENTS = {"usd": ("export", SOURCE / ".deps/export-venv/bin/python"),
                "blender": ("blender", SOURCE / ".deps/blender-venv/bin/python")}
SCENE = """drench: 1
time: {step: 0.002, end: 0.2, mode: cfl}
domain: {min: [-0.5, -0.2, -0.5], max: [0.5, 0.8, 0.5]}
output: {every: 0.02, surface: true}
fluid:
  spacing: 0.04
  sources: [{block: {min: [-0.24, 0, -0.24], max: [0.24, 0.16, 0.24]}}]
cloth:
  - name: "left sheet"
    mesh: {grid: {size: [0.2, 0.3], nodes: [9, 13]}}
    place: {position: [-0.15, 0.5, 0]}
    initial_saturation: [{box: {min: [-1, -1, -1], max: [-0.1, 1, 1]}, value: 0.8}]
    porous: {}
    pin: [{corners: true}]
  - name: sheet2
    mesh: {grid: {size: [0.2, 0.3], nodes: [9, 13]}}
    place: {position: [0.15, 0.4, 0]}
bodies:
  - box: {min: [-0.25, 0, -0.25], max: [0.25, 0.6, 0.25], inside: true}
  - sphere: {center: [0.1, 0.26, 0], radius: 0.09, dynamic: true, density: 400}
  - box: {min: [0, 0.3, 0.1], max: [0.2, 0.36, 0.16], spin: {axis: [0, 1, 0], degrees_per_second: 720}}
  - plane: {point: [0, -0.15, 0], normal: [0, 1, 0], spin: {axis: [0, 0, 1], degrees_per_second: 60}}
"""
FRAMES = 11
LOOKED_AT = (0, 5, 10)


def read_vtu(path):
    """{field: values}, with points, cells of corners, and cell fields as "cell:NAME"."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    found = {"points": [grid.GetPoint(i) for i in range(grid.GetNumberOfPoints())]}
    cells = map(grid.GetCell, range(grid.GetNumberOfCells()))
    found["cells"] = [[cell.GetPointId(k) for k in range(cell.GetNumberOfPoints())] for cell in cells]
    for prefix, fields in (("", grid.GetPointData()), ("cell:", grid.GetCellData())):
        for a in range(fields.GetNumberOfArrays()):
            array = fields.GetArray(a)
            rows = [array.GetTuple(i) for i in range(array.GetNumberOfTuples())]
            found[prefix + array.GetName()] = [r[0] if len(r) == 1 else r for r in rows]
    return found


def distance(a, b):
    """The largest difference of two lists of numbers or of rows."""
    if len(a) != len(b):
        return math.inf
    flat = [[x for row in rows for x in (row if hasattr(row, "__len__") else [row])] for rows in (a, b)]
    return max((abs(x - y) for x, y in zip(*flat)), default=0) if len(flat[0]) == len(flat[1]) else math.inf


def as_float(values):
    return [struct.unpack("f", struct.pack("f", x))[0] for x in values]


def read_bgeo(path):
    data, at = path.read_bytes(), 0

    def take(form):
        nonlocal at
        values = struct.unpack_from(">" + form, data, at)
        at += struct.calcsize(">" + form)
        return values

    expect(take("4sci") == (b"Bgeo", b"V", 5), f"{path}: is no classic BGEO")
    count, prims, point_groups, prim_groups, attributes, vertex, of_prims, of_all = take("8i")
    expect((prims, point_groups, prim_groups, vertex, of_prims, of_all) == (0,) * 6, f"{path}: holds more than points")
    names, form = [], "4f"
    for _ in range(attributes):
        name = take(f"{take('H')[0]}s")[0].decode()
        size, kind = take("Hi")
        expect(kind in (0, 1, 5) and (kind == 5) == (size == 3), f"{name} is of kind {kind}")
        take(f"{size}i")
        names.append((name, size))
        form += f"{size}{'i' if kind == 1 else 'f'}"
    found = {"points": [], **{name: [] for name, _ in names}}
    for _ in range(count):
        row = take(form)
        expect(row[3] == 1, "a point's fourth coordinate is not 1")
        found["points"].append(row[:3])
        k = 4
        for name, size in names:
            found[name].append(row[k] if size == 1 else row[k:k + size])
            k += size
    expect(data[at:] == b"\x00\xff", f"{path}: does not end as it should")
    return found


def read_ply(path):
    head, _, body = path.read_bytes().partition(b"end_header\n")
    lines = head.decode().splitlines()
    expect(lines[:2] == ["ply", "format binary_little_endian 1.0"], f"{path}: is no binary PLY")
    count = int(next(line for line in lines if line.startswith("element vertex")).split()[2])
    names = [line.split()[1:] for line in lines if line.startswith("property")]
    form = "<" + "".join({"float": "f", "double": "d", "int": "i"}[kind] for kind, _ in names)
    expect(len(body) == count * struct.calcsize(form), f"{path}: {len(body)} bytes of {count} particles")
    rows = list(struct.iter_unpack(form, body))
    return {name: [row[k] for row in rows] for k, (_, name) in enumerate(names)}


def check_particles(run, folder):
    said = drench("export", run, "--to", "bgeo").stdout + drench("export", run, "--to", "ply").stdout
    expect(said.count(f"{FRAMES} files") == 2, said)
    for k in LOOKED_AT:
        vtu = read_vtu(run / f"frames/fluid_{k:06}.vtu")
        bgeo, ply = read_bgeo(run / f"bgeo/fluid_{k:06}.bgeo"), read_ply(run / f"ply/fluid_{k:06}.ply")
        expect(len(vtu["points"]) > 500, "too few particles to look at")
        expect(set(bgeo) == {"points", "v", "pscale", "density", "pressure", "mass", "id", "age"}, str(set(bgeo)))
        for name, field in (("points", "points"), ("v", "velocity"), ("pscale", "radius"), ("density", "density"),
                            ("pressure", "pressure"), ("id", "id"), ("age", "age")):
            expect(distance(bgeo[name], vtu[field]) == 0, f"BGEO: {name} of frame {k} is not the run's")
        expect(distance(bgeo["mass"], as_float(vtu["mass"])) == 0, "BGEO: mass")
        for names, field in (("xyz", "points"), (("vx", "vy", "vz"), "velocity")):
            expect(distance(list(zip(*(ply[n] for n in names))), vtu[field]) == 0, f"PLY: {names} of frame {k}")
        for name in ("radius", "density", "pressure", "mass", "id", "age"):
            expect(distance(ply[name], vtu[name]) == 0, f"PLY: {name} of frame {k}")
    check_rates(run, folder)
    check_rejections(run, folder)
    check_empty_frames(folder)


EMPTY_SCENE = """drench: 1
time: {step: 0.002, end: 0.02}
domain: {min: [-1, -1, -1], max: [1, 1, 1]}
output: {every: 0.01, surface: true}
fluid: {spacing: 0.02, sources: [{jet: {center: [0, 0.5, 0], radius: 0.05, velocity: [0, -1, 0], start: 0.005}}]}
bodies: [{sphere: {center: [0, 0, 0], radius: 0.1}}]
"""


def check_empty_frames(folder):
    """A frame without particles, and without a surface, is a frame to every reader that the pages name."""
    (folder / "empty.yaml").write_text(EMPTY_SCENE)
    run = folder / "empty"
    drench("run", folder / "empty.yaml", "-o", run, "--quiet")
    empty, full = (read_vtu(run / f"frames/fluid_{k:06}.vtu") for k in (0, 2))
    expect(empty["points"] == [] and len(full["points"]) > 10, f"{len(empty['points'])}, {len(full['points'])} points")
    expect(set(empty) == set(full) and all(values == [] for name, values in empty.items() if name != "cells"),
           f"fields of the empty frame: {empty}")
    expect(read_vtu(run / "frames/surface_000000.vtu")["points"] == [], "there is a surface without particles")
    for ending, read in (("bgeo", read_bgeo), ("ply", read_ply)):
        drench("export", run, "--to", ending)
        values = read(run / f"{ending}/fluid_000000.{ending}")
        expect(values and not any(values.values()), f"{ending} of an empty frame: {values}")
    check_with_meshio(run)
    check_with_splashsurf(run, folder)


def check_with_meshio(run):
    code = "import meshio, sys; frame = meshio.read(sys.argv[1]); print(len(frame.points), len(frame.point_data['velocity']))"
    if subprocess.run(["python3", "-c", "import meshio"], capture_output=True).returncode:
        return print("no meshio here: not tried")
    for name in ("fluid", "surface"):
        read = subprocess.run(["python3", "-c", code, str(run / f"frames/{name}_000000.vtu")], capture_output=True, text=True)
        expect(read.returncode == 0 and read.stdout.endswith("0 0\n"), f"meshio: {read.stdout}{read.stderr}")
    return None


def check_with_splashsurf(run, folder):
    if not shutil.which("pysplashsurf"):
        return print("no pysplashsurf here: not tried")
    words = ["-r", "0.01", "-l", "2.0", "-c", "0.5", "-t", "0.6", "-a", "velocity", "--output-dir", str(folder / "surfaces")]
    made = subprocess.run(["pysplashsurf", "reconstruct", str(run / "frames/fluid_{}.vtu"), *words], capture_output=True, text=True)
    expect(made.returncode == 0 and len(list((folder / "surfaces").iterdir())) == 3, f"splashsurf: {made.stdout}{made.stderr}")
    return None


def check_rates(run, folder):
    every_second = drench("export", run, "--to", "bgeo", "--fps", 25)
    expect(not every_second.stderr, every_second.stderr)
    kept = sorted(path.name for path in (run / "bgeo").iterdir())
    expect(kept == [f"fluid_{k:06}.bgeo" for k in range(6)], f"25 a second: {kept}")  # those of the first export are gone
    vtu = read_vtu(run / "frames/fluid_000004.vtu")
    expect(distance(read_bgeo(run / "bgeo/fluid_000002.bgeo")["points"], vtu["points"]) == 0, "picture 2 is not frame 4")
    for ending, kept in (("bgeo", 6), ("ply", 3)):  # files of something else stay, and those that it has written go
        other = folder / f"other_{ending}"
        drench("export", run, "--to", ending, "-o", other)
        drench("export", run, "--to", ending, "--fps", 25 if kept == 6 else 10, "-o", other)
        expect(len(list(other.iterdir())) == kept, f"{ending}: earlier files")
        (other / f"fluid_000400.{ending}").write_text("of something else")
        (other / f"fluid_4.{ending}").write_text("of something else")
        rejects(f"fluid_000400.{ending}: is not of drench export", "export", run, "--to", ending, "-o", other)
        expect(len(list(other.iterdir())) == kept + 2, f"{ending}: something was removed")
    for fps, pictures in ((24, 5), (100, 21)):
        other = drench("export", run, "--to", "ply", "--fps", fps, "-o", folder / f"ply{fps}")
        expect("warning: --fps" in other.stderr and "fit 50, 25, 10 or 5" in other.stderr, other.stderr)
        expect(len(list((folder / f"ply{fps}").iterdir())) == pictures, f"{fps} a second")


def check_rejections(run, folder):
    rejects("no such folder", "export", folder / "nowhere", "--to", "ply")
    rejects("holds no frames", "export", folder, "--to", "usd")
    rejects("holds no particles", "export", folder, "--to", "bgeo")
    rejects("not in {usd,bgeo,ply}", "export", run, "--to", "abc")
    rejects("--to is required", "export", run)
    rejects("is not a rate", "export", run, "--to", "ply", "--fps", 0)
    rejects("is not a folder", "export", run, "--to", "ply", "-o", run / "stats.csv")
    rejects("tools/setup export", "export", run, "--to", "usd", env=environment(DRENCH_PYTHON=folder / "no_python"))
    frame = run / "frames/fluid_000003.vtu"
    whole = frame.read_bytes()
    frame.write_bytes(whole[:len(whole) // 2])
    rejects("fluid_000003.vtu: is not a complete frame", "export", run, "--to", "ply")
    frame.unlink()
    rejects("fluid_000003.vtu: no such file", "export", run, "--to", "bgeo")
    frame.write_bytes(whole)


def near_in_place(found, points, what, tolerance=1e-6):
    off = distance(found, points)
    expect(off <= tolerance, f"{what}: {len(found)} of {len(points)} points, up to {off} m off")


def parts_of_cloth(vtu):
    """The node numbers of each cloth."""
    owner = {}
    for cell, cloth in zip(vtu["cells"], vtu["cell:cloth"]):
        owner.setdefault(int(cloth), set()).update(cell)
    return [sorted(owner[cloth]) for cloth in sorted(owner)]


def parts_of_bodies(run, k):
    parts = {}
    for name in ("static", f"{k:06}"):
        if not (path := run / f"frames/bodies_{name}.vtu").exists():  # no body stands still
            continue
        vtu = read_vtu(path)
        for cell, body in zip(vtu["cells"], vtu["cell:body"]):
            parts.setdefault(int(body), {}).update({i: vtu["points"][i] for i in cell})
    return {body: [points[i] for i in sorted(points)] for body, points in parts.items()}


def check_usd_frame(run, k, prims):
    fluid, surface, cloth = (read_vtu(run / f"frames/{name}_{k:06}.vtu") for name in ("fluid", "surface", "cloth"))
    liquid, skin = prims["/World/liquid"], prims["/World/surface"]
    near_in_place(liquid["points"], fluid["points"], "liquid")
    expect(distance(liquid["velocity"], fluid["velocity"]) == 0, "velocity of the liquid")
    expect(distance(liquid["ids"], fluid["id"]) == 0, "ids of the liquid")
    expect(distance(liquid["widths"], [2 * r for r in fluid["radius"]]) < 1e-9, "widths of the liquid")
    near_in_place(skin["points"], surface["points"], "surface")
    expect(skin["corners"] == [i for cell in surface["cells"] for i in cell], "triangles of the surface")
    expect(skin["counts"] == [3] * len(surface["cells"]), "corners of the surface's triangles")
    expect(distance(skin["normals"], surface["normal"]) == 0, "normals of the surface")
    for name, nodes in zip(("left_sheet", "sheet2"), parts_of_cloth(cloth)):
        sheet = prims[f"/World/cloth/{name}"]
        near_in_place(sheet["points"], [cloth["points"][i] for i in nodes], name)
        saturation = [cloth["saturation"][i] for i in nodes]
        expect(distance(sheet["primvar:saturation"], saturation) == 0, f"saturation of {name}")
        expect(distance(sheet["velocity"], [cloth["velocity"][i] for i in nodes]) == 0, f"velocity of {name}")
        low, high = ([f(p[a] for p in sheet["points"]) for a in range(3)] for f in (min, max))
        expect(distance(sheet["extent"], [low, high]) < 1e-6, f"extent of {name}")
        for s, colour, roughness in zip(saturation, sheet["primvar:displayColor"], sheet["primvar:roughness"]):
            wet = min(1, max(0, s))
            expect(abs(colour[0] - 0.8 * (1 - 0.7 * wet)) < 1e-5, "wet cloth is not darker")
            expect(abs(roughness - (0.9 - 0.6 * wet)) < 1e-5, "wet cloth is not glossier")
    bodies = parts_of_bodies(run, k)
    expect(sorted(bodies) == [0, 1, 2, 3], f"bodies {sorted(bodies)}")
    for body, points in bodies.items():
        near_in_place(prims[f"/World/bodies/body_{body}"]["points"], points, f"body {body} of frame {k}", 3e-6)


def check_usd(run, folder):
    said = drench("export", run, "--to", "usd")
    expect("11 frames at 50 per second" in said.stdout and not said.stderr, said.stdout + said.stderr)
    file = run / "run.usdc"
    reader = [str(ENVIRONMENTS["usd"][1]), str(SOURCE / "tests/app/export_usd_reader.py")]
    stage = json.loads(subprocess.run([*reader, str(file), *map(str, LOOKED_AT)], capture_output=True, check=True).stdout)
    expect({key: stage[key] for key in ("rate", "up", "metres", "root", "start", "end")} ==
           {"rate": 50, "up": "Y", "metres": 1, "root": "/World", "start": 0, "end": 10}, str(stage)[:300])
    for k, prims in zip(LOOKED_AT, stage["frames"]):
        check_usd_frame(run, k, prims)
    counts = {len(prims["/World/surface"]["points"]) for prims in stage["frames"]}
    expect(len(counts) > 1, "the surface has the same points in all frames: nothing is tried")
    first, last = (stage["frames"][k]["/World/cloth/left_sheet"]["primvar:saturation"] for k in (0, -1))
    expect(distance(first, last) > 1e-3, "saturation is the same in all frames: nothing is tried")
    purposes = {path: prim["purpose"] for path, prim in stage["frames"][0].items()}
    expect(purposes["/World/liquid"] == "proxy" and purposes["/World/surface"] == "render" and
           purposes["/World/bodies/body_0"] == "guide" and purposes["/World/bodies/body_1"] == "default", str(purposes))
    cloth = stage["materials"]["/World/cloth/left_sheet"]
    expect((cloth["diffuseColor"], cloth["roughness"]) == ("displayColor", "roughness"), str(cloth))
    check_usd_variants(run, folder, reader)
    check_texture(folder, reader)
    check_import(run, folder)


# Two quads side by side: a seam of the texture runs along x = 0, where corners of one point differ.
TEXTURED_MESH = """v -0.1 0 0\nv 0 0 0\nv 0.1 0 0\nv -0.1 0 0.1\nv 0 0 0.1\nv 0.1 0 0.1
vt -0.1 0\nvt 0 0\nvt 0 0.1\nvt -0.1 0.1\nvt 5 0\nvt 5.1 0\nvt 5.1 0.1\nvt 5 0.1
f 4/4 5/3 2/2 1/1\nf 5/8 6/7 3/6 2/5
"""
TEXTURED_SCENE = """drench: 1
time: {step: 0.002, end: 0.004}
output: {every: 0.002}
cloth:
  - {name: grid, mesh: {grid: {size: [0.1, 0.1], nodes: [3, 3]}}, place: {position: [0, 1, 0]}}
  - {name: flag, mesh: {file: flag.obj, scale: 2}}
"""


def check_texture(folder, reader):
    """The mesh file's texture coordinates, at each corner of each triangle; none of a grid, or of a file that is another one by now."""
    (folder / "flag.obj").write_text(TEXTURED_MESH)
    (folder / "textured.yaml").write_text(TEXTURED_SCENE)
    run, file = folder / "textured", folder / "textured.usda"
    drench("run", folder / "textured.yaml", "-o", run, "--quiet")

    def cloths():
        said = drench("export", run, "--to", "usd", "-o", file).stderr
        stage = json.loads(subprocess.run([*reader, str(file), "0"], capture_output=True, check=True).stdout)
        return [stage["frames"][0][f"/World/cloth/{name}"] for name in ("flag", "grid")], said

    (flag, grid), said = cloths()
    expect(not said and "primvar:st" not in grid and flag["interpolation:st"] == "faceVarying", said)
    corners = [flag["points"][i] for i in flag["corners"]]
    expect(len(corners) == 12 and len(flag["primvar:st"]) == 12, str(flag["primvar:st"]))
    for t in range(4):
        right = sum(p[0] for p in corners[3 * t:3 * t + 3]) > 0
        wanted = [[p[0] / 2 + (5 if right else 0), p[2] / 2] for p in corners[3 * t:3 * t + 3]]
        expect(distance(flag["primvar:st"][3 * t:3 * t + 3], wanted) < 1e-4, f"triangle {t}: {flag['primvar:st']}, not {wanted}")
    (folder / "flag.obj").write_text(TEXTURED_MESH + "f 1/1 2/2 5/3\n")
    (flag, _), said = cloths()
    expect("primvar:st" not in flag and said.count("warning") == 1 and "cloth flag" in said, said)
    (folder / "flag.obj").unlink()
    (flag, _), said = cloths()
    expect("primvar:st" not in flag and said.count("warning") == 1 and "flag.obj" in said, said)


def check_wet_maps(run, folder, reader):
    """The film on the ball's points is the sum over all particles near them, and contact lasts as long as frames show it."""
    drench("export", run, "--to", "usd", "--wet-maps", "-o", folder / "wet.usdc")
    codes = [str(k) for k in range(FRAMES)]
    frames = json.loads(subprocess.run([*reader, str(folder / "wet.usdc"), *codes], capture_output=True, check=True).stdout)
    contact = 0
    for k, prims in enumerate(frames["frames"]):
        ball, fluid = prims["/World/bodies/body_1"], read_vtu(run / f"frames/fluid_{k:06}.vtu")
        reach = 3 * max(fluid["radius"])
        for n in range(0, len(ball["points"]), 53):
            near = [r for p, r in zip(fluid["points"], fluid["radius"]) if math.dist(p, ball["points"][n]) < reach]
            film = sum((2 * r) ** 3 for r in near) / (math.pi * reach**2)
            expect(abs(ball["primvar:film"][n] - film) < 1e-6 + 1e-5 * film, f"film {ball['primvar:film'][n]}, not {film}")
            if n == 53 * 7:
                contact += 0.02 if near and k > 0 else 0
                expect(abs(ball["primvar:contact_time"][n] - contact) < 1e-6, f"contact time of frame {k}")
        expect(ball["interpolation:film"] == "vertex", "wet maps are of the points")
    expect(max(ball["primvar:contact_time"]) > 0.1, "the ball floats and is not wet")
    rejects("applies only to --to usd", "export", run, "--to", "ply", "--wet-maps")


def read_exr(path):
    """{channel: rows of floats} of a file with blocks of 16 rows, compressed as ZIP or not, by the format's description."""
    data = path.read_bytes()
    expect(struct.unpack_from("<ii", data) == (20000630, 2), "an OpenEXR file of one part")
    at, header = 8, {}
    while data[at]:
        name, kind = data[at:].split(b"\0", 2)[:2]
        at += len(name) + len(kind) + 2
        size = struct.unpack_from("<i", data, at)[0]
        header[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    listed = header["channels"]  # one letter and 17 bytes each
    names = [listed[k:k + 1].decode() for k in range(0, len(listed) - 1, 18)]
    x0, y0, x1, y1 = struct.unpack("<iiii", header["dataWindow"])
    width, height, rows = x1 - x0 + 1, y1 - y0 + 1, {name: [] for name in names}
    for block in struct.unpack_from(f"<{(height + 15) // 16}Q", data, at + 1):
        first, size = struct.unpack_from("<ii", data, block)
        lines = min(16, height - first)
        raw = data[block + 8:block + 8 + size]
        if size < 4 * len(names) * width * lines:
            mixed = bytearray(zlib.decompress(raw))
            for k in range(1, len(mixed)):
                mixed[k] = (mixed[k - 1] + mixed[k] - 128) % 256
            half = (len(mixed) + 1) // 2
            raw = bytes(mixed[k // 2 + (half if k % 2 else 0)] for k in range(len(mixed)))
        values = struct.unpack(f"<{len(raw) // 4}f", raw)
        for line in range(lines):
            for c, name in enumerate(names):
                rows[name].append(values[(line * len(names) + c) * width:][:width])
    return rows


# A pyramid in a pool: its four sides lie in the quarters of the texture, but for one that is in the next tile, and its base has
# none of its own.
PYRAMID = "v -0.05 0 -0.05\nv 0.05 0 -0.05\nv 0.05 0 0.05\nv -0.05 0 0.05\nv 0 0.1 0\n" + "".join(
    f"vt {u} {v}\nvt {u + 0.4} {v}\nvt {u + 0.2} {v + 0.4}\n" for u, v in ((0.05, 0.05), (0.55, 0.05), (0.05, 0.55), (1.55, 0.55))) + (
    "vt 0.48 0.48\nf 1/13 2/13 3/13 4/13\nf 2/1 1/2 5/3\nf 3/4 2/5 5/6\nf 4/7 3/8 5/9\nf 1/10 4/11 5/12\n")
PYRAMID_SCENE = """drench: 1
time: {step: 0.002, end: 0.06}
output: {every: 0.02}
fluid: {spacing: 0.02, sources: [{block: {min: [-0.12, 0, -0.12], max: [0.12, 0.08, 0.12]}}]}
bodies:
  - box: {min: [-0.12, 0, -0.12], max: [0.12, 0.4, 0.12], inside: true}
  - mesh: {file: pyramid.obj, velocity: [0, 0.5, 0]}
"""


def check_wet_textures(folder, reader):
    """A pixel shows what the map's values at the corners of its triangle give there, and the islands have borders."""
    (folder / "pyramid.obj").write_text(PYRAMID)
    (folder / "pyramid.yaml").write_text(PYRAMID_SCENE)
    run, file, size = folder / "pyramid", folder / "pyramid.usdc", 64
    drench("run", folder / "pyramid.yaml", "-o", run, "--quiet")
    expect(not drench("export", run, "--to", "usd", "-o", file).stderr, "a warning")
    plain = json.loads(subprocess.run([*reader, str(file), "3"], capture_output=True, check=True).stdout)["frames"][0]
    made = drench("export", run, "--to", "usd", "--wet-textures", size, "-o", file)
    expect(made.stderr.count("warning") == 1 and "1 triangles have texture coordinates outside" in made.stderr, made.stderr)
    expect("4 images of 64 × 64 pixels" in made.stdout, made.stdout)
    prim = json.loads(subprocess.run([*reader, str(file), "3"], capture_output=True, check=True).stdout)["frames"][0]
    body = prim["/World/bodies/body_1"]
    expect(body["primvar:st"] == plain["/World/bodies/body_1"]["primvar:st"], "texture coordinates without wet textures")
    image = read_exr(folder / "pyramid_wet/body_1.0003.exr")
    expect(len(image["R"]) == len(image["R"][0]) == size, "a square")
    expect(max(body["primvar:contact_time"]) > 0.03 and min(body["primvar:contact_time"]) < 0.03, str(body["primvar:contact_time"]))
    seen = 0
    for t in range(2, 5):  # the sides in the texture, after the base's two
        corner = body["corners"][3 * t:3 * t + 3]
        (ua, va), (ub, vb), (uc, vc) = body["primvar:st"][3 * t:3 * t + 3]
        area = (ub - ua) * (vc - va) - (uc - ua) * (vb - va)
        for y in range(size):
            for x in range(size):
                u, v = (x + 0.5) / size, 1 - (y + 0.5) / size
                b = ((u - ua) * (vc - va) - (uc - ua) * (v - va)) / area
                c = ((ub - ua) * (v - va) - (u - ua) * (vb - va)) / area
                if min(b, c, 1 - b - c) < 0.01:
                    continue
                seen += 1
                for channel, name in (("R", "contact_time"), ("G", "film")):
                    values = [body[f"primvar:{name}"][n] for n in corner]
                    wanted = (1 - b - c) * values[0] + b * values[1] + c * values[2]
                    expect(abs(image[channel][y][x] - wanted) < 1e-6, f"{name} at {x}, {y}: {image[channel][y][x]}, not {wanted}")
                expect(image["B"][y][x] == 1, "there is texture")
    expect(seen > 700, f"{seen} pixels")
    covered = sum(map(sum, image["B"]))
    expect(1.3 * seen < covered < 2.5 * seen, f"{covered} pixels with borders, {seen} without")
    expect(image["B"][10][50] == 0 and image["R"][10][50] == 0, "the side in the next tile is not shown")
    rejects("applies only to --to usd", "export", run, "--to", "ply", "--wet-textures", 64)
    rejects("--wet-textures", "export", run, "--to", "usd", "--wet-textures", 8)


def check_usd_variants(run, folder, reader):
    check_wet_textures(folder, reader)
    rejects("no body has a mesh file with texture coordinates", "export", run, "--to", "usd", "--wet-textures", 64)
    check_wet_maps(run, folder, reader)
    text = folder / "deeper/run.usda"
    other = drench("export", run, "--to", "usd", "--fps", 24, "-o", text)
    expect("warning: --fps" in other.stderr, other.stderr)
    stage = json.loads(subprocess.run([*reader, str(text), "4.8"], capture_output=True, check=True).stdout)
    expect(stage["rate"] == 24 and abs(stage["end"] - 4.8) < 1e-9, "24 a second")
    check_usd_frame(run, 10, stage["frames"][0])  # 0.2 s × 24
    scene, plain = run / "scene.yaml", (run / "scene.yaml").read_text()
    scene.write_text(plain.replace("gravity: [0, -9.81, 0]", "gravity: [0, 0, -9.81]"))
    drench("export", run, "--to", "usd", "-o", folder / "z.usdc")
    up = json.loads(subprocess.run([*reader, str(folder / "z.usdc"), "0"], capture_output=True, check=True).stdout)["up"]
    expect(up == "Z", f"{up} is up")
    scene.write_text(plain)
    rejects("must end in", "export", run, "--to", "usd", "-o", folder / "a.abc")
    frame = run / "frames/cloth_000002.vtu"
    whole = frame.read_bytes()
    frame.write_bytes(whole[:len(whole) // 2])
    rejects("cloth_000002.vtu", "export", run, "--to", "usd", "-o", folder / "half.usdc")
    frame.write_bytes(whole.replace(b"==eA", b"==AA"))
    rejects("cloth_000002.vtu", "export", run, "--to", "usd", "-o", folder / "half.usdc")
    frame.write_bytes(whole)
    expect(not (folder / "half.usdc").exists() and not list(folder.glob(".half*")), "a file that is not whole is left")


def read_mesh(path):
    """(points, triangles) of a binary PLY file as `drench import` writes it."""
    head, _, body = path.read_bytes().partition(b"end_header\n")
    points, faces = (int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element"))
    expect(len(body) == 12 * points + 13 * faces, f"{path}: {len(body)} bytes of {points} points and {faces} triangles")
    rows = list(struct.iter_unpack("<B3i", body[12 * points:]))
    expect({row[0] for row in rows} == {3}, f"{path}: not all faces are triangles")
    return list(struct.iter_unpack("<3f", body[:12 * points])), [row[1:] for row in rows]


def lines_of_scene(said):
    return said[said.index("\n") + 1:]


def check_import(run, folder):
    """Cloth and body of the run come back as files that are its frames, and the lines that are printed make a scene."""
    file = run / "run.usdc"
    sheet = folder / "sheet"
    said = drench("import", file, "--prim", "/World/cloth/left_sheet", "-o", sheet).stdout
    expect("11 files at 50 per second, 0.2 s, 117 points, 192 triangles" in said and "pin: " in said, said)
    names = sorted(path.name for path in sheet.iterdir())
    expect(names == [f"left_sheet_{k:04}.ply" for k in range(FRAMES)], str(names))
    for k in LOOKED_AT:
        cloth = read_vtu(run / f"frames/cloth_{k:06}.vtu")
        nodes = parts_of_cloth(cloth)[0]
        points, triangles = read_mesh(sheet / f"left_sheet_{k:04}.ply")
        near_in_place(points, [cloth["points"][i] for i in nodes], f"imported sheet of frame {k}")
        expect([list(t) for t in triangles] == [c for c, owner in zip(cloth["cells"], cloth["cell:cloth"]) if owner == 0],
               "triangles of the imported sheet")
    head = "drench: 1\ntime: {step: 0.002, end: 0.1}\n" \
           "fluid: {spacing: 0.04, sources: [{block: {min: [0.6, 0, 0.6], max: [0.8, 0.2, 0.8]}}]}\n"
    scene = folder / "imported.yaml"
    scene.write_text(head + lines_of_scene(said))
    expect("117 nodes, 117 pinned" in drench("check", scene).stdout, "the printed lines pin other nodes")
    drench("run", scene, "-o", folder / "imported", "--quiet", "--set", "output.every=0.02")
    for k in range(6):
        mine, theirs = (read_vtu(where / f"frames/cloth_{k:06}.vtu")["points"] for where in (folder / "imported", run))
        near_in_place(mine, theirs[:117], f"pinned sheet of frame {k}", 2e-5)
    check_import_body(run, folder, file, scene, head)
    check_import_refusals(folder, file)


def check_import_body(run, folder, file, scene, head):
    said = drench("import", file, "--prim", "/World/bodies/body_2", "--fps", 100, "-o", folder / "beam").stdout
    expect("21 files at 100 per second" in said and "changes its shape" in said, said)  # between its matrices
    scene.write_text(head + lines_of_scene(said))
    expect("1 deforming" in drench("check", scene).stdout, "the printed lines make no body that changes its shape")
    said = drench("import", file, "--prim", "/World/bodies/body_2", "-o", folder / "beam").stdout
    names = sorted(path.name for path in (folder / "beam").iterdir())
    expect(names == [f"body_2_{k:04}.ply" for k in range(FRAMES)], f"files of the longer import are left: {names}")
    scene.write_text(head + lines_of_scene(said))
    drench("run", scene, "-o", folder / "imported", "--quiet", "--overwrite", "--set", "output.every=0.02")
    for k in range(6):
        mine, theirs = (parts_of_bodies(where, k) for where in (folder / "imported", run))
        low_high = [[[f(p[a] for p in points) for a in range(3)] for f in (min, max)] for points in (mine[0], theirs[2])]
        expect(distance(*low_high) < 1e-5, f"beam of frame {k} spans {low_high}")
    still = drench("import", file, "--prim", "/World/bodies/body_0", "-o", folder / "still").stdout
    expect("1 file, " in still and "sequence" not in still, still)


def check_import_refusals(folder, file):
    rejects("holds 7 meshes: choose one with --prim: /World/surface", "import", file)
    rejects("unknown mesh /World/flag; the meshes are", "import", file, "--prim", "/World/flag")
    rejects("unknown mesh not a path", "import", file, "--prim", "not a path")
    rejects("/World/materials is not a mesh", "import", file, "--prim", "/World/materials")
    rejects("/World/surface has other faces at time code", "import", file, "--prim", "/World/surface")
    (folder / "text.usda").write_text("drench: 1\n")
    rejects("is not a USD file", "import", folder / "text.usda")
    (folder / "holes.usda").write_text("""#usda 1.0
def Mesh "sheet"
{
  int[] faceVertexCounts = [4, 4]
  int[] faceVertexIndices = [0, 1, 4, 3, 1, 2, 5, 4]
  int[] holeIndices = [0]
  point3f[] points = [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (1, 1, 0), (2, 1, 0)]
  uniform token subdivisionScheme = "none"
}
""")
    holes = drench("import", folder / "holes.usda", "-o", folder / "holes")
    expect("4 points, 2 triangles of /sheet" in holes.stdout, holes.stdout)
    expect("1 faces are holes" in holes.stderr and "no metersPerUnit" in holes.stderr, holes.stderr)
    rejects("tools/setup export", "import", file, env=environment(DRENCH_PYTHON=folder / "no_python"))


def check_blender(run, _):
    drench("export", run, "--to", "usd")
    reader = [str(ENVIRONMENTS["blender"][1]), str(SOURCE / "tests/app/export_blender_reader.py"), str(run / "run.usdc")]
    ran = subprocess.run([*reader, *map(str, LOOKED_AT)], capture_output=True, text=True)
    lines = [line for line in ran.stdout.splitlines() if line.startswith("JSON")]
    expect(ran.returncode == 0 and lines, ran.stdout[-500:] + ran.stderr[-500:])
    read = json.loads(lines[0][4:])
    expect(read["links"]["cloth"] == ["displayColor -> Base Color", "roughness -> Roughness"], str(read["links"]))
    counts = set()
    for k, things in zip(LOOKED_AT, read["frames"]):
        fluid, surface, cloth = (read_vtu(run / f"frames/{name}_{k:06}.vtu") for name in ("fluid", "surface", "cloth"))
        near_in_place(things["liquid"]["points"], fluid["points"], f"liquid of frame {k}")
        expect(distance(things["liquid"]["radius"], fluid["radius"]) < 1e-8, "radius of the liquid")
        near_in_place(things["surface"]["points"], surface["points"], f"surface of frame {k}")
        expect(things["surface"]["triangles"] == len(surface["cells"]), f"triangles of frame {k}")
        counts.add(len(surface["points"]))
        for name, nodes in zip(("left_sheet", "sheet2"), parts_of_cloth(cloth)):
            near_in_place(things[name]["points"], [cloth["points"][i] for i in nodes], f"{name} of frame {k}")
            expect(distance(things[name]["saturation"], [cloth["saturation"][i] for i in nodes]) == 0, f"saturation of {name}")
        for body, points in parts_of_bodies(run, k).items():
            near_in_place(things[f"body_{body}"]["points"], points, f"body {body} of frame {k}", 3e-6)
    expect(len(counts) > 1, "the surface has the same points in all frames: nothing is tried")
    first, last = (read["frames"][k]["left_sheet"]["saturation"] for k in (0, -1))
    expect(distance(first, last) > 1e-3, "saturation is the same in all frames: nothing is tried")


def has_pil():
    """Has the Python that tools/render joins pictures with what it needs?"""
    return subprocess.run(["/usr/bin/python3", "-c", "import PIL.Image"], capture_output=True).returncode == 0


def check_cycles(run, folder):
    """tools/render --cycles: two pictures that are not of one colour, and a film of them."""
    from vtkmodules.vtkIOImage import vtkPNGReader
    film = folder / "film.webp"
    more = ["--animation", film, "--backdrop", "dark"] if has_pil() else []
    ran = subprocess.run([SOURCE / "tools/render", run, "--cycles", "-o", folder / "pictures", "--frames", "2", "--size", "48x32",
                          "--samples", "2", *more], capture_output=True, text=True, env=environment(DRENCH=BINARY))
    expect(ran.returncode == 0, ran.stderr[-500:])
    pictures = sorted((folder / "pictures").glob("*.png"))
    said = [*map(str, pictures), f"2 pictures, {1 / 0.2:.6g} per second", *([f"animation: {film}"] if more else [])]
    expect(len(pictures) == 2 and ran.stdout.splitlines() == said, ran.stdout)
    expect(not more or film.read_bytes().count(b"ANMF") == 2, "the film has not two pictures")
    wrong = subprocess.run([SOURCE / "tools/render", run, "--cycles", "--animation", "film.avi"], capture_output=True, text=True)
    expect(wrong.returncode == 2 and ".webp" in wrong.stderr, f"{wrong.returncode}: {wrong.stderr}")
    reader = vtkPNGReader()
    reader.SetFileName(str(pictures[-1]))
    reader.Update()
    low, high = reader.GetOutput().GetScalarRange()
    expect(reader.GetOutput().GetDimensions() == (48, 32, 1) and high - low > 30, f"values from {low} to {high}")


def main():
    try:
        import vtkmodules.vtkIOXML  # noqa: F401
    except ImportError as error:
        skip(f"{error} (python3-vtk9)")
    for part in ("usd", "blender")[:{"particles": 0, "usd": 1, "blender": 2}[PART]]:
        name, python = ENVIRONMENTS[part]
        if not python.exists():
            skip(f"run tools/setup {name}")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (folder / "scene.yaml").write_text(SCENE)
        run = folder / "run"
        drench("run", folder / "scene.yaml", "-o", run, "--quiet")
        {"particles": check_particles, "usd": check_usd, "blender": check_blender}[PART](run, folder)
        if PART == "blender":
            check_cycles(run, folder)
    print(f"{PART}: passed")


main()

#!/usr/bin/python3 -I
"""import_test.py SOURCE BUILD: `drench import` and `drench new` read what Blender writes as FBX, glTF, Alembic and .blend.

A ball moves by 1 m along x in ten frames, and a flag of four by four cells is bent about its middle. Both are made here with
Blender as a module; drench must find them in metres, with y up. Exit code 77, skipped, without tools/setup blender."""

import os
import struct
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import support  # noqa: E402
from support import SOURCE, call, environment, expect, rejects, skip  # noqa: E402

PYTHON = Path(os.environ.get("DRENCH_BLENDER_PYTHON") or SOURCE / ".deps/blender-venv/bin/python")
MAKE = """
import os
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.frame_start, scene.frame_end, scene.render.fps = 1, 11, 24

def save(name):
    name = os.path.abspath(name)
    bpy.ops.wm.save_as_mainfile(filepath=name + ".blend")
    bpy.ops.export_scene.fbx(filepath=name + ".fbx")
    bpy.ops.export_scene.gltf(filepath=name + ".glb")
    bpy.ops.export_scene.gltf(filepath=name + ".gltf", export_format="GLTF_SEPARATE")
    bpy.ops.wm.alembic_export(filepath=name + ".abc", as_background_job=False)

bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0, 0, 1), segments=16, ring_count=8)
ball = bpy.context.object
ball.name = "Ball"
ball.keyframe_insert("location", frame=1)
ball.location = (1, 0, 1)
ball.keyframe_insert("location", frame=11)
save("ball")
bpy.data.objects.remove(ball)
bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4, size=1)
flag = bpy.context.object
flag.name = "Flag"
flag.shape_key_add(name="Basis")
bent = flag.shape_key_add(name="Bent")
for point in bent.data:
    point.co.z += 0.3 * abs(point.co.x)
bent.value = 0
bent.keyframe_insert("value", frame=1)
bent.value = 1
bent.keyframe_insert("value", frame=11)
save("flag")
bpy.ops.mesh.primitive_cube_add(size=1, location=(3, 0, 0))
bpy.context.object.name = "Cube"
bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath("two.blend"))
"""


def drench(*words, python=PYTHON, **options):
    return support.drench(*words, env=environment(DRENCH_BLENDER_PYTHON=python), **options)


def refused(fragment, *words, python=PYTHON):
    rejects(fragment, *words, env=environment(DRENCH_BLENDER_PYTHON=python))


def bounds(path):
    head, _, body = path.read_bytes().partition(b"end_header\n")
    points = next(int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element vertex"))
    rows = list(struct.iter_unpack("<3f", body[:12 * points]))
    return [(min(row[a] for row in rows), max(row[a] for row in rows)) for a in range(3)]


def near(found, wanted, what):
    expect(all(abs(f - w) < 1e-4 for one, other in zip(found, wanted) for f, w in zip(one, other)), f"{what}: {found}")


def check_ball(ending, folder):
    said = drench("import", folder / f"ball.{ending}", "-o", folder / ending).stdout
    expect("11 files at 24 per second" in said and "114 points, 224 triangles of Ball" in said, said)
    expect("bodies:" in said and "sequence: " in said and "changes its shape" not in said, said)
    near(bounds(folder / ending / "Ball_0000.ply"), [(-0.5, 0.5), (0.5, 1.5), (-0.5, 0.5)], ending)
    near(bounds(folder / ending / "Ball_0010.ply"), [(0.5, 1.5), (0.5, 1.5), (-0.5, 0.5)], ending)
    scene = folder / "scene.yaml"
    scene.write_text("drench: 1\nfluid: {spacing: 0.1, sources: [{block: {min: [-1, 0, 1], max: [1, 1, 2]}}]}\n" +
                     said[said.index("\n") + 1:])
    expect("bodies: 1 (1 moving" in drench("check", scene).stdout, "the printed lines make no moving body")


def check_flag(ending, folder):
    said = drench("import", folder / f"flag.{ending}", "-o", folder / ending).stdout
    expect("11 files" in said and "25 points, 32 triangles of Flag" in said and "pin: " in said, said)
    near(bounds(folder / ending / "Flag_0010.ply"), [(-0.5, 0.5), (0, 0.15), (-0.5, 0.5)], ending)


def main():
    if not PYTHON.exists():
        skip("run tools/setup blender")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        made = call(PYTHON, "-c", MAKE, cwd=folder)
        expect(made.returncode == 0, made.stderr[-2000:])
        for ending in ("blend", "fbx", "glb", "gltf", "abc"):
            check_ball(ending, folder)
        for ending in ("blend", "glb", "abc"):
            check_flag(ending, folder)
        again = drench("import", folder / "ball.fbx", "--fps", 12, "-o", folder / "fbx").stdout
        expect("6 files at 12 per second" in again and len(list((folder / "fbx").glob("Ball_*.ply"))) == 6, again)
        scene = drench("new", folder / "two.blend", "--prim", "Flag", "--body", folder / "two.blend", "--body-prim", "Cube").stdout
        expect("Flag_0000.ply" in scene and "Cube_0000.ply" in scene, scene)
        scene = drench("new", "--body", folder / "ball.fbx").stdout
        expect('ball/Ball_{:04d}.ply", fps: 24' in scene and "sequence: " in scene, scene)
        made = drench("new", folder / "flag.blend")
        expect("the garment is animated in this file" in made.stderr and 'flag/Flag_0000.ply"' in made.stdout, made.stderr)
        refused("holds 2 meshes: choose one with --prim: Flag, Cube", "import", folder / "two.blend")
        refused("unknown mesh Sail; the meshes are Flag, Cube", "new", folder / "two.blend", "--prim", "Sail")
        (folder / "bad.fbx").write_text("no mesh")
        refused("bad.fbx: cannot be read: ", "import", folder / "bad.fbx")
        refused("no such file", "import", folder / "none.abc")
        refused("run tools/setup blender", "import", folder / "ball.fbx", python=folder / "no_python")
        refused("run tools/setup blender", "new", folder / "ball.fbx", python="/usr/bin/python3")
    print("passed")


main()

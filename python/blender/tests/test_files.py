"""Without Blender: the manifest, the zip file, messages and frames."""

import base64
import importlib
import os
import re
import struct
import sys
import tempfile
import tomllib
import unittest
import zipfile
import zlib
from pathlib import Path

import numpy as np

import support  # noqa: F401  (sets the paths of the modules after it)
import build

sys.path.insert(0, str(build.SOURCE.parent))
# The package as a whole needs bpy; these modules do not.
PACKAGE = type(sys)("drench_parts")
PACKAGE.__path__ = [str(build.SOURCE)]
sys.modules["drench_parts"] = PACKAGE
from drench_parts import cache, frames, problem, process, program, text  # noqa: E402


class Manifest(unittest.TestCase):
    def setUp(self):
        self.manifest = tomllib.loads((build.SOURCE / "blender_manifest.toml").read_text())

    def test_required_fields(self):
        m = self.manifest
        self.assertEqual(m["schema_version"], "1.0.0")
        self.assertEqual((m["id"], m["type"]), ("drench", "add-on"))
        self.assertRegex(m["version"], r"^\d+\.\d+\.\d+$")
        self.assertRegex(m["blender_version_min"], r"^4\.[2-9]\.\d+$")
        self.assertLessEqual(len(m["tagline"]), 64)
        self.assertNotRegex(m["tagline"], r"[.!?]$")
        self.assertTrue(m["name"] and m["maintainer"])
        self.assertEqual(m["license"], ["SPDX:Apache-2.0"])
        for reason in m["permissions"].values():
            self.assertTrue(len(reason) <= 64 and not reason.endswith("."), reason)

    def test_no_foreign_modules(self):
        allowed = {"numpy", "bpy", "mathutils", *sys.stdlib_module_names}
        for path in build.SOURCE.glob("*.py"):
            for name in re.findall(r"^\s*(?:import|from) ([a-z_]\w*)", path.read_text(), re.M):
                self.assertIn(name, allowed, path.name)

    def test_zip(self):
        with tempfile.TemporaryDirectory() as folder:
            path = build.build(Path(folder))
            first = path.read_bytes()
            with zipfile.ZipFile(path) as archive:
                self.assertIsNone(archive.testzip())
                names = archive.namelist()
            self.assertEqual(build.build(Path(folder)).read_bytes(), first)
        self.assertIn("blender_manifest.toml", names)
        self.assertIn("LICENSE", names)
        self.assertEqual({n for n in names if n.endswith(".py")}, {p.name for p in build.SOURCE.glob("*.py")})

    def test_zip_with_wheel(self):
        with tempfile.TemporaryDirectory() as folder:
            wheel = Path(folder) / "drench-0.9.0-cp311-cp311-manylinux_2_35_x86_64.whl"
            wheel.write_bytes(b"wheel")
            with zipfile.ZipFile(build.build(Path(folder) / "out", wheel)) as archive:
                manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
                self.assertEqual(manifest["wheels"], [f"./wheels/{wheel.name}"])
                self.assertEqual(manifest["platforms"], ["linux-x64"])
                self.assertEqual(archive.read(f"wheels/{wheel.name}"), b"wheel")


class Messages(unittest.TestCase):
    names = problem.Names(["Towel", "Napkin"], ["Floor", "Hand"], ["Bath", "Bath", "Tap"], ["Bath", "Bath"], ["Tap"],
                          mesh_jets=["Rose"], sprays=["Shower"])

    def test_names(self):
        for line, wanted in (
                ("scene.yaml:9:5: cloth.1.strech: unknown key 'strech'", "'Napkin' strech: unknown key 'strech'"),
                ("scene.yaml: bodies.0.mesh: not closed", "'Floor' mesh: not closed"),
                ("warning: body 'Hand': its thickness 0.01 m", "warning: 'Hand': its thickness 0.01 m"),
                ("x.yaml:4:33: fluid.sources: fluid: jet 0: the radius is small", "'Tap': the radius is small"),
                ("x.yaml: fluid.sources: fluid: mesh_jet 0: its faces are small", "'Rose': its faces are small"),
                ("x.yaml: fluid.sources: fluid: spray 0: it never flows", "'Shower': it never flows"),
                ("warning: fluid: blocks 0, 1 overlap", "warning: fluid: 'Bath' overlap"),
                ("x.yaml: fluid.sources: fluid: mesh source 1 is thinner", "'Bath' is thinner"),
                ("drench: bodies.7: x", "bodies.7: x"), ("warning: cloth 'Towel': x", "warning: cloth 'Towel': x")):
            self.assertEqual(problem.with_names(line, self.names), wanted)

    def test_chosen(self):
        lines = ["scene: scene.yaml", "fluid: 3 particles", "drench: warning: bodies.0: x", "warning: bodies.0: x"]
        self.assertEqual(process.chosen_messages(lines, self.names), ["warning: 'Floor': x"])


class Frames(unittest.TestCase):
    def array(self, values, compressed):
        raw = values.tobytes()
        if not compressed:
            return base64.b64encode(struct.pack("<I", len(raw)) + raw)
        parts = [raw[:16], raw[16:]]
        packed = [zlib.compress(p) for p in parts]
        head = struct.pack("<5I", 2, 16, len(parts[1]), *map(len, packed))
        return base64.b64encode(head) + base64.b64encode(b"".join(packed))

    def frame(self, compressed):
        name = b' compressor="vtkZLibDataCompressor"' if compressed else b""
        points = np.arange(9, dtype="<f4").reshape(3, 3)
        wet = np.array([0.5, 0.25, 1], "<f4")
        return (b'<VTKFile type="UnstructuredGrid" byte_order="LittleEndian" header_type="UInt32"' + name + b'>\n'
                b'<Piece NumberOfPoints="3" NumberOfCells="1">\n'
                b'<DataArray type="Float32" Name="saturation" format="binary">\n' + self.array(wet, compressed) +
                b'\n</DataArray><DataArray type="Float32" Name="Points" NumberOfComponents="3" format="binary">\n' +
                self.array(points, compressed) + b'\n</DataArray></Piece></VTKFile>\n'), points, wet

    def test_read(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "cloth_000000.vtu"
            for compressed in (False, True):
                data, points, wet = self.frame(compressed)
                path.write_bytes(data)
                found = frames.read_frame(path, {"Points", "saturation", "other"})
                np.testing.assert_array_equal(found["Points"], points)
                np.testing.assert_array_equal(found["saturation"], wet)
            path.write_bytes(data[:-20])
            with self.assertRaisesRegex(problem.Problem, "not a complete frame"):
                frames.read_frame(path, {"Points"})
            with self.assertRaisesRegex(problem.Problem, "cannot be read"):
                frames.read_frame(Path(folder) / "none.vtu", {"Points"})

    def test_cache_of_others(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "thesis.txt").write_text("text")
            with self.assertRaisesRegex(problem.Problem, "holds other files, such as thesis.txt"):
                cache.Cache(folder).prepare()
            self.assertFalse(cache.Cache(folder).delete())
            self.assertTrue((Path(folder) / "thesis.txt").exists())


class Program(unittest.TestCase):
    """Which program is used. The stand-in is a shell script."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.old_path, self.old_modules = os.environ.get("PATH", ""), list(sys.path)
        self.addCleanup(self.restore)
        os.environ["PATH"] = str(self.folder / "path")

    def restore(self):
        os.environ["PATH"], sys.path[:] = self.old_path, self.old_modules
        importlib.invalidate_caches()

    def stand_in(self, path, said="version: 1.2.3"):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"#!/bin/sh\necho '{said}'\n")
        path.chmod(0o755)
        return str(path)

    def test_order(self):
        with self.assertRaisesRegex(problem.Problem, "was not found: enter its path"):
            program.find_program()
        on_path = self.stand_in(self.folder / "path" / program.NAME)
        self.assertEqual(program.find_program(), on_path)
        packages = self.folder / "packages"
        in_wheel = self.stand_in(packages / "drench" / "bin" / program.NAME)
        (packages / "drench" / "__init__.py").write_text("")
        sys.path.insert(0, str(packages))
        importlib.invalidate_caches()
        self.assertEqual(program.find_program(), in_wheel)
        own = self.stand_in(self.folder / "own")
        self.assertEqual(program.find_program(own), own)
        self.assertEqual(program.version(own), "1.2.3")

    def test_not_the_program(self):
        other = self.stand_in(self.folder / "other", "hello")
        with self.assertRaisesRegex(problem.Problem, "is not the program drench"):
            program.version(other)
        broken = self.folder / "broken"
        broken.write_bytes(b"\0not a program")
        broken.chmod(0o755)
        with self.assertRaisesRegex(problem.Problem, "cannot be started"):
            program.version(str(broken))


class Text(unittest.TestCase):
    def test_scene(self):
        cloth = {"name": "A: \"b\"", "pin": [{"nodes": [0, 1]}], "porous": {}}
        self.assertEqual(text.scene_text({"drench": 1, "cloth": [cloth]}),
                         'drench: 1\ncloth:\n  - name: "A: \\"b\\""\n    pin: [{nodes: [0, 1]}]\n    porous: {}\n')

    def test_words_are_not_switches(self):
        self.assertIn('name: "off"', text.scene_text({"cloth": [{"name": "off"}]}))


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/python3 -I
"""import_scenes_test.py SOURCE BUILD: `drench import` reads scenes of libWetCloth (.xml) and SPlisHSPlasH (.json), and
materials of ARCSim (.json).

The scenes are written here. Masses, sizes and positions of the imported ones at the start, and positions at the end of scripts, are
compared with numbers that the formulas of those programs give by hand."""

import base64
import json
import math
import re
import struct
import sys
import zlib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from support import Case, drench, main, rejects, stats  # noqa: E402

FIXED = ("--set", "time.mode=fixed", "--set")
N = 9  # nodes along a side of the cloth
HEAD = """<scene>
  <description text="drops on a cloth"/>
  <duration time="0.2"/>
  <integrator type="linearized-implicit-euler" dt="0.001" criterion="1e-6"/>
  <bucketinfo size="1.152" numcells="4"/>
  <liquidinfo><viscosity value="8.9e-3"/><liquidDensity value="0.9"/><surfTensionCoeff value="72.0"/>
    <yarnDiameter value="0.01"/><restVolumeFraction value="0.4"/><flipCoeff value="0.99"/><multiLevel value="0"/></liquidinfo>
  <simplegravity fx="0" fy="-981.0"/>
  <ElasticParameters><radius value="0.0165"/><youngsModulus value="1.83e7"/><poissonRatio value="0.202"/><density value="1.32"/>
    <viscosity value="2.78e4"/><accumulateWithViscous value="1"/><accumulateViscousOnlyForBendingModes value="0"/>
    <frictionAngle value="30.0"/><collisionMultiplier value="0.04"/></ElasticParameters>
"""
SPHERE = '<distancefield usage="source" type="sphere" cx="2" cy="5.76" cz="2" radius="1.44" group="5" vy="-50"/>\n'
SOLID = '<distancefield usage="solid" type="sphere" cx="2" cy="-5.76" cz="2" radius="1.44" group="6"/>\n'
SPACE = ('<distancefield usage="terminator" type="box" cx="2" cy="0" cz="2" ex="21.6" ey="21.6" ez="21.6" radius="0.72" group="7" '
         'inside="1" sampled="0"/>\n')
FLUID = '<distancefield usage="source" type="{}" cx="0" cy="0" cz="0" group="{}" {}/>\n'


def particles(extra=lambda i, j: ""):
    return "".join(f'<particle x="{0.5 * i} 0.25 {0.5 * j}" v="0 0 0" {extra(i, j)}/>\n' for i in range(N) for j in range(N))


def faces(params=0):
    quads = [(i * N + j, i * N + j + 1, (i + 1) * N + j, (i + 1) * N + j + 1) for i in range(N - 1) for j in range(N - 1)]
    rows = "".join(f'<face i="{a} {b} {c}"/><face i="{b} {d} {c}"/>\n' for a, b, c, d in quads)
    return f'<cloth params="{params}">\n{rows}</cloth>\n'


def held(i, j):
    return 'fixed="1"' if i in (0, N - 1) and j in (0, N - 1) else ""


def array(path, name):
    """Values of an array of a frame."""
    text = path.read_text()
    tag = re.search(rf'<DataArray[^>]*Name="{name}"[^>]*>([^<]*)<', text)
    form = {"Float32": "f", "Float64": "d", "Int32": "i"}[re.search(r'type="(\w+)"', tag[0])[1]]
    wide, code = (8, "Q") if 'header_type="UInt64"' in text else (4, "I")
    words = tag[1].strip()
    blocks = struct.unpack_from(f"<{code}", base64.b64decode(words[:4 * math.ceil(wide / 3)]))[0]
    head = 4 * math.ceil((3 + blocks) * wide / 3)
    sizes = struct.unpack_from(f"<{3 + blocks}{code}", base64.b64decode(words[:head]))[3:]
    data, at, raw = base64.b64decode(words[head:]), 0, b""
    for size in sizes:
        raw, at = raw + zlib.decompress(data[at:at + size]), at + size
    return [v[0] for v in struct.iter_unpack(f"<{form}", raw)]


def points(path):
    flat = array(path, "points") if 'Name="points"' in path.read_text() else array(path, "Points")
    return list(zip(*[iter(flat)] * 3))


class Scenes(Case):
    def imported(self, name, text):
        """The imported scene's file, and what the command printed."""
        scene = self.folder / "out" / (Path(name).stem + ".yaml")
        scene.unlink(missing_ok=True)  # it is not overwritten
        return scene, drench("import", self.write(name, text), "-o", self.folder / "out").stdout

    def ran(self, scene, *words):
        drench("run", scene, "-o", self.folder / "run", "--overwrite", *words)
        return self.folder / "run"

    def value(self, folder, key):
        """Of the scene with all its values that a run writes; the first key of this name."""
        return re.search(rf"\b{key}: *(\[[^\]]*\]|[^\s,}}]+)", (folder / "scene.yaml").read_text())[1]

    def near(self, found, wanted, relative=1e-6):
        self.assertAlmostEqual(float(found), wanted, delta=relative * abs(wanted))

    def refuses(self, name, text, fragment):
        rejects(fragment, "import", self.write(name, text), "-o", self.folder / "out")


class LibWetCloth(Scenes):
    def test_masses_sizes_and_positions_at_the_start(self):
        wet = lambda i, j: held(i, j) + ' fvol="5e-4"'
        text = HEAD + SPHERE + SOLID + SPACE + particles(wet) + faces() + "</scene>"
        scene, said = self.imported("splash.xml", text)
        folder = self.ran(scene, "--steps", "1", "--set", "time.step=1e-6")
        self.near(stats(folder)[0]["mass_fluid"], 900 * 4 / 3 * math.pi * 0.0144 ** 3)
        self.near(stats(folder)[0]["mass_cloth"], 81 * 5e-10 * 900)
        nodes = points(folder / "frames/cloth_000000.vtu")
        for k, (x, y, z) in enumerate(nodes):
            for a, b in zip((x, y, z), (0.005 * (k // N), 0.0025, 0.005 * (k % N))):
                self.assertAlmostEqual(a, b, delta=1e-6 * 0.04)
        liquid = points(folder / "frames/fluid_000000.vtu")
        for axis, middle in enumerate((0.02, 0.0576, 0.02)):
            low, high = min(p[axis] for p in liquid), max(p[axis] for p in liquid)
            self.assertAlmostEqual((low + high) / 2, middle, delta=2e-4)
            self.assertLess(0.0144 - (high - low) / 2, 0.0011)
        for key, wanted in (("areal_density", 1.32 * 0.4 * 0.0345 * 10), ("thickness", 3.45e-4),
                            ("stretch", 0.16 * 1.83e6 * 3.45e-4), ("strain_damping", 3 * 2.78e4 / 1.83e7),
                            ("bend", 0.16 * 1.83e6 * 3.45e-4 ** 3 / (12 * (1 - 0.202 ** 2))), ("friction", math.tan(math.pi / 6)),
                            ("viscosity", 8.9e-3 / 0.9 * 1e-4), ("density", 900), ("solid_fraction", 0.4)):
            self.near(self.value(folder, key), wanted)
        self.assertIn("4 pinned", drench("check", scene).stdout)
        self.assertIn("flipCoeff (line 7)", said)
        self.assertIn("multiLevel (line 7): libWetCloth does not read it either", said)
        self.assertIn("collisionMultiplier (line 11)", said)
        self.assertIn("# drops on a cloth", scene.read_text())

    def test_wicking(self):
        """Suction P = 2 φ/(1 − φ) γ cos θ / r with r = d/2 √((1 − φ)/φ); P/(ρ g) high; D = (1 − φ) k P/μ."""
        scene, _ = self.imported("wick.xml", HEAD + SPHERE + SPACE + particles() + faces() + "</scene>")
        rejects("wick.yaml: exists", "import", self.folder / "wick.xml", "-o", self.folder / "out")
        folder = self.ran(scene, "--steps", "1")
        suction = 2 * 0.4 / 0.6 * 72 * math.cos(math.radians(40.8)) / (0.005 * math.sqrt(1.5))
        self.near(self.value(folder, "capillary_height"), suction / (0.9 * 981) * 0.01)
        along = (-math.log(0.4) - 1.476 + 0.8 - 0.08) / 6.4 * 1e-4
        self.near(self.value(folder, "diffusivity"), 0.6 * along * suction / 8.9e-3 * 1e-4)
        across = (-math.log(0.4) - 1.476 + 0.8 - 1.774 * 0.16 + 4.078 * 0.064) / 12.8 * 1e-4
        self.near(self.value(folder, "permeability"), across * 1e-4)

    def test_scripts(self):
        """Two sides move up and down by 2 cm; a corner rotates by a quarter about an origin."""
        groups = lambda i, j: ('fixed="1" group="3"' if (i, j) == (4, 4) else 'fixed="1" group="1"' if i == 0 else
                               'fixed="1" group="2"' if i == N - 1 else "")
        scripts = ('<script type="translate" x="0" y="2" z="0" start="0" end="0.1" group="1"/>'
                   '<script type="translate" x="0" y="-2" z="0" start="0.02" end="0.1" easestart="0.01" easeend="0.02" group="2"/>'
                   '<script type="translate" x="2" y="0" z="0" start="0" end="0.3" group="2"/>'
                   '<script type="rotate" x="0" y="1" z="0" w="1.5707963267948966" ox="0" oy="0" oz="0" start="0" end="0.1" '
                   'group="3"/>\n')
        scene, _ = self.imported("script.xml", HEAD + scripts + particles(groups) + faces() + "</scene>")
        folder = self.ran(scene, "--set", "time.end=0.11", "--set", "output.every=0.05", *FIXED, "time.step=0.01")
        half, end = (points(folder / f"frames/cloth_{k:06d}.vtu") for k in (1, 2))
        for node, wanted in ((0, (0, 0.0225, 0)), (80, (0.045, -0.0175, 0.04)), (4 * N + 4, (0.02, 0.0025, -0.02))):
            for a, b in zip(end[node], wanted):
                self.assertAlmostEqual(a, b, delta=1e-6)
        self.assertAlmostEqual(half[0][1], 0.0125, delta=1e-6)
        self.assertAlmostEqual(half[80][0], 0.04 + 0.02 * 5 * 0.1 * (0.5 ** 3 - 0.5 ** 4 / 2), delta=1e-6)  # within its ease

    def test_bodies_that_move(self):
        """A capsule rotates about an origin, and a tilted box about an axis of its own."""
        solids = ('<distancefield usage="solid" type="capsule" cx="2" cy="0" cz="0" radius="0.5" halflength="1" group="2"/>\n'
                  '<distancefield usage="solid" type="box" cx="0" cy="5" cz="0" ex="1" ey="1" ez="0.5" rx="1" ry="0" rz="0" '
                  'rw="1.5707963267948966" group="3"/>\n'
                  '<script type="rotate" x="0" y="0" z="1" w="3.141592653589793" ox="0" oy="0" oz="0" start="0" end="0.1" group="2"/>\n'
                  '<script type="rotate" x="0" y="1" z="0" w="0.5" start="0" end="0.1" group="3"/>\n'
                  '<script type="translate" x="0" y="1" z="0" start="0" end="0.05" group="3"/>\n')
        scene, _ = self.imported("bodies.xml", HEAD + solids + SPHERE.replace('cy="5.76"', 'cy="20"') + "</scene>")
        folder = self.ran(scene, "--set", "time.end=0.1", "--set", "output.every=0.1", *FIXED, "time.step=0.02")
        places = points(folder / "frames/bodies_000001.vtu")
        low, high = (tuple(f(p[axis] for p in places) for axis in range(3)) for f in (min, max))
        self.assertAlmostEqual(low[0], -0.035, delta=5e-5)  # between two points of the mesh
        self.assertAlmostEqual(high[1], 0.06 + 0.01 * (math.sin(0.5) + 0.5 * math.cos(0.5)), delta=1e-6)
        self.assertIn("axis: [0, 0, 1]", scene.read_text().replace("-0", "0"))

    def test_shapes_without_a_body_of_their_own(self):
        shapes = (("sphere", 'radius="0.5"', 4 / 3 * math.pi * 0.125), ("box", 'ex="0.5" ey="0.4" ez="0.6"', 8 * 0.12),
                  ("box", 'ex="0.5" ey="0.4" ez="0.6" radius="0.2"',
                   0.96 + 2 * (0.8 + 0.96 + 1.2) * 0.2 + 3 * math.pi * 0.04 + 4 / 3 * math.pi * 0.008),
                  ("capsule", 'radius="0.4" halflength="0.7"', math.pi * 0.16 * (1.4 + 4 / 3 * 0.4)),
                  ("cylinder", 'radius="1" halflength="0.5" corner="0.2" rx="1" ry="0" rz="0" rw="0.7"',
                   math.pi * 1 + 2 * math.pi * (0.64 * 0.2 + 0.8 * math.pi / 2 * 0.04 + 2 / 3 * 0.008)))
        for kind, words, volume in shapes:
            with self.subTest(kind + words):
                scene, _ = self.imported("shape.xml", HEAD + FLUID.format(kind, 1, words) + "</scene>")
                self.near(stats(self.ran(scene, "--steps", "1"))[0]["mass_fluid"], volume * 1e-6 * 900)

    def test_shapes_that_are_combined(self):
        half = '<distancefield usage="source" type="intersect" i="0 1" group="1"/>\n'
        sphere, below = FLUID.format("sphere", 1, 'radius="0.8"'), FLUID.format("box", 1, 'ex="1" ey="1" ez="1"')
        low = below.replace('cy="0"', 'cy="-1"')
        scene, _ = self.imported("half.xml", HEAD + sphere + low + half + "</scene>")
        self.near(stats(self.ran(scene, "--steps", "1"))[0]["mass_fluid"], 2 / 3 * math.pi * 0.512e-6 * 900, 0.02)
        boxes = FLUID.format("box", 1, 'ex="1" ey="1" ez="1"') + low + half
        scene, _ = self.imported("boxes.xml", HEAD + boxes + "</scene>")
        self.near(stats(self.ran(scene, "--steps", "1"))[0]["mass_fluid"], 4e-6 * 900)
        self.assertIn("block:", scene.read_text())
        overlapping = sphere + sphere.replace('cx="0"', 'cx="0.8"')
        scene, _ = self.imported("two.xml", HEAD + overlapping + "</scene>")
        lens = math.pi * (4 * 0.8 + 0.8) * (2 * 0.8 - 0.8) ** 2 / 12
        self.near(stats(self.ran(scene, "--steps", "1"))[0]["mass_fluid"], (8 / 3 * math.pi * 0.512 - lens) * 1e-6 * 900, 0.01)

    def test_solids_and_containers(self):
        self.write("tip.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        solids = ('<distancefield usage="solid" type="capsule" cx="0" cy="-3" cz="0" radius="0.5" halflength="1" group="2"/>\n'
                  '<distancefield usage="solid" type="box" cx="0" cy="0" cz="0" ex="6" ey="6" ez="6" group="3" inside="1"/>\n'
                  '<distancefield usage="solid" type="file" cx="0" cy="3" cz="0" filename="tip.obj" scale="2" dx="0.1" group="4"/>\n')
        scene, said = self.imported("solids.xml", HEAD + SPHERE.replace('cx="2"', 'cx="0"') + solids + particles() + faces() + "</scene>")
        self.assertIn("bodies: 3 (0 moving", drench("check", scene).stdout)
        self.assertIn("min: [-0.06, -0.06, -0.06], max: [0.06, 0.06, 0.06], inside: true", scene.read_text())
        data = next((self.folder / "out").glob(f"solid_{12 + 3}.ply")).read_bytes()
        tip = list(struct.iter_unpack("<3d", data[data.index(b"end_header\n") + 11:][:4 * 24]))
        self.assertEqual([min(p) for p in zip(*tip)], [0, 0.03, 0])
        self.assertEqual([round(max(p), 9) for p in zip(*tip)], [0.02, 0.05, 0.02])
        self.assertNotIn("distancefield", said.replace("distancefield@dx", ""))

    def test_particles_one_by_one(self):
        drops = "".join(f'<particle x="{0.11 * i} 0 {0.11 * j}" v="0 {i} 0" state="liquid" fvol="1e-3"/>'
                        for i in range(5) for j in range(5))
        scene, _ = self.imported("drops.xml", HEAD + drops + "</scene>")
        folder = self.ran(scene, "--steps", "1", "--set", "time.step=1e-6")
        self.near(stats(folder)[0]["mass_fluid"], 25 * 1e-9 * 900)
        self.near(sum(array(folder / "frames/fluid_000000.vtu", "velocity")), 5 * (1 + 2 + 3 + 4) * 0.01, 1e-5)

    def test_emitter(self):
        lasting = SPHERE.replace("/>", '><duration start="0.1" end="0.5" vx="30" vy="-40"/></distancefield>')
        scene, _ = self.imported("emitter.xml", HEAD + lasting + SPACE + "</scene>")
        self.assertIn("jet: {center: [0.02, 0.0576, 0.02], radius: 0.0144, velocity: [0.3, -0.4, 0], start: 0.1, end: 0.5}",
                      scene.read_text())

    def test_refusals(self):
        cloth = particles() + faces()
        hair = HEAD + particles() + '<hair params="0" start="0" count="5"/></scene>'
        for text, fragment in (
                (HEAD + "<cloth></scene>", "bad.xml:12: is not well-formed XML: mismatched tag"),
                ("<stage/>", "bad.xml:1: the file contains <stage>"),
                (HEAD + "<clothes/></scene>", "bad.xml:12: unknown element <clothes> in <scene>; did you mean <cloth>?"),
                (HEAD + SPHERE.replace('radius="1.44"', 'radius="-1"') + "</scene>", "bad.xml:12: distancefield@radius: -1 is not above 0"),
                (HEAD + SPHERE.replace('"5.76"', '"high"') + "</scene>", "bad.xml:12: distancefield@cy: 'high' is not a list of numbers"),
                (HEAD + SPHERE.replace("sphere", "torus") + "</scene>",
                 "bad.xml:12: distancefield@type: 'torus' is unknown; allowed: sphere"),
                (HEAD + '<distancefield usage="solid" type="file" filename="cow.obj"/></scene>',
                 "bad.xml:12: cow.obj: no such file; copy it to "),
                (HEAD + cloth.replace('params="0"', 'params="2"') + "</scene>", "cloth@params: 2 is not one of the 1 ElasticParameters"),
                (HEAD + cloth.replace('"0 1 9"', '"0 1 900"') + "</scene>", "face@i: '0 1 900' does not name three of the 81 particles"),
                (HEAD + cloth.replace('"0.5 0.25 0.5"', '"0.5 0.25"') + "</scene>", "particle@x: needs three numbers"),
                (re.sub('dt="[^"]*"', 'dt="-1"', HEAD) + SPHERE + "</scene>", "integrator@dt: -1 is not above 0; correct it"),
                (hair, "holds neither liquid nor cloth, so nothing of it can be simulated; drench has no yarn")):
            with self.subTest(fragment):
                self.refuses("bad.xml", text, fragment)
        rejects("--prim applies to meshes, not to scenes", "import", self.write("a.xml", HEAD), "--prim", "x")
        rejects("none.xml: no such file", "import", self.folder / "none.xml")


CUBE = "".join(f"v {x - 0.5} {y - 0.5} {z - 0.5}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1)) + "".join(
    f"f {' '.join(map(str, f))}\n" for f in ((1, 2, 4, 3), (5, 7, 8, 6), (1, 5, 6, 2), (3, 4, 8, 7), (1, 3, 7, 5), (2, 6, 8, 4)))
WALL = {"geometryFile": "cube.obj", "translation": [0, 1, 0], "scale": [2, 2, 1], "isWall": True, "mapInvert": True, "isDynamic": False}
DAM = {"Configuration": {"particleRadius": 0.025, "timeStepSize": 0.001, "gravitation": [0, -9.81, 0], "cflMethod": 1, "cflFactor": 0.5,
                         "cflMaxTimeStepSize": 0.005, "simulationMethod": 4, "stopAt": 2, "DFSPH": {"maxError": 0.05}},
       "Materials": [{"id": "Fluid", "density0": 900, "viscosityMethod": 1, "Standard viscosity": {"viscosity": 0.02}}],
       "RigidBodies": [WALL],
       "FluidBlocks": [{"denseMode": 0, "start": [-1, 0, -0.5], "end": [-0.5, 0.4, 0.5], "translation": [0.1, 0, 0]}]}


def ball():
    """Points of a sphere of radius 1, and its faces."""
    rows, columns = 12, 20
    rings = [[(math.sin(a) * math.cos(b), math.cos(a), math.sin(a) * math.sin(b)) for b in
              (2 * math.pi * k / columns for k in range(columns))] for a in (math.pi * r / rows for r in range(1, rows))]
    places = [(0, 1, 0), *(p for ring in rings for p in ring), (0, -1, 0)]
    at = lambda r, k: 2 + r * columns + k % columns
    sides = [(1, at(0, k + 1), at(0, k)) for k in range(columns)]
    sides += [(at(r, k), at(r, k + 1), at(r + 1, k + 1), at(r + 1, k)) for r in range(rows - 2) for k in range(columns)]
    sides += [(len(places), at(rows - 2, k), at(rows - 2, k + 1)) for k in range(columns)]
    return "".join(f"v {x} {y} {z}\n" for x, y, z in places) + "".join(f"f {' '.join(map(str, s))}\n" for s in sides)


def bgeo(rows):
    head = struct.pack(">4scii7i", b"Bgeo", b"V", 5, len(rows), 0, 0, 0, 1, 0, 0, 0)
    head += struct.pack(">H1sHi3i", 1, b"v", 3, 5, 0, 0, 0)
    return head + b"".join(struct.pack(">7f", *p, 1, *v) for p, v in rows) + b"\0\xff"


class SPlisHSPlasH(Scenes):
    def setUp(self):
        super().setUp()
        self.write("cube.obj", CUBE)
        self.write("ball.obj", ball())

    def text(self, **blocks):
        return json.dumps({**DAM, **blocks}, indent=1)

    def test_block_in_a_container(self):
        """SPlisHSPlasH's own lattice: centres from start + d to end − d."""
        scene, said = self.imported("dam.json", self.text())
        folder = self.ran(scene, "--steps", "1", "--set", "time.step=1e-6")
        liquid = points(folder / "frames/fluid_000000.vtu")
        self.assertEqual(len(liquid), 9 * 7 * 19)
        for axis, (low, high) in enumerate(((-0.85, -0.45), (0.05, 0.35), (-0.45, 0.45))):
            self.assertAlmostEqual(min(p[axis] for p in liquid), low, delta=1e-6)
            self.assertAlmostEqual(max(p[axis] for p in liquid), high, delta=1e-6)
        self.near(stats(folder)[0]["mass_fluid"], 9 * 7 * 19 * 0.05 ** 3 * 900)
        self.assertIn("box: {min: [-1, 0, -0.5], max: [1, 2, 0.5], inside: true}", scene.read_text())
        for key, wanted in (("cfl", 0.2), ("viscosity", 0.02), ("density_error", 5e-4), ("end", 2)):
            self.near(self.value(folder, key), wanted)
        self.assertNotIn("not expressed", said)

    def test_floating_bodies_and_rotated_ones(self):
        float_ = {"geometryFile": "ball.obj", "translation": [0.5, 1, 0], "scale": [0.2, 0.2, 0.2], "isDynamic": True, "density": 300,
                  "friction": 0.2, "velocity": [1, 0, 0]}
        turned = {"geometryFile": "cube.obj", "translation": [0.5, 0.2, 0], "scale": [0.3, 0.2, 0.2], "rotationAxis": [0, 0, 2],
                  "rotationAngle": math.pi / 4, "isDynamic": True}
        scene, said = self.imported("floats.json", self.text(RigidBodies=[WALL, float_, turned]))
        self.assertIn("bodies: 3 (2 moving, 2 floating)", drench("check", scene).stdout)
        folder = self.ran(scene, "--steps", "1")
        self.assertIn("density: 300", (folder / "scene.yaml").read_text())
        for key, wanted in (("radius", 0.2), ("friction", 0.2)):
            self.assertIn(f"{key}: {wanted}", scene.read_text())
        self.assertNotIn("isDynamic", said)
        data = next((self.folder / "out").glob("cube_*.ply")).read_bytes()
        corners = list(struct.iter_unpack("<3d", data[data.index(b"end_header\n") + 11:][:8 * 24]))
        self.assertAlmostEqual(max(p[0] for p in corners), 0.5 + 0.25 / math.sqrt(2), delta=1e-9)

    def test_hinges(self):
        float_ = {"id": 2, "geometryFile": "ball.obj", "translation": [0.5, 1, 0], "scale": [0.2, 0.2, 0.2], "isDynamic": True}
        post = {"id": 3, "geometryFile": "cube.obj", "translation": [0.5, 0.2, 0], "scale": [0.1, 0.4, 0.1]}
        hinges = [{"bodyID1": 3, "bodyID2": 2, "position": [0.5, 0.7, 0], "axis": [0, 0, 2]},
                  {"bodyID1": 2, "bodyID2": 7, "position": [0, 0, 0], "axis": [0, 0, 1]}]
        scene, said = self.imported("hinged.json", self.text(
            RigidBodies=[WALL, float_, post, {"id": 4}], HingeJoints=hinges, BallJoints=[], TargetVelocityMotorHingeJoints=[]))
        self.assertIn("hinge: {body: body_2, to: body_3, point: [0.5, 0.7, 0], axis: [0, 0, 2]}", scene.read_text())
        self.ran(scene, "--steps", "1")
        for words in ("HingeJoints[1]", "a hinge needs a floating body and another one", "of joints, drench has hinges only",
                      "add joints with hinge.motor", "RigidBodies[3]", "a body needs a mesh in geometryFile"):
            self.assertIn(words, said)
        self.assertNotIn("no joints", said)

    def test_particles_and_meshes(self):
        rows = [((0.1 * i, 0.1 * j, 0.1 * k), (1.0, 0.0, 0.5 * i)) for i in range(4) for j in range(4) for k in range(4)]
        (self.folder / "drop.bgeo").write_bytes(bgeo(rows))
        models = [{"particleFile": "drop.bgeo", "translation": [0.3, 1, 0], "scale": [0.5, 0.5, 0.5], "rotationAxis": [0, 1, 0],
                   "rotationAngle": math.pi / 2}]
        scene, _ = self.imported("drop.json", self.text(FluidModels=models, FluidBlocks=[]))
        folder = self.ran(scene, "--steps", "1", "--set", "time.step=1e-6")
        liquid = points(folder / "frames/fluid_000000.vtu")
        self.assertEqual(len(liquid), 64)
        for axis, (low, high) in enumerate(((0.3, 0.45), (1, 1.15), (-0.15, 0))):
            self.assertAlmostEqual(min(p[axis] for p in liquid), low, delta=1e-6)
            self.assertAlmostEqual(max(p[axis] for p in liquid), high, delta=1e-6)
        self.near(sum(array(folder / "frames/fluid_000000.vtu", "velocity")), 64 * 1.75, 1e-5)
        scene, _ = self.imported("ball.json", self.text(FluidModels=[{"particleFile": "cube.obj", "translation": [0, 1, 0],
                                                                       "scale": [0.5, 0.3, 0.4]}], FluidBlocks=[]))
        self.near(stats(self.ran(scene, "--steps", "1"))[0]["mass_fluid"], 0.5 * 0.3 * 0.4 * 900)

    def test_emitters(self):
        emitters = [{"type": 1, "width": 8, "translation": [0, 1.5, 0], "rotationAxis": [0, 0, 1], "rotationAngle": -math.pi / 2,
                     "velocity": 2, "emitStartTime": 0.5, "emitEndTime": 1},
                    {"type": 0, "width": 8, "height": 4, "translation": [-0.5, 1, 0], "velocity": 1}]
        scene, said = self.imported("emit.json", self.text(Emitters=emitters, FluidBlocks=[]))
        folder = self.ran(scene, "--steps", "1")
        self.near(self.value(folder, "radius"), 0.2)
        velocity = json.loads(self.value(folder, "velocity"))
        self.assertAlmostEqual(velocity[1], -2, delta=1e-9)
        self.assertAlmostEqual(velocity[0], 0, delta=1e-9)
        self.assertIn(f"size: [0.4, 0.2], up: [0, 1, 0], velocity: [1, 0, 0], start: 0, end: {5000 / 32 * 0.05:.10g}",
                      scene.read_text())
        self.assertNotIn("Emitter of type 0", said)

    def test_refusals(self):
        broken = self.text().replace('"cflMethod": 1,', '"cflMethod": 1')
        models = [{"particleFile": "drop.vtk"}]
        elastic = [{"id": "Fluid", "elasticityMethod": 1}]
        for text, fragment in (
                (broken, "bad.json:11: is not JSON: expected '}'"),
                ("[1]", "the file is not an object"),
                (self.text(FluidBlock=[]), "unknown block FluidBlock; did you mean FluidBlocks?"),
                (self.text(RigidBodies=[{**WALL, "geometryFile": "cow.obj"}]), "cow.obj: no such file; copy it to "),
                (self.text(RigidBodies=[{**WALL, "scale": 2}]), "RigidBodies[0].scale: is not a list of three numbers"),
                (self.text(FluidModels=models), "FluidModels[0].particleFile: drop.vtk: files '.vtk' cannot be read; allowed: .bgeo, .obj"),
                (self.text(Configuration={"sim2D": True}), "bad.json:3: Configuration.sim2D: drench simulates in three dimensions only"),
                (self.text(Materials=elastic), "holds no liquid that drench can simulate")):
            with self.subTest(fragment):
                self.refuses("bad.json", text, fragment)
        (self.folder / "drop.bgeo").write_bytes(bgeo([((0, 0, 0), (0, 0, 0))])[:-8])
        self.refuses("bad.json", self.text(FluidModels=[{"particleFile": "drop.bgeo"}]), "ends early or is damaged")


class ARCSim(Scenes):
    """Numbers of no real fabric."""

    ROWS = [[10, 2, 40, 6], [30, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 18], [0, 0, 0, 0], [0, 0, 70, 0]]
    BENDING = [[8e-6] * 5, [12e-6, 9e-6, 9e-6, 9e-6, 9e-6], [16e-6] * 5]

    def text(self, **more):
        return "// a comment\n" + json.dumps({"density": 0.2, "stretching": self.ROWS, "bending": self.BENDING, **more}, indent=1)

    def test_material(self):
        """c22 is along v, the warp; ARCSim doubles stretching, and its hinges have a quarter of the bending."""
        fabric, said = self.imported("knit.json", self.text())
        text = fabric.read_text()
        self.assertIn("areal_density: 0.2 ", text)
        self.assertIn("membrane: {warp: 80, weft: 20, shear: 6}", text)
        # at 45 degrees (warp + weft + 2 twist)/4 is 3e-6
        self.assertIn("bending: {warp: 2.0e-06, weft: 4.0e-06, twist: 3.0e-06}", text)
        self.assertIn("c12 = 2: cloth in drench does not narrow as it is stretched", said)
        self.assertIn("At a strain of 17 %: warp 140 N/m, weft 60 N/m, shear 18 N/m", said)
        self.assertIn("bending at larger curvatures", said)
        scene = self.folder / "hung.yaml"
        scene.write_text("cloth:\n  - mesh: {grid: {size: [0.2, 0.2], nodes: [5, 5]}}\n    pin: [{corners: true}]\n"
                         f"    fabric: {fabric}\n".replace("cloth:", "drench: 1\ncloth:", 1))
        folder = self.ran(scene, "--steps", "2")
        self.assertIn("areal_density: 0.2", (folder / "scene.yaml").read_text())

    def test_what_does_not_change_is_not_listed(self):
        rows = [[5, 0, 5, 5]] * 6
        fabric, said = self.imported("paper.json", self.text(stretching=rows, bending=[[4e-4] * 5] * 3))
        self.assertNotIn("not expressed", said)
        self.assertIn("bending: {warp: 0.0001, weft: 0.0001, twist: 0.0001}", fabric.read_text())

    def test_numbers_in_other_units_are_noticed(self):
        file = self.write("grams.json", self.text(density=210))
        said = drench("import", file, "-o", self.folder / "out").stderr
        self.assertIn("grams.json:3: density has 210, more than any fabric; the unit is kg/m² (210 g/m² are 0.21)",
                      said)
        file = self.write("stiff.json", self.text(stretching=[[2e7, 2, 40, 6]] + self.ROWS[1:]))
        self.assertIn("stretching has 2e+07, more than any fabric; the unit is N/m",
                      drench("import", file, "-o", self.folder / "out").stderr)
        file = self.write("knit.json", self.text())
        self.assertEqual(drench("import", file, "-o", self.folder / "out").stderr, "")

    def test_repeated_keys_are_listed(self):
        text = self.text().replace('"density": 0.2', '"density": 0.2,\n "density": 0.3', 1)
        fabric, said = self.imported("twice.json", text)
        self.assertIn("density (line 4): it stands there twice; the last value counts, as in ARCSim", said)
        self.assertIn("areal_density: 0.3 ", fabric.read_text())

    def test_refusals(self):
        without = json.dumps({"density": 0.2, "stretching": self.ROWS})
        self.refuses("bad.json", without,
                     "bad.json:1: bending: is missing; a material of ARCSim has density, stretching and bending")
        for more, fragment in (({"density": 1e6}, "density: has 1e+06; allowed: at most 1000 kg/m²"),
                               ({"density": 1e-9}, "density: is 1e-09; allowed: at least 0.0001 kg/m²"),
                               ({"stretching": [[1e12, 2, 40, 6]] + self.ROWS[1:]},
                                "stretching: has 1e+12; allowed: at most 5e+08 N/m"),
                               ({"density": 0}, "bad.json:3: density: is not a number above 0, in kg/m²"),
                               ({"stretching": self.ROWS[:5]}, "stretching: is not a list of 6 rows"),
                               ({"bending": [[1, 2, 3, 4, "5"]] * 3}, "bending[0]: is not a list of 5 numbers")):
            with self.subTest(fragment):
                self.refuses("bad.json", self.text(**more), fragment)


main()

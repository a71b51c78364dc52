"""The scene file that is written, the check, and messages for bad input."""

import json
import math

import numpy as np

import support  # first: it sets the paths of the modules after it


if support.HAS_BLENDER:
    import stage


def points_of(path):
    """Points and triangles of a .ply file of the extension."""
    head, _, body = path.read_bytes().partition(b"end_header\n")
    counts = [int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element")]
    points = np.frombuffer(body, "<f4", 3 * counts[0]).reshape(-1, 3)
    faces = np.frombuffer(body, [("n", "u1"), ("v", "<i4", 3)], offset=12 * counts[0])["v"]
    return points, faces


@support.needs_blender
class Export(support.BlenderCase):
    def export(self):
        """(scene file as lines by section, record)"""
        record = support.part("export").Exporter(self.bpy.context, self.folder).write()
        lines = (self.folder / "scene.yaml").read_text().splitlines()
        return dict(line.strip().removeprefix("- ").split(": ", 1) for line in lines if ": " in line), record

    def test_times_and_axes(self):
        self.wet_sheet(frames=11)
        self.scene.render.fps, self.scene.drench.substeps = 50, 5
        keys, record = self.export()
        self.assertIn('end: 0.2, mode: "cfl"', keys["time"])
        self.assertIn("step: 0.004", keys["time"])
        self.assertIn("-9.81", keys["gravity"].split(",")[2])
        self.assertEqual((record["first_frame"], record["frames"]), (1, 11))
        low, high = json.loads(keys["domain"].replace("min", '"min"').replace("max", '"max"')).values()
        self.assertTrue(max(low) < -0.06 and min(high) > 0.16)
        self.assertLess(low[2], -0.4)  # the sheet may sag by its own length

    def test_scale_and_place(self):
        """A scene in centimetres, and an object that is rotated, scaled and mirrored."""
        self.scene.unit_settings.scale_length = 0.01
        thing = self.sheet(size=1)
        thing.location, thing.rotation_euler, thing.scale = (10, 0, 5), (math.radians(90), 0, 0), (20, -20, 20)
        keys, record = self.export()
        points, faces = points_of(self.folder / json.loads(keys["mesh"].replace("file", '"file"'))["file"])
        np.testing.assert_allclose(points.min(0), [0, 0, -0.05], atol=1e-6)
        np.testing.assert_allclose(points.max(0), [0.2, 0, 0.15], atol=1e-6)
        self.assertEqual(record["unit"], 0.01)
        a, b, c = (points[faces[0][k]] for k in range(3))
        normal = np.array(thing.matrix_world.to_3x3().inverted().transposed() @ thing.data.polygons[0].normal)
        self.assertGreater(np.dot(np.cross(b - a, c - a), normal), 0)

    def test_seams_and_loose_vertices(self):
        """Two panels with doubled points are one cloth, and every vertex has its node."""
        mesh = self.bpy.data.meshes.new("Panels")
        places = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (5, 5, 5), (1, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0)]
        mesh.from_pydata(places, [], [(0, 1, 2, 3), (5, 6, 7, 8)])
        thing = stage.add("Panels", mesh)
        thing.drench.role = "CLOTH"
        _, record = self.export()
        cloth = record["cloths"][0]
        self.assertEqual(cloth["nodes"], 6)
        node = cloth["node"]
        self.assertEqual((node[1], node[2], node[4]), (node[5], node[8], -1))
        self.assertEqual(cloth["loose"], {4: [5, 5, 5]})
        thing.drench.weld = False
        self.assertEqual(self.export()[1]["cloths"][0]["nodes"], 8)

    def test_animated_pins_and_colliders(self):
        """Files per frame only for objects that move: here by an object motion, a shape key, and not at all."""
        self.scene.frame_start, self.scene.frame_end = 3, 6
        sheet = self.sheet()
        sheet.keyframe_insert("location", frame=3)
        sheet.location.z = 0.3
        sheet.keyframe_insert("location", frame=6)
        fixed = stage.box("Fixed", (-1, -1, -0.2), (1, 1, -0.1))
        bent = stage.box("Bent", (1, 1, 1), (2, 2, 2))
        bent.shape_key_add(name="Basis")
        key = bent.shape_key_add(name="Bent")
        key.data[0].co.x -= 0.5
        key.value = 0
        key.keyframe_insert("value", frame=3)
        key.value = 1
        key.keyframe_insert("value", frame=6)
        for thing in (fixed, bent):
            thing.drench.role = "COLLIDER"
        self.export()
        names = sorted(path.name for path in (self.folder / "meshes").iterdir())
        self.assertEqual(names, [f"body_0_Bent_{k:06d}.ply" for k in range(4)] + ["body_1_Fixed_000000.ply"] +
                         [f"cloth_0_Sheet_{k:06d}.ply" for k in range(4)])
        first, last = (points_of(self.folder / f"meshes/cloth_0_Sheet_{k:06d}.ply")[0] for k in (0, 3))
        np.testing.assert_allclose(last - first, np.broadcast_to([0, 0, 0.3], first.shape), atol=1e-6)
        text = (self.folder / "scene.yaml").read_text()
        self.assertIn('pin: [{nodes: [0, 8, 72, 80], sequence: "meshes/cloth_0_Sheet_{:06d}.ply", fps: 24.0}]', text)
        self.assertIn('mesh: {sequence: "meshes/body_0_Bent_{:06d}.ply", fps: 24.0}', text)
        self.assertIn('mesh: {file: "meshes/body_1_Fixed_000000.ply"}', text)
        self.assertEqual(self.scene.frame_current, 1)

    def test_soft_pins_and_their_release(self):
        self.scene.frame_start, self.scene.frame_end = 1, 30
        own = self.sheet().drench
        text = lambda: (self.export(), (self.folder / "scene.yaml").read_text())[1]
        own.use_pin_stiffness, own.pin_stiffness = True, 250
        self.assertIn("pin: [{nodes: [0, 8, 72, 80], stiffness: 250.0}]", text())
        own.use_pin_release, own.pin_release = True, 13
        self.assertIn("pin: [{nodes: [0, 8, 72, 80], stiffness: 250.0, release: 0.5}]", text())
        own.use_pin_stiffness = False
        self.assertIn("pin: [{nodes: [0, 8, 72, 80], stiffness: 100000.0, release: 0.5}]", text())

    def test_modifiers_above_and_below(self):
        """Modifiers above ours shape the cloth at the start, those below are not simulated."""
        thing = self.sheet(cells=2)
        above = thing.modifiers.new("Above", "SUBSURF")
        above.levels = above.render_levels = 1
        thing.modifiers.move(1, 0)
        thing.modifiers.new("Below", "SUBSURF").levels = 2
        _, record = self.export()
        self.assertEqual(len(record["cloths"][0]["node"]), 9 + 16 + 8)  # vertices, edges and faces of 8 triangles
        self.assertTrue(all(m.show_viewport for m in thing.modifiers))

    def test_roles(self):
        self.wet_sheet()
        nozzle = stage.add("Tap", None, (0, 0, 0.5))
        nozzle.rotation_euler.y = math.radians(90)
        own = nozzle.drench
        own.role, own.emitter_radius, own.emitter_speed = "EMITTER", 0.04, 2
        own.use_emitter_range, own.emitter_start, own.emitter_end = True, 3, 13
        floor = stage.grid("Floor", (1, 1), (1, 1), (0, 0, -0.3))
        tank = stage.box("Tank", (-1, -1, -1), (1, 1, 1))
        for thing, shape in ((floor, "PLANE"), (tank, "CONTAINER")):
            thing.drench.role, thing.drench.collider_shape = "COLLIDER", shape
        self.export()
        text = (self.folder / "scene.yaml").read_text()
        self.assertRegex(text, r"jet: \{center: \[0\.0, 0\.0, 0\.5\], radius: 0\.04, "
                         r"velocity: \[-(?:2\.0|1\.9999)[^\]]*\], "
                         r"start: 0\.08333\d*, end: 0\.5\}")
        self.assertRegex(text, r"plane: \{point: \[0\.0, 0\.0, -0\.3\d*\], normal: \[0\.0, 0\.0, 1\.0\]\}")
        self.assertRegex(text, r"box: \{min: \[-1\.0, -1\.0, -1\.0\], max: \[1\.0, 1\.0, [\d.]+\], inside: true\}")

    def test_rain_from_a_plane_and_an_empty(self):
        """The rectangle lies across gravity, along Blender's x and y."""
        self.wet_sheet()
        cloud = stage.grid("Cloud", (0.6, 0.4), (1, 1), (0, 0, 1))
        empty = stage.add("Empty", None, (0.5, 0, 1))
        empty.empty_display_size, empty.scale = 0.1, (2, 1, 1)
        for thing in (cloud, empty):
            own = thing.drench
            own.role, own.emitter_shape, own.emitter_rate, own.emitter_drop = "EMITTER", "RAIN", 500, 0.003
        cloud.drench.use_emitter_range, cloud.drench.emitter_start, cloud.drench.emitter_end = True, 3, 13
        self.export()
        text = (self.folder / "scene.yaml").read_text()
        self.assertRegex(text, r"rain: \{center: \[0\.0, 0\.0, 1\.0\], size: \[0\.6\d*, 0\.4\d*\], rate: 500\.0, "
                         r"diameter: 0\.003, start: 0\.08333\d*, end: 0\.5\}")
        self.assertRegex(text, r"rain: \{center: \[0\.5, 0\.0, 1\.0\], size: \[0\.4\d*, 0\.2\d*\], rate: 500\.0, "
                         r"diameter: 0\.003\}")

    def test_liquid_in_a_mesh(self):
        self.bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.2)
        ball = self.bpy.context.object
        ball.drench.role, ball.drench.liquid_shape, ball.drench.liquid_velocity = "LIQUID", "MESH", (0, 0, 0.5)
        self.export()
        self.assertIn('sources: [{mesh: {file: "meshes/liquid_0_Icosphere_000000.ply", velocity: [0.0, 0.0, 0.5]}}]',
                      (self.folder / "scene.yaml").read_text())

    def test_block_is_a_multiple_of_the_spacing(self):
        low, high = support.part("roles").box_block(np.zeros(3), np.array([0.35, 0.2, 0.01]), 0.1)
        np.testing.assert_allclose(high - low, [0.3, 0.2, 0.1])
        np.testing.assert_allclose((low + high) / 2, [0.175, 0.1, 0.005])

    def test_animated_emitter(self):
        """Rotation and speed become keyframes of the velocity."""
        nozzle = stage.add("Tap", None)
        nozzle.drench.role, self.scene.frame_end = "EMITTER", 5
        for frame, angle, speed in ((1, 0, 2), (5, 90, 1)):
            nozzle.rotation_euler.y, nozzle.drench.emitter_speed = math.radians(angle), speed
            nozzle.keyframe_insert("rotation_euler", frame=frame)
            nozzle.keyframe_insert("drench.emitter_speed", frame=frame)
        self.export()
        text = (self.folder / "scene.yaml").read_text()
        keys = json.loads(text[text.index("velocity: [[") + 10:text.index("]]]") + 3])
        self.assertEqual(len(keys), 5)
        np.testing.assert_allclose([keys[0][1], keys[-1][1]], [[0, 0, -2], [-1, 0, 0]], atol=1e-6)
        self.assertAlmostEqual(keys[-1][0], 4 / 24)

    def test_moving_emitter(self):
        """The location becomes keyframes of the displacement."""
        nozzle = stage.add("Tap", None, (0, 0, 0.5))
        nozzle.drench.role, self.scene.frame_end = "EMITTER", 5
        for frame, x in ((1, 0), (5, 0.4)):
            nozzle.location.x = x
            nozzle.keyframe_insert("location", frame=frame)
        self.export()
        text = (self.folder / "scene.yaml").read_text()
        self.assertIn("velocity: [0.0, 0.0, -1.0], motion: {offset: [[", text.replace("-0.0", "0.0"))
        keys = json.loads(text[text.index("offset: [[") + 8:text.index("]]]") + 3])
        self.assertEqual(len(keys), 5)
        np.testing.assert_allclose([keys[0][1], keys[-1][1]], [[0, 0, 0], [0.4, 0, 0]], atol=1e-6)
        self.assertAlmostEqual(keys[-1][0], 4 / 24)
        if support.PROGRAM:
            self.check()

    def test_spray(self):
        """A cone along the local −Z axis, whose location becomes keyframes of the displacement."""
        rose = stage.add("Rose", None, (0, 0, 0.5))
        own, self.scene.frame_end = rose.drench, 5
        own.role, own.emitter_shape, own.emitter_angle = "EMITTER", "SPRAY", math.radians(50)
        own.emitter_speed, own.emitter_flow = 3, 8
        for frame, x in ((1, 0), (5, 0.4)):
            rose.location.x = x
            rose.keyframe_insert("location", frame=frame)
        self.export()
        text = (self.folder / "scene.yaml").read_text().replace("-0.0", "0.0")
        self.assertIn("spray: {center: [0.0, 0.0, 0.5], direction: [0.0, 0.0, -1.0], half_angle: 25.0, speed: 3.0, "
                      "flow: 8.0, motion: {offset: [[0.0, [0.0, 0.0, 0.0]], ", text)
        if support.PROGRAM:
            self.check()

    def test_emitter_of_faces(self):
        """A plane that stands still is a file, one that moves a sequence."""
        self.scene.frame_end = 5
        for name, x in (("Still", -1), ("Moving", 1)):
            plane = stage.grid(name, (0.4, 0.2), (1, 1), (x, 0, 0.5))
            plane.drench.role, plane.drench.emitter_shape, plane.drench.emitter_speed = "EMITTER", "FACES", 1.5
        plane.keyframe_insert("rotation_euler", frame=1)
        plane.rotation_euler.x, plane.drench.emitter_speed = 1, 0.5
        plane.keyframe_insert("rotation_euler", frame=5)
        plane.drench.keyframe_insert("emitter_speed", frame=5)
        plane.drench.emitter_speed = 1.5
        plane.drench.keyframe_insert("emitter_speed", frame=1)
        self.export()
        text = (self.folder / "scene.yaml").read_text()
        self.assertIn('mesh_jet: {file: "meshes/emitter_1_Still_000000.ply", speed: 1.5}', text)
        self.assertRegex(text, r'mesh_jet: \{sequence: "meshes/emitter_0_Moving_\{:06d\}\.ply", fps: 24\.0, '
                         r"speed: \[\[0\.0, 1\.5\], ")
        self.assertEqual(len(list((self.folder / "meshes").glob("emitter_*.ply"))), 6)
        if support.PROGRAM:
            self.check()

    def test_hidden_objects_are_evaluated(self):
        """Hidden objects move as visible ones do, and stay hidden."""
        self.sheet()
        block = stage.box("Block", (-1, -1, -2), (1, 1, -1))
        block.drench.role = "COLLIDER"
        block.keyframe_insert("location", frame=1)
        block.location.z -= 1
        block.keyframe_insert("location", frame=5)
        block.hide_set(True)
        block.hide_viewport = True
        self.scene.frame_end = 5
        self.export()
        heights = [points_of(self.folder / f"meshes/body_0_Block_{k:06d}.ply")[0][:, 2].max() for k in (0, 4)]
        self.assertAlmostEqual(heights[0] - heights[1], 1, places=5)
        self.assertTrue(block.hide_viewport and block.hide_get())

    def test_domain_and_speed(self):
        self.wet_sheet()
        self.scene.drench.domain = stage.box("Room", (-1, -2, -3), (1, 2, 3))
        self.scene.drench.time_scale = 0.5
        keys, record = self.export()
        self.assertEqual(keys["domain"], "{min: [-1.0, -2.0, -3.0], max: [1.0, 2.0, 3.0]}")
        self.assertIn("every: 0.0208333", keys["output"])
        self.assertEqual(record["speed"], 0.5)

    def test_written_twice_is_the_same(self):
        self.wet_sheet()
        self.export()
        first = {p.name: p.read_bytes() for p in self.folder.rglob("*") if p.is_file()}
        self.export()
        self.assertEqual({p.name: p.read_bytes() for p in self.folder.rglob("*") if p.is_file()}, first)


@support.needs_program
class Check(support.BlenderCase):
    def rejected(self):
        return self.message(self.bpy.ops.drench.check)

    def test_valid(self):
        self.wet_sheet()
        self.assertIn("cloth in all: 81 nodes, 4 pinned", self.check())
        self.assertFalse((self.folder / "cache").exists())

    def test_warnings_name_objects(self):
        self.wet_sheet()
        thin = stage.box("Glass pane", (-1, -1, -0.51), (1, 1, -0.5))
        thin.drench.role = "COLLIDER"
        self.assertIn("warning: 'Glass pane': its median thickness", self.check())

    def test_errors_name_objects(self):
        self.wet_sheet().drench.fabric = "coton_terry"
        self.assertRegex(self.rejected(), r"'Sheet' fabric: .*cotton_terry")

    def test_open_collider(self):
        self.wet_sheet()
        stage.grid("Open", (1, 1), (2, 2), (0, 0, -0.3)).drench.role = "COLLIDER"
        self.assertIn("'Open'", self.rejected())

    def test_small_emitter(self):
        nozzle = stage.add("Tap", None)
        nozzle.drench.role, nozzle.drench.emitter_radius = "EMITTER", 0.001
        self.assertRegex(self.rejected(), "'Tap': the radius .* is below half the spacing")

    def test_bad_input(self):
        """One message that names the object and a remedy, for each of many mistakes."""
        def empty(_):
            pass

        def camera(_):
            stage.add("Cam", self.bpy.data.cameras.new("Cam")).drench.role = "COLLIDER"
            self.sheet()

        def no_faces(_):
            stage.mesh_object("Points", [(0, 0, 0)], []).drench.role = "CLOTH"

        def flat(_):
            self.sheet().scale = (0, 0, 0)

        def no_group(_):
            self.sheet().drench.pin_group = "None such"

        def empty_group(_):
            self.sheet().vertex_groups["Corners"].remove(range(81))

        def short(_):
            self.sheet()
            self.scene.frame_start = self.scene.frame_end = 5

        def still_faces(_):
            plane = stage.grid("Slot", (1, 1), (1, 1))
            plane.drench.role, plane.drench.emitter_shape, plane.drench.emitter_speed = "EMITTER", "FACES", 0

        def no_emitting_faces(_):
            stage.add("Rose", None).drench.role = "EMITTER"
            self.bpy.data.objects["Rose"].drench.emitter_shape = "FACES"

        def moving_rain(_):
            cloud = stage.grid("Cloud", (1, 1), (1, 1))
            cloud.drench.role, cloud.drench.emitter_shape = "EMITTER", "RAIN"
            cloud.keyframe_insert("rotation_euler", frame=1)
            cloud.rotation_euler.z = 1
            cloud.keyframe_insert("rotation_euler", frame=5)

        def turning_spray(_):
            rose = stage.add("Rose", None)
            rose.drench.role, rose.drench.emitter_shape = "EMITTER", "SPRAY"
            rose.keyframe_insert("rotation_euler", frame=1)
            rose.rotation_euler.x = 1
            rose.keyframe_insert("rotation_euler", frame=5)

        def changing_spray(_):
            rose = stage.add("Rose", None)
            rose.drench.role, rose.drench.emitter_shape = "EMITTER", "SPRAY"
            rose.drench.keyframe_insert("emitter_flow", frame=1)
            rose.drench.emitter_flow = 20
            rose.drench.keyframe_insert("emitter_flow", frame=5)

        def changing_rain(_):
            cloud = stage.grid("Cloud", (1, 1), (1, 1))
            cloud.drench.role, cloud.drench.emitter_shape = "EMITTER", "RAIN"
            cloud.drench.keyframe_insert("emitter_rate", frame=1)
            cloud.drench.emitter_rate = 1
            cloud.drench.keyframe_insert("emitter_rate", frame=5)

        def changing_collider(_):
            self.sheet()
            thing = stage.box("Sliced", (0, 0, -2), (1, 1, -1))
            thing.drench.role = "COLLIDER"
            build = thing.modifiers.new("Build", "BUILD")
            build.frame_start, build.frame_duration = 1, 10

        def open_liquid(_):
            thing = stage.grid("Puddle", (1, 1), (1, 1))
            thing.drench.role, thing.drench.liquid_shape = "LIQUID", "MESH"
            thing.rotation_euler.x = 0.3

        def levels(_):
            thing = self.sheet()
            thing.modifiers.new("Fine", "SUBSURF").levels = 3
            thing.modifiers.move(1, 0)

        def unsaved(_):
            self.sheet()
            self.scene.drench.cache = "//cache"

        def excluded(_):
            thing = self.sheet()
            collection = self.bpy.data.collections.new("Spare")
            self.scene.collection.children.link(collection)
            collection.objects.link(thing)
            self.scene.collection.objects.unlink(thing)
            self.bpy.context.view_layer.layer_collection.children["Spare"].exclude = True

        def hidden_collection(_):
            excluded(_)
            self.bpy.context.view_layer.layer_collection.children["Spare"].exclude = False
            self.bpy.data.collections["Spare"].hide_viewport = True

        def flat_domain(_):
            self.wet_sheet()
            self.scene.drench.domain = stage.grid("Flat", (1, 1), (1, 1))

        def foreign_folder(_):
            self.sheet()
            self.scene.drench.cache = str(self.folder / "letters")
            (self.folder / "letters").mkdir()
            (self.folder / "letters" / "letter.txt").write_text("text")

        cases = ((empty, "there is nothing to simulate"), (camera, "'Cam' is not a mesh: convert it"),
                 (no_faces, "'Points' has no faces"), (flat, "'Sheet': all faces have an area of zero"),
                 (no_group, "'Sheet' has no vertex group 'None such'"),
                 (empty_group, "'Sheet': no vertex has a weight"),
                 (short, "the frame range 5 to 5 is too short"), (still_faces, "'Slot' has a speed of zero"),
                 (no_emitting_faces, "'Rose' has no mesh"),
                 (moving_rain, "'Cloud' moves at frame"), (changing_rain, "'Cloud' has another rate at frame"),
                 (turning_spray, "'Rose' has another direction, speed or flow at frame"),
                 (changing_spray, "'Rose' has another direction, speed or flow at frame"),
                 (changing_collider, "'Sliced' "), (open_liquid, "'Puddle': the mesh "),
                 (levels, "'Sheet': the modifier Fine has other levels"),
                 (unsaved, "has not been saved: save the file"),
                 (excluded, "'Sheet' is in a collection that is excluded"),
                 (hidden_collection, "'Sheet' is in a "), (flat_domain, "the domain 'Flat' is flat"),
                 (foreign_folder, "holds other files, such as letter.txt"))
        for make, wanted in cases:
            with self.subTest(make.__name__):
                self.empty_file()
                make(self)
                for operator in (self.bpy.ops.drench.check, self.bpy.ops.drench.bake):
                    self.assertIn(wanted, self.message(operator))
                self.assertIn(wanted, self.scene.drench.messages)

    def test_quoted_scene_is_valid_yaml(self):
        thing = self.wet_sheet()
        thing.name = 'a: "b" # {c}'
        self.check()
        self.bpy.data.objects["Water"].name = "off"
        self.check()


if __name__ == "__main__":
    support.unittest.main()

"""What objects show of a bake."""

import numpy as np

import support  # first: it sets the paths of the modules after it

if support.HAS_BLENDER:
    import stage


@support.needs_program
class Playback(support.BakeCase):
    def test_bake_and_playback(self):
        sheet = self.wet_sheet(frames=16)
        sheet.data.materials.append(self.bpy.data.materials.new("Own"))
        self.assertEqual(self.bake(), {"FINISHED"})
        self.assertEqual(self.cache().record()["status"], "finished")
        self.assertEqual((len(self.cache().frames("cloth")), len(self.cache().frames("fluid"))), (16, 16))
        rest = np.array([v.co for v in sheet.data.vertices])
        for frame in (1, 9, 16, 30):  # after the last frame, the last one stays
            self.scene.frame_set(frame)
            arrays = self.frames.read_frame(self.cache().frames("cloth")[min(frame, 16) - 1], {"Points", "saturation"})
            points, wet = self.positions(sheet)
            np.testing.assert_allclose(points, arrays["Points"], atol=1e-6)
            np.testing.assert_allclose(wet, arrays["saturation"], atol=1e-6)
        self.assertLess(points[:, 2].min(), -0.01)
        self.assertGreater(wet.max(), 0.05)
        np.testing.assert_array_equal(np.array([v.co for v in sheet.data.vertices]), rest)

    def test_object_motion_does_not_move_the_result(self):
        """The result stays in the world when its object moves afterwards."""
        sheet = self.wet_sheet(frames=6)
        self.bake()
        self.scene.frame_set(6)
        before, _ = self.positions(sheet)
        sheet.location, sheet.rotation_euler = (1, 2, 3), (0.3, 0.2, 0.1)
        self.bpy.context.view_layer.update()
        np.testing.assert_allclose(self.positions(sheet)[0], before, atol=1e-5)

    def test_between_frames(self):
        """Motion blur looks at times between two frames."""
        sheet = self.wet_sheet(frames=8)
        self.bake()
        places = []
        for frame, part in ((7, 0), (7, 0.5), (8, 0)):
            self.scene.frame_set(frame, subframe=part)
            places.append(self.positions(sheet)[0])
        np.testing.assert_allclose(places[1], (places[0] + places[2]) / 2, atol=1e-6)

    def test_liquid(self):
        self.wet_sheet(frames=6)
        self.scene.unit_settings.scale_length = 1.0
        self.bake()
        own = self.scene.drench
        self.assertFalse(own.liquid_surface.hide_render)
        self.assertTrue(own.particles.hide_render)
        self.scene.frame_set(5)
        surface = own.liquid_surface.data
        self.assertGreater(len(surface.polygons), 50)
        self.assertFalse(surface.validate())
        self.assertIn("velocity", surface.attributes)
        own.display = "SPHERES"
        arrays = self.frames.read_frame(self.cache().frames("fluid")[4], {"Points", "radius", "velocity"})
        data = own.particles.data
        self.assertEqual(len(data.vertices), len(arrays["Points"]))
        radius = [v.value for v in data.attributes["radius"].data]
        np.testing.assert_allclose(radius, arrays["radius"], atol=1e-7)
        np.testing.assert_allclose([tuple(v.vector) for v in data.attributes["velocity"].data], arrays["velocity"],
                                   atol=1e-6)
        graph = self.bpy.context.evaluated_depsgraph_get()
        balls = [i for i in graph.object_instances if i.is_instance and i.parent.original == own.particles]
        self.assertEqual(len(balls), len(radius))

    def test_modifier_below(self):
        """A subdivision below the modifier refines the simulated cloth."""
        sheet = self.wet_sheet(frames=4)
        below = sheet.modifiers.new("Fine", "SUBSURF")
        below.levels = below.render_levels = 1
        self.bake()
        self.scene.frame_set(4)
        points, wet = self.positions(sheet)
        self.assertGreater(len(points), 300)
        self.assertLess(points[:, 2].min(), -0.001)
        self.assertEqual(len(wet), len(points))

    def test_reload_shows_the_same(self):
        sheet = self.wet_sheet(frames=6)
        self.bake()
        self.scene.frame_set(5)
        before = self.positions(sheet)[0]
        path = str(self.folder / "saved.blend")
        with support.Quiet():
            self.bpy.ops.wm.save_as_mainfile(filepath=path)
            self.bpy.ops.wm.read_homefile(use_empty=True)
            self.bpy.ops.wm.open_mainfile(filepath=path)
        scene, sheet = self.bpy.context.scene, self.bpy.data.objects["Sheet"]
        np.testing.assert_array_equal(self.positions(sheet)[0], before)
        scene.frame_set(2)
        self.assertGreater(np.abs(self.positions(sheet)[0] - before).max(), 1e-4)

    def test_renamed_object(self):
        sheet = self.wet_sheet(frames=4)
        self.bake()
        sheet.name = "Other"
        self.scene.frame_set(4)
        self.assertLess(self.positions(sheet)[0][:, 2].min(), -0.001)

    def test_seams_and_loose_vertices(self):
        """Doubled vertices of a seam stay together, and a vertex without faces stays where it is."""
        mesh = self.bpy.data.meshes.new("Panels")
        places = [(0, 0, 0), (0.1, 0, 0), (0.1, 0.1, 0), (0, 0.1, 0), (0.5, 0.5, 0.5),
                  (0.1, 0, 0), (0.2, 0, 0), (0.2, 0.1, 0), (0.1, 0.1, 0)]
        mesh.from_pydata(places, [], [(0, 1, 2, 3), (5, 6, 7, 8)])
        thing = stage.add("Panels", mesh)
        stage.group(thing, "Edge", [0, 3])
        thing.drench.role, thing.drench.pin_group = "CLOTH", "Edge"
        self.scene.frame_end = 8
        self.bake()
        self.scene.frame_set(8)
        points, _ = self.positions(thing)
        np.testing.assert_array_equal(points[[1, 2]], points[[5, 8]])
        np.testing.assert_allclose(points[[0, 3, 4]], np.array(places)[[0, 3, 4]], atol=1e-6)
        self.assertLess(points[6, 2], -0.02)

    def test_centimetres_and_slow_motion(self):
        """Positions and velocities are in Blender's units of length, and per second of the film."""
        self.scene.unit_settings.scale_length, self.scene.drench.time_scale = 0.01, 0.25
        water = self.water((-6, -6, 5), (6, 6, 17))
        self.scene.drench.spacing, self.scene.drench.display, self.scene.frame_end = 3, "POINTS", 9
        water.drench.liquid_velocity = (0, 0, -1)
        self.bake()
        self.scene.frame_set(9)
        data = self.scene.drench.particles.data
        heights = np.array([v.co.z for v in data.vertices])
        seconds = 8 / 24 * 0.25
        self.assertEqual(len(heights), 64)
        self.assertAlmostEqual(heights.mean(), 11 - 100 * (seconds + 9.81 / 2 * seconds**2), delta=0.3)
        speed = np.mean([v.vector[2] for v in data.attributes["velocity"].data])
        self.assertAlmostEqual(speed, -100 * (1 + 9.81 * seconds) * 0.25, delta=0.5)
        self.assertAlmostEqual(data.attributes["radius"].data[0].value, 1.5, places=3)

    def test_undo_after_a_bake(self):
        """Undoing a later step keeps the objects that show the bake."""
        self.wet_sheet(frames=4)
        self.bpy.ops.ed.undo_push(message="scene")
        self.bake()
        self.bpy.data.objects["Water"].location.z += 1
        self.bpy.ops.ed.undo_push(message="moved")
        self.bpy.ops.ed.undo()
        scene, sheet = self.bpy.context.scene, self.bpy.data.objects["Sheet"]
        self.assertIsNotNone(scene.drench.liquid_surface)
        scene.frame_set(4)
        self.assertLess(self.positions(sheet)[0][:, 2].min(), -0.001)

    def test_damaged_frame_is_a_message(self):
        self.wet_sheet(frames=4)
        self.bake()
        path = self.cache().frames("cloth")[2]
        path.write_bytes(path.read_bytes()[:500])
        with support.Quiet():
            self.scene.frame_set(3)
        self.assertIn("is not a complete frame: bake again", self.scene.drench.messages)

    def test_two_cloths(self):
        """Each object shows its own part of the frames."""
        first = self.wet_sheet(frames=4)
        second = self.sheet("Another", cells=5, size=0.2)
        second.location.z = -0.2
        self.bake()
        self.scene.frame_set(4)
        for thing, height in ((first, 0), (second, -0.2)):
            points = self.positions(thing)[0]
            self.assertEqual(len(points), len(thing.data.vertices))
            self.assertLess(np.abs(points[:, 2] - height).max(), 0.15)

    def test_copied_cloth(self):
        """A copy of a cloth is a cloth of its own, and removing its role leaves the original."""
        first = self.wet_sheet(frames=4)
        second = first.copy()
        second.data = first.data.copy()
        self.scene.collection.objects.link(second)
        second.location.z = -0.5
        self.assertEqual(first.drench.shown, second.drench.shown)
        self.bake()
        self.assertNotEqual(first.drench.shown, second.drench.shown)
        self.scene.frame_set(4)
        for thing, height in ((first, 0), (second, -0.5)):
            self.assertLess(np.abs(self.positions(thing)[0][:, 2] - height).max(), 0.2)
        third = first.copy()
        self.scene.collection.objects.link(third)
        third.drench.role = "NONE"
        self.scene.frame_set(3)
        self.assertLess(self.positions(first)[0][:, 2].min(), -0.001)
        self.assertEqual(third.modifiers.keys(), [])

    def test_animated_pins_follow(self):
        sheet = self.sheet()
        self.scene.frame_start, self.scene.frame_end = 1, 10
        sheet.keyframe_insert("location", frame=1)
        sheet.location.z = 0.1
        sheet.keyframe_insert("location", frame=10)
        self.bake()
        self.scene.frame_set(10)
        self.assertAlmostEqual(self.positions(sheet)[0][0, 2], 0.1, places=4)

    def test_delete(self):
        sheet = self.wet_sheet(frames=4)
        self.bake()
        own = self.folder / "cache" / "notes.txt"
        own.write_text("mine")
        with support.Quiet():
            self.bpy.ops.drench.delete_cache()
        self.assertEqual(list((self.folder / "cache").iterdir()), [own])
        self.scene.frame_set(4)
        self.assertAlmostEqual(np.abs(self.positions(sheet)[0][:, 2]).max(), 0)
        self.assertEqual(len(self.scene.drench.liquid_surface.data.vertices), 0)
        self.assertIn("no bake to continue", self.message(self.bpy.ops.drench.resume))


if __name__ == "__main__":
    support.unittest.main()

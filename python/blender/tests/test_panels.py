"""Every panel is drawn with a stand-in for Blender's layout, which checks names of properties, operators and icons."""

import types

import support


class Layout:
    """Accepts what a layout accepts, and records it."""

    def __init__(self, bpy, seen):
        self.bpy, self.seen = bpy, seen
        functions = bpy.types.UILayout.bl_rna.functions
        self.icons = functions["label"].parameters["icon"].enum_items.keys()

    def _named(self, data, name):
        if name not in data.bl_rna.properties:
            raise AssertionError(f"{data} has no property {name}")
        self.seen.append(name)

    def prop(self, data, name, icon="NONE", **_):
        self._named(data, name)
        assert icon in self.icons, icon

    def prop_search(self, data, name, search, found, **_):
        self._named(data, name)
        assert found in search.bl_rna.properties

    def operator(self, name, icon="NONE", **_):
        group, operator = name.split(".")
        getattr(getattr(self.bpy.ops, group), operator).get_rna_type()  # raises if there is none
        assert icon in self.icons, icon
        self.seen.append(name)

    def label(self, text="", icon="NONE"):
        assert icon in self.icons, icon
        self.seen.append(text)

    def progress(self, factor, text):
        assert 0 <= factor <= 1
        self.seen.append(text)

    def separator(self):
        pass

    def row(self, **_):
        return Layout(self.bpy, self.seen)

    column = box = row


@support.needs_blender
class Panels(support.BlenderCase):
    def drawn(self, name, thing=None):
        """What a panel shows."""
        seen = []
        panel = types.SimpleNamespace(layout=Layout(self.bpy, seen))
        cls = getattr(support.part("panels"), name)
        for method in ("_draw_running", "_draw_idle"):
            if hasattr(cls, method):
                setattr(panel, method, types.MethodType(getattr(cls, method), panel))
        cls.draw(panel, types.SimpleNamespace(object=thing, scene=self.scene))
        return seen

    def test_roles(self):
        thing = self.sheet()
        for role, wanted in (("NONE", "role"), ("CLOTH", "fabric"), ("LIQUID", "liquid_shape"),
                             ("EMITTER", "emitter_speed"), ("COLLIDER", "collider_shape")):
            thing.drench.role = role
            self.assertIn(wanted, self.drawn("DRENCH_PT_object", thing))
        thing.drench.role, thing.drench.emitter_shape = "EMITTER", "RAIN"
        self.assertIn("emitter_rate", self.drawn("DRENCH_PT_object", thing))
        thing.drench.emitter_shape = "SPRAY"
        self.assertIn("emitter_flow", self.drawn("DRENCH_PT_object", thing))
        thing.drench.role, thing.drench.fabric = "CLOTH", "cotton_terry"
        seen = self.drawn("DRENCH_PT_object", thing)
        self.assertTrue("use_density" in seen and "stretch" not in seen)
        camera = self.bpy.data.objects.new("Cam", self.bpy.data.cameras.new("Cam"))
        camera.drench.role = "CLOTH"
        self.assertIn("This role needs a mesh", self.drawn("DRENCH_PT_object", camera))

    def test_scene(self):
        self.scene.drench.liquid = "OWN"
        self.assertIn("viscosity", self.drawn("DRENCH_PT_scene"))

    def test_unsaved(self):
        self.scene.drench.cache = ""
        self.assertIn("has not been saved", " ".join(" ".join(self.drawn("DRENCH_PT_bake")).split()))

    @support.needs_program
    def test_bake(self):
        self.wet_sheet(frames=40)
        self.assertNotIn("drench.delete_cache", self.drawn("DRENCH_PT_bake"))
        bakes = support.part("bakes")
        bakes.start(self.bpy.context)
        seen = self.drawn("DRENCH_PT_bake")
        self.assertTrue({"drench.stop", "drench.cancel"} <= set(seen), seen)
        self.assertRegex(" ".join(seen), r"frame \d+ of 40")
        bakes.stop()
        seen = self.drawn("DRENCH_PT_bake")
        self.assertTrue({"drench.resume", "drench.delete_cache"} <= set(seen), seen)
        self.scene.drench.messages = "warning: a long message " + 40 * "of many words "
        self.assertGreater(len(self.drawn("DRENCH_PT_bake")), len(seen) + 5)

    @support.needs_program
    def test_preferences(self):
        seen = []
        panel = types.SimpleNamespace(layout=Layout(self.bpy, seen), found="drench 0.9.0", connection="gpu: odd",
                                      bl_rna=support.part("preferences").DrenchPreferences.bl_rna)
        support.part("preferences").DrenchPreferences.draw(panel, None)
        self.assertEqual(seen, ["program", "drench.find_program", "drench 0.9.0", "Remote Machine", "host", "port",
                                "identity", "remote_program", "remote_folder", "drench.check_connection", "gpu: odd"])

    def test_remote_bake(self):
        """One that goes on after its file was loaded again."""
        self.wet_sheet(frames=4)
        cache = support.part("playback").cache_of(self.scene)
        folder = cache.check_folder()
        cache.replace_by(folder, {"frames": 4, "status": "running", "remote": {"host": "gpu", "name": "bake_1"}})
        seen = self.drawn("DRENCH_PT_bake")
        self.assertTrue({"drench.resume", "run_on"} <= set(seen), seen)
        self.assertIn("May still run on gpu: Continue fetches its frames", seen)


if __name__ == "__main__":
    support.unittest.main()

"""Roles, undo, reload, and what the extension adds to a file."""

import support


@support.needs_blender
class Settings(support.BlenderCase):
    def test_enabled(self):
        self.assertIn(support.MODULE, self.bpy.context.preferences.addons)
        self.assertTrue(self.bpy.types.Object.bl_rna.properties["drench"])

    def test_undo_and_redo(self):
        thing = self.sheet()
        name = thing.name
        push = self.bpy.ops.ed.undo_push
        push(message="sheet")
        thing.drench.friction = 0.7
        self.scene.drench.spacing = 0.05
        push(message="friction")
        thing.drench.friction, self.scene.drench.spacing = 0.2, 0.01
        push(message="other friction")
        self.bpy.ops.ed.undo()
        thing, scene = self.bpy.data.objects[name], self.bpy.context.scene
        self.assertAlmostEqual(thing.drench.friction, 0.7)
        self.assertAlmostEqual(scene.drench.spacing, 0.05)
        self.assertEqual((thing.drench.role, thing.modifiers.keys()), ("CLOTH", ["Drench"]))
        self.bpy.ops.ed.redo()
        self.assertAlmostEqual(self.bpy.data.objects[name].drench.friction, 0.2)

    def test_reload(self):
        thing = self.sheet()
        thing.drench.fabric, thing.drench.saturation, thing.drench.absorbs = "cotton_terry", 0.4, True
        self.scene.drench.liquid, self.scene.drench.substeps = "HONEY", 17
        path = str(self.folder / "saved.blend")
        with support.Quiet():
            self.bpy.ops.wm.save_as_mainfile(filepath=path)
            self.bpy.ops.wm.read_homefile(use_empty=True)
            self.bpy.ops.wm.open_mainfile(filepath=path)
        thing, scene = self.bpy.data.objects["Sheet"], self.bpy.context.scene
        own = thing.drench
        self.assertEqual((own.role, own.fabric, own.pin_group, scene.drench.liquid, scene.drench.substeps),
                         ("CLOTH", "cotton_terry", "Corners", "HONEY", 17))
        self.assertAlmostEqual(own.saturation, 0.4)
        self.assertIsNotNone(own.shown)
        shown = thing.modifiers["Drench"].node_group.nodes["Object Info"].inputs["Object"].default_value
        self.assertEqual(shown, own.shown)
        handlers = self.bpy.app.handlers
        for kind in ("frame_change_pre", "load_post", "load_pre", "undo_post"):
            self.assertTrue([h for h in getattr(handlers, kind) if support.MODULE in h.__module__], kind)

    def test_role_brings_and_takes_the_modifier(self):
        thing = self.sheet()
        self.assertEqual(thing.modifiers.keys(), ["Drench"])
        thing.drench.role = "COLLIDER"
        self.assertEqual((thing.modifiers.keys(), thing.drench.shown), ([], None))
        self.assertNotIn("Drench Sheet", self.bpy.data.objects)

    def test_refining_modifiers_stay_below(self):
        thing = self.sheet()
        thing.drench.role = "NONE"
        for kind in ("ARMATURE", "SUBSURF", "SOLIDIFY"):
            thing.modifiers.new(kind, kind)
        thing.drench.role = "CLOTH"
        self.assertEqual([m.type for m in thing.modifiers], ["ARMATURE", "NODES", "SUBSURF", "SOLIDIFY"])

    def test_without_a_bake_the_mesh_is_unchanged(self):
        thing = self.sheet()
        points, _ = self.positions(thing)
        self.assertEqual(len(points), 81)
        self.assertAlmostEqual(abs(points[:, 2]).max(), 0)

    def test_wet_look(self):
        thing = self.sheet()
        material = support.part("materials").make_material("Red", Base_Color=(1, 0, 0, 1))
        thing.data.materials.append(material)
        with self.bpy.context.temp_override(object=thing), support.Quiet():
            self.bpy.ops.drench.wet_look()
            self.bpy.ops.drench.wet_look()
        groups = [n for n in material.node_tree.nodes if n.type == "GROUP"]
        self.assertEqual(len(groups), 1)
        self.assertEqual(tuple(groups[0].inputs["Base Color"].default_value), (1, 0, 0, 1))

    def test_disable_and_enable(self):
        import addon_utils
        with support.Quiet():
            addon_utils.disable(support.MODULE)
        handlers = self.bpy.app.handlers.frame_change_pre
        self.assertEqual([h for h in handlers if support.MODULE in h.__module__], [])
        with support.Quiet():
            addon_utils.enable(support.MODULE, default_set=True)
        self.assertTrue(hasattr(self.scene, "drench"))


@support.needs_program
class Program(support.BlenderCase):
    def test_found(self):
        with support.Quiet():
            self.bpy.ops.drench.find_program()
        preferences = self.bpy.context.preferences.addons[support.MODULE].preferences
        self.assertRegex(preferences.found, r"^drench \d+\.\d+\.\d+: ")

    def test_fabrics(self):
        path = support.part("preferences").find_program(self.bpy.context)
        self.assertIn("cotton_terry", support.part("program").fabrics(path))
        names = support.part("properties")._search_fabrics(None, self.bpy.context, "terry")
        self.assertIn("cotton_terry", names)
        self.assertNotIn("denim_11oz", names)

    def test_wrong_path(self):
        preferences = self.bpy.context.preferences.addons[support.MODULE].preferences
        for path, wanted in (("/nowhere/drench", "is not a program: correct the path"),
                             ("/bin/true", "is not the program drench: correct the path")):
            preferences.program = path
            try:
                self.assertIn(wanted, self.message(self.bpy.ops.drench.find_program))
            finally:
                preferences.program = ""


if __name__ == "__main__":
    support.unittest.main()

"""Bakes on another machine by ssh: with a server on this computer, and with stand-ins for ssh."""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
import textwrap
import time
import types
import unittest
from pathlib import Path

import support  # first: it sets the paths of the modules after it
import server


class RemoteCase(support.BakeCase):
    def setUp(self):
        super().setUp()
        self.remote = support.part("remote")
        self.bpy.context.preferences.system.use_online_access = True
        self.addCleanup(setattr, self.bpy.context.preferences.system, "use_online_access", False)
        self.preferences = self.bpy.context.preferences.addons[support.MODULE].preferences
        self.set(host=server.ALIAS, port=0, identity="", remote_program=support.PROGRAM, remote_folder="bakes")
        self.scene.drench.run_on = "REMOTE"
        self.addCleanup(self.set, host="", port=0, identity="", remote_program="drench")
        self.addCleanup(self.bakes.close)

    def set(self, **values):
        for name, value in values.items():
            setattr(self.preferences, name, value)

    def connection(self):
        """What Check Connection shows."""
        with support.Quiet():
            try:
                self.bpy.ops.drench.check_connection()
            except RuntimeError as error:
                self.assertIn(self.preferences.connection, str(error))
        self.assertNotIn("\n", self.preferences.connection)
        return self.preferences.connection


@support.needs_program
@unittest.skipIf(server.MISSING, server.MISSING)
class Remote(RemoteCase):
    baked = {}

    @classmethod
    def setUpClass(cls):
        folder = Path(tempfile.mkdtemp(prefix="drench_sshd_"))
        cls.addClassCleanup(shutil.rmtree, folder, ignore_errors=True)
        cls.server = server.Server(folder)
        cls.server.start()
        cls.addClassCleanup(cls.server.stop)

    def setUp(self):
        super().setUp()
        self.server.use(self)
        self.addCleanup(shutil.rmtree, self.server.home / "bakes", ignore_errors=True)

    def frame_files(self):
        """{name: hash of the contents} of all frames."""
        return {path.name: hashlib.sha256(path.read_bytes()).hexdigest()
                for path in sorted((self.folder / "cache" / "run" / "frames").iterdir())}

    def wanted(self):
        """The frames of a bake of `wet_sheet` on this computer."""
        count = self.scene.frame_end
        if count not in self.baked:
            self.scene.drench.run_on = "LOCAL"
            self.assertEqual(self.bake(), {"FINISHED"})
            self.scene.drench.run_on = "REMOTE"
            self.baked[count] = self.frame_files()
        return self.baked[count]

    def wait(self, bake, until):
        deadline = time.monotonic() + 60
        while bake.poll() and not until() and time.monotonic() < deadline:
            time.sleep(0.01)
        self.assertLess(time.monotonic(), deadline, bake.phase)

    def start_and_wait(self, frames):
        bake = self.bakes.start(self.bpy.context)
        self.wait(bake, lambda: bake.frames()[0] >= frames)
        self.assertEqual((bake.status, bake.error), ("running", ""))
        return bake

    def folders(self):
        return list((self.server.home / "bakes").glob("*"))

    def running(self, program=support.PROGRAM):
        """Process ids of programs that run in folders of the server; with "" also of the shells around them."""
        return [int(path.parent.name) for path in Path("/proc").glob("[0-9]*/cwd")
                if str(self.server.home / "bakes") in _text(path.readlink) and
                _text((path.parent / "cmdline").read_text).startswith(program)]

    def assert_nothing_runs(self):
        self.assertEqual(self.running(), [])
        deadline = time.monotonic() + 5  # a shell ends when it finds that its connection has gone
        while self.running("") and time.monotonic() < deadline:
            time.sleep(0.1)
        self.assertEqual(self.running(""), [])

    def assert_whole_frames(self):
        halves = [*self.folder.rglob(".*.part"), *self.server.home.rglob(".*.part")]
        self.assertEqual(halves, [])
        for series in ("cloth", "fluid", "surface"):
            for path in self.cache().frames(series).values():
                self.assertIn("Points", self.frames.read_frame(path, {"Points"}))

    def resume(self):
        with support.Quiet():
            self.assertEqual(self.bpy.ops.drench.resume(), {"FINISHED"})

    def test_bake_and_playback(self):
        """The same files as of a bake here, and nothing is left there."""
        sheet = self.wet_sheet(frames=12)
        self.wanted()
        wanted = self.frame_files()
        run = self.folder / "cache" / "run"
        names = {path.name for path in run.iterdir() if path.suffix != ".drench"}
        lists = {path.name: path.read_text() for path in run.glob("*.pvd")}
        self.assertEqual(self.bake(), {"FINISHED"})
        self.assertEqual(self.frame_files(), wanted)
        self.assertEqual({path.name for path in run.iterdir()}, names)
        self.assertEqual({path.name: path.read_text() for path in run.glob("*.pvd")}, lists)
        self.assertEqual((self.cache().record()["status"], self.folders()), ("finished", []))
        self.scene.frame_set(12)
        self.assertLess(self.positions(sheet)[0][:, 2].min(), -0.001)
        self.assertIn("complete", self.message(self.bpy.ops.drench.resume))
        with support.Quiet():
            self.assertEqual(self.bpy.ops.drench.delete_cache(), {"FINISHED"})

    def test_cancel_and_continue_give_the_same_bits(self):
        self.wet_sheet(frames=100)
        wanted = self.wanted()
        bake = self.start_and_wait(6)
        for more in (3, 3, 0):
            self.assertEqual(len(self.running()), 1)
            with support.Quiet():
                self.bpy.ops.drench.cancel()
            self.assertEqual(self.cache().record()["status"], "stopped")
            self.assert_nothing_runs()
            done = self.cache().frames_done()
            self.assertTrue(6 <= done < 100, done)
            self.assert_whole_frames()
            if more:
                bake = self.bakes.start(self.bpy.context, resume=True)
                self.wait(bake, lambda: bake.frames()[0] >= done + more)
        self.resume()
        self.assertEqual((self.frame_files(), self.folders()), (wanted, []))

    def test_cancel_at_any_time(self):
        """While it connects, uploads and starts."""
        self.wet_sheet(frames=100)
        for seconds in (0, 0.3, 0.8, 1.2):
            bake = self.bakes.start(self.bpy.context)
            time.sleep(seconds)
            with support.Quiet():
                self.bpy.ops.drench.cancel()
            self.assertEqual((bake.status, self.cache().record()["status"]), ("stopped", "stopped"))
            self.assert_nothing_runs()
        self.scene.frame_end = 4
        self.assertEqual(self.bake(), {"FINISHED"})

    def test_crash_of_blender(self):
        """The run outlives a Blender that is killed, and another one fetches its frames."""
        self.wet_sheet(frames=60)
        wanted = self.wanted()
        with support.Quiet():
            self.bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "scene.blend"))
        code = textwrap.dedent(f"""
            import os, time
            import bpy  # first: it brings the modules below
            import addon_utils
            addon_utils.enable("{support.MODULE}", default_set=True)
            bpy.context.preferences.system.use_online_access = True
            own = bpy.context.preferences.addons["{support.MODULE}"].preferences
            own.host, own.remote_program, own.remote_folder = "{server.ALIAS}", {support.PROGRAM!r}, "bakes"
            bpy.ops.wm.open_mainfile(filepath={str(self.folder / "scene.blend")!r})
            from {support.MODULE} import bakes
            bake = bakes.start(bpy.context)
            while bake.poll() and bake.frames()[0] < 4:
                time.sleep(0.01)
            os.kill(os.getpid(), 9)
            """)
        done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              timeout=120, check=False)
        self.assertEqual((done.returncode, len(self.running())), (-9, 1), done.stdout)
        self.resume()
        self.assertEqual(self.frame_files(), wanted)
        self.assert_nothing_runs()

    def test_pause(self):
        """Without blocking; then the cache is deleted on both sides."""
        self.wet_sheet(frames=60)
        bake = self.start_and_wait(3)
        with support.Quiet():
            self.bpy.ops.drench.stop()
        self.wait(bake, lambda: False)
        self.assertEqual(bake.status, "stopped")
        self.assert_nothing_runs()
        self.assertTrue(list(self.server.home.rglob("checkpoint_*")))
        with support.Quiet():
            self.bpy.ops.drench.delete_cache()
        self.assertEqual((self.folders(), (self.folder / "cache").exists()), ([], False))

    def test_lost_connection_comes_back(self):
        self.wet_sheet(frames=60)
        wanted = self.wanted()
        bake = self.start_and_wait(4)
        for count in (8, 12):
            first = bake.connection
            first.kill()
            self.wait(bake, lambda count=count: bake.frames()[0] >= count)
            self.assertIsNot(bake.connection, first)
        self.wait(bake, lambda: False)
        self.assertEqual((bake.status, self.frame_files()), ("finished", wanted))

    def test_lost_connection_is_reported(self):
        """The server goes; the run there goes on, and its frames are fetched later."""
        self.wet_sheet(frames=30)
        wanted = self.wanted()
        pauses, self.remote.PAUSES = self.remote.PAUSES, (0.1,)
        self.addCleanup(setattr, self.remote, "PAUSES", pauses)
        bake = self.start_and_wait(3)
        self.server.stop()
        self.addCleanup(lambda: self.server.process.poll() is None or self.server.start())
        self.wait(bake, lambda: False)
        self.assertEqual(bake.status, "failed")
        self.assertRegex(bake.error, rf"^{server.ALIAS} cannot be reached \(.*\): .* The bake goes on there: press")
        self.assert_whole_frames()
        self.assertIn("cannot be reached", self.message(self.bpy.ops.drench.resume))
        self.assertEqual(self.cache().record()["status"], "running")
        self.server.start()
        self.resume()
        self.assertEqual(self.frame_files(), wanted)

    def test_cancel_without_a_connection(self):
        self.wet_sheet(frames=200)
        bake = self.start_and_wait(2)
        self.server.stop()
        self.addCleanup(lambda: self.server.process.poll() is None or self.server.start())
        with support.Quiet():
            self.bpy.ops.drench.cancel()
        self.assertRegex(bake.error, "cannot be reached .* The bake goes on there: press Continue, then Cancel")
        self.server.start()
        bake = self.bakes.start(self.bpy.context, resume=True)
        self.wait(bake, lambda: bake.started)
        self.bakes.stop()
        self.assertEqual((bake.status, self.running()), ("stopped", []))

    def test_loading_a_file_leaves_the_run(self):
        """And another scene of the file has its own bake."""
        self.wet_sheet(frames=60)
        wanted = self.wanted()
        bake = self.start_and_wait(2)
        path = str(self.folder / "saved.blend")
        with support.Quiet():
            self.bpy.ops.wm.save_as_mainfile(filepath=path)
            self.bpy.ops.wm.open_mainfile(filepath=path)
        self.assertEqual((bake.status, bake.thread.is_alive(), len(self.running())), ("left", False, 1))
        self.scene = self.bpy.context.scene
        self.assertEqual(self.cache().record()["status"], "running")
        with support.Quiet():
            self.bpy.ops.scene.new(type="NEW")
            other = self.bpy.context.scene
            other.drench.cache, other.drench.run_on = str(self.folder / "other"), "REMOTE"
            other.collection.objects.link(self.bpy.data.objects["Water"])
            other.drench.spacing, other.frame_start, other.frame_end = 0.03, 1, 4
            self.assertEqual(self.bpy.ops.drench.bake(), {"FINISHED"})
            self.bpy.context.window.scene = self.scene
        self.resume()
        self.assertEqual((self.frame_files(), self.folders()), (wanted, []))

    def test_new_bake_replaces_the_earlier_one(self):
        self.wet_sheet(frames=200)
        self.start_and_wait(2)
        self.bakes.close()
        self.scene.frame_end = 4
        self.assertEqual(self.bake(), {"FINISHED"})
        self.assertEqual((self.running(), self.folders(), self.cache().frames_done()), ([], [], 4))

    def test_killed_run_and_removed_folder(self):
        """kill -9 of everything there; then the folder is removed: the scene is uploaded again."""
        self.wet_sheet(frames=60)
        self.scene.drench.checkpoint_frames = 4
        wanted = self.wanted()
        bake = self.start_and_wait(10)
        for pid in self.running():
            os.kill(pid, 9)
        self.wait(bake, lambda: False)
        self.assertEqual(bake.status, "failed")
        bake = self.bakes.start(self.bpy.context, resume=True)
        self.wait(bake, lambda: bake.frames()[0] > 12)
        self.bakes.stop()
        self.assert_whole_frames()
        shutil.rmtree(self.folders()[0])
        self.resume()
        self.assertEqual(self.frame_files(), wanted)

    def test_check(self):
        self.wet_sheet()
        with support.Quiet():
            self.assertEqual(self.bpy.ops.drench.check(), {"FINISHED"})
        self.assertIn("cloth in all: 81 nodes, 4 pinned", self.scene.drench.messages)
        self.bpy.data.objects["Sheet"].drench.fabric = "velvet"
        self.assertRegex(self.message(self.bpy.ops.drench.check), "'Sheet' fabric: ")
        self.assertRegex(self.message(self.bpy.ops.drench.bake), "'Sheet' fabric: ")
        self.assertEqual(len(self.folders()), 1)
        with support.Quiet():
            self.bpy.ops.drench.delete_cache()
        self.assertEqual(self.folders(), [])

    def test_connection(self):
        """By name, and by host, port and key."""
        wanted = rf"^drench \d+\.\d+\.\d+ on {server.ALIAS}: \w+, .*threads$"
        self.assertRegex(self.connection(), wanted)
        self.server.write_config("")
        self.addCleanup(self.server.write_config,
                        f"Host {server.ALIAS}\n  Port {self.server.port}\n  IdentityFile {self.server.folder}/user\n")
        self.set(host="127.0.0.1", port=self.server.port, identity=str(self.server.folder / "user"))
        self.assertRegex(self.connection(), r"^drench \S+ on 127\.0\.0\.1: ")
        self.set(identity=str(self.server.folder / "other"))
        self.assertRegex(self.connection(), r"^127\.0\.0\.1 refused the key: 'ssh -p \d+ -i \S+ 127\.0\.0\.1' must")
        self.set(port=1)
        self.assertRegex(self.connection(), r"^127\.0\.0\.1 cannot be reached \(.*Connection refused\): ")
        self.set(port=self.server.port, host=server.ALIAS)
        known = self.server.folder / "known"
        text = known.read_text()
        self.addCleanup(known.write_text, text)
        known.write_text("")
        self.assertIn("is not known on this computer, or it has changed: run 'ssh -p", self.connection())

    def test_program(self):
        """Of another version, for a missing GPU, not there, and in the home folder."""
        def program(text):
            path = self.server.home / "drench"
            path.write_text(f"#!/bin/sh\n{text}\n")
            path.chmod(0o755)

        self.set(remote_program="~/drench")
        self.assertRegex(self.connection(), "^drench was not found on drench-test, where its path is '~/drench'")
        for text, wanted in (
                ("echo version: 0.1.0", "has version 0.1.0, this extension needs"),
                ("echo hello", "is not the program drench"),
                ("echo 'drench: no CUDA device: no driver; this build requires a GPU' >&2; exit 2",
                 r"was built for a GPU that drench-test does not have \(no CUDA device: no driver"),
                ("echo 'drench: error while loading shared libraries: libcuda.so.1: no such file' >&2; exit 127",
                 "was built for a GPU that drench-test does not have"),
                (f'exec {support.PROGRAM} "$@"', "^drench .* on drench-test: ")):
            program(text)
            self.assertRegex(self.connection(), wanted)
        self.wet_sheet(frames=4)
        program(f'ulimit -f 20; exec {support.PROGRAM} "$@"')
        self.assertRegex(self.message(self.bpy.ops.drench.bake), "cannot be written")
        self.assertEqual(self.cache().record()["status"], "failed")
        program(f'exec {support.PROGRAM} "$@"')
        self.resume()

    def test_full_disk_here(self):
        self.wet_sheet(frames=200)
        bake = self.start_and_wait(2)

        def full(*_):
            raise OSError(28, "No space left on device")

        bake._receive = full
        self.wait(bake, lambda: False)
        self.assertRegex(bake.error, "cache: No space left on device: .* The bake goes on there: press Continue")
        with support.Quiet():
            self.bpy.ops.drench.delete_cache()
        self.assertEqual((self.running(), self.folders()), ([], []))


@support.needs_program
class StandIn(RemoteCase):
    """What is reported where ssh itself fails."""

    def stand_in(self, script):
        server.put_first(self, self.folder / "bin", script)

    def test_messages(self):
        self.wet_sheet(frames=4)
        for script, wanted in (
                ("echo 'ssh: Could not resolve hostname nowhere: Name or service not known' >&2; exit 255",
                 "the host drench-test is unknown: correct it"),
                ("echo 'me@it: Permission denied (publickey,password).' >&2; exit 255", "drench-test refused the key"),
                ("echo 'ssh: connect to host it port 22: Connection timed out' >&2; exit 255",
                 r"drench-test cannot be reached \(connect to host it port 22: Connection timed out\)"),
                ("echo 'Host key verification failed.' >&2; exit 255", "the host key of drench-test is not known"),
                ("echo 'drench begins'; echo 'sh: 1: drench: not found' >&2; exit 127", "drench was not found on"),
                ("echo 'odd' >&2; exit 255", "drench-test: odd"), ("exit 255", "drench-test: the connection ended"),
                ("echo hello", "drench-test: the connection ended")):
            self.stand_in(script)
            self.assertRegex(self.connection(), wanted)
            self.assertRegex(self.message(self.bpy.ops.drench.bake), wanted)
        self.assertFalse((self.folder / "cache").exists())

    def test_full_disk_there(self):
        self.wet_sheet(frames=4)
        version = support.part("program").VERSION
        self.stand_in(f"case \"$*\" in *' info'*) echo 'drench begins'; echo version: {version} ;; "
                      "*) echo 'drench begins'; echo 'tar: scene.yaml: No space left on device' >&2; exit 2 ;; esac")
        self.assertIn("the disk of drench-test is full", self.message(self.bpy.ops.drench.bake))
        self.assertIn("the disk of drench-test is full", self.message(self.bpy.ops.drench.check))
        self.assertEqual(self.cache().record()["status"], "written")

    def test_settings(self):
        for values, wanted in (({"host": ""}, "there is no remote machine: enter its host"),
                               ({"host": "-oProxyCommand=x"}, "'-oProxyCommand=x' is not a host"),
                               ({"host": "a b"}, "'a b' is not a host"),
                               ({"identity": "/nowhere/key"}, "the identity file /nowhere/key does not exist")):
            self.set(**{"host": server.ALIAS, "identity": "", **values})
            self.assertIn(wanted, self.connection())
        self.set(host=server.ALIAS, identity="")
        self.bpy.context.preferences.system.use_online_access = False
        self.assertIn("turn on Allow Online Access", self.connection())

    def test_missing_ssh(self):
        before = os.environ["PATH"]
        self.addCleanup(os.environ.update, PATH=before)
        os.environ["PATH"] = str(self.folder)
        self.assertIn("the program ssh cannot be started", self.connection())

    def test_other_host(self):
        """A bake continues where it was started, and the cache can be deleted without that machine."""
        self.wet_sheet(frames=4)
        with support.Quiet():
            self.bpy.ops.drench.write()
        self.cache().set_status("running", remote={"host": "gpu", "name": "bake_1"})
        wanted = "this bake was started on gpu: enter it as host"
        for operator in (self.bpy.ops.drench.resume, self.bpy.ops.drench.write):
            self.assertIn(wanted, self.message(operator))
        with support.Quiet():
            self.assertEqual(self.bpy.ops.drench.delete_cache(), {"FINISHED"})
        self.assertFalse((self.folder / "cache").exists())

    def test_unsafe_record_and_names(self):
        """Neither a record nor the other machine can name a file elsewhere."""
        self.wet_sheet(frames=4)
        with support.Quiet():
            self.bpy.ops.drench.write()
        for name in ("../x", "", None, "a/b", "a b"):
            self.cache().set_status("running", remote={"host": "gpu", "name": name})
            self.assertIsNone(self.remote.left_there(self.cache()))
        bake = types.SimpleNamespace(place=types.SimpleNamespace(host="gpu"), cache=self.cache())
        for name in ("../x", "run/../x", "/etc/x", "run/frames/../../x", "bake.json", "run/.x"):
            with self.assertRaisesRegex(Exception, "unknown name"):
                self.remote.RemoteBake._receive(bake, None, 0, name)


def _text(read):
    try:
        return str(read())
    except OSError:
        return ""


if __name__ == "__main__":
    unittest.main()

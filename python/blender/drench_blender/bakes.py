"""The bake of this Blender session: at most one is followed at a time. On this computer none outlives its file or its
Blender."""

import atexit

import bpy
from bpy.app.handlers import persistent

from . import export, machine, playback, preferences, process, program, remote
from .problem import Names, Problem

current = None  # process.Bake


def running():
    return current is not None and current.status == "running"


def check(context, progress=lambda part: None):
    """Writes the scene into a folder of its own and checks it. Returns (valid, lines for the user)."""
    cache = playback.cache_of(context.scene)
    place = _place(context)
    folder = cache.check_folder()
    try:
        record = _export(context, folder, progress)
        if isinstance(place, machine.Machine):
            code, lines = place.check(folder, remote.new_name(cache))
        else:
            result = program.call(place, "check", "scene.yaml", seconds=600, cwd=folder)
            code, lines = result.returncode, (result.stderr + "\n" + result.stdout).splitlines()
    finally:
        cache.remove_check_folder()
    messages = process.chosen_messages(lines, Names(**record["names"]))
    if code != 0:
        return False, messages or [f"drench check ended with exit code {code}"]
    wanted = ("fluid: ", "cloth in all: ", "memory: ", "steps: ")
    return True, messages + [line for line in lines if line.startswith(wanted)]


def start(context, resume=False, progress=lambda part: None):
    """Starts a bake, or continues the last one with the scene that it was started with."""
    global current
    need_no_bake()
    cache = playback.cache_of(context.scene)
    record = cache.record() if resume else None
    if resume:
        if record is None:
            raise Problem("there is no bake to continue: start a new one")
        if record.get("status") == "finished":
            raise Problem("the bake is complete: there is nothing to continue")
    place = _place(context, cache if resume else None)
    if resume:
        process.end_left_over(cache)
        playback.connect(context.scene, record)
    else:
        write(context, progress)
    remember("Bake")
    kind = remote.RemoteBake if isinstance(place, machine.Machine) else process.LocalBake
    current = kind(place, cache, context.scene.drench.threads, resume)
    return current


def _place(context, cache=None):
    """Where to run: a Machine, or the path of a program of this computer. The bake of a cache continues where it was
    started."""
    away = remote.left_there(cache) if cache else None
    started = cache is not None and cache.record().get("status") != "written"
    if not away and (started or context.scene.drench.run_on == "LOCAL"):
        path = preferences.find_program(context)
        program.version(path)
        return path
    place = preferences.machine_of(context, away["host"] if away else None)
    place.info(program.VERSION)
    return place


def _end_left_over(context, cache):
    """Ends an earlier bake and removes its files from another machine."""
    process.end_left_over(cache)
    if away := remote.left_there(cache):
        preferences.machine_of(context, away["host"]).remove(away["name"])


def need_no_bake():
    if running():
        raise Problem("a bake is running: pause or cancel it first")


def write(context, progress=lambda part: None):
    """Replaces an earlier bake by the files of a new one, which no program has run yet. Returns its cache."""
    need_no_bake()
    cache = playback.cache_of(context.scene)
    folder = cache.check_folder()
    try:  # an error leaves the earlier bake as it is
        record = _export(context, folder, progress)
        _end_left_over(context, cache)
        playback.clear(context.scene)
        cache.replace_by(folder, {**record, "status": "written"})
    finally:
        cache.remove_check_folder()
    playback.connect(context.scene, cache.record())
    return cache


def load(context):
    """Shows the bake in the cache folder, for example one that another computer has run. Returns its cache."""
    need_no_bake()
    cache = playback.cache_of(context.scene)
    record = cache.record()
    if record is None:
        raise Problem(f"{cache.folder} contains no bake: choose the folder with bake.json")
    if process.left_over(cache) is None and cache.frames_done() >= record["frames"] > 0:
        cache.set_status("finished", pid=None)
    playback.connect(context.scene, cache.record())
    remember("Load Bake")
    return cache


def remember(message):
    """An undo step. Otherwise undoing the step before would remove the objects that show the bake."""
    if bpy.ops.ed.undo_push.poll():
        bpy.ops.ed.undo_push(message=message)


def _export(context, folder, progress):
    """Playback is paused, because the export goes through all frames."""
    playback.paused = True
    try:
        return export.Exporter(context, folder, progress).write()
    finally:
        playback.paused = False


def stop(seconds=process.SECONDS_TO_STOP):
    """Ends a running bake, which can be continued. Returns when the process has ended."""
    if running():
        current.stop(seconds)


def close():
    """For the end of Blender or of its file: ends a bake of this computer, and leaves a remote one alone."""
    if running():
        current.close()


def delete(context):
    """Removes the frames and the files of the bake. Returns whether there were some, and a warning."""
    need_no_bake()
    cache = playback.cache_of(context.scene)
    away, warning = remote.left_there(cache), ""
    try:
        _end_left_over(context, cache)
    except Problem as problem:
        if not away:
            raise
        warning = f"{problem}. The files in {away['name']} on {away['host']} were not deleted"
    playback.clear(context.scene)
    return cache.delete(), warning


@persistent
def _on_load_pre(*_):
    close()


def _at_exit():
    close()


def register():
    bpy.app.handlers.load_pre.append(_on_load_pre)
    atexit.register(_at_exit)


def unregister():
    close()
    atexit.unregister(_at_exit)
    if _on_load_pre in bpy.app.handlers.load_pre:
        bpy.app.handlers.load_pre.remove(_on_load_pre)

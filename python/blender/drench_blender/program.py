"""The program drench: where it is, which version it is, and its short commands. Does not need Blender."""

import functools
import importlib.util
import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

from .problem import Problem

VERSION = tomllib.loads((Path(__file__).parent / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]
NAME = "drench.exe" if os.name == "nt" else "drench"
HIDDEN = {"creationflags": subprocess.CREATE_NO_WINDOW} if os.name == "nt" else {}
SECONDS_OF_QUERY = 30


def program_in_wheel():
    """The program of an installed Python package drench, or None."""
    try:
        spec = importlib.util.find_spec("drench")
    except (ImportError, ValueError):
        return None
    for folder in (spec.submodule_search_locations or []) if spec else []:
        if (path := Path(folder) / "bin" / NAME).is_file():
            return str(path)
    return None


def find_program(preferred=""):
    """The path to use: the preferred one, else that of an installed package, else that on PATH."""
    if preferred:
        path = shutil.which(os.path.expanduser(preferred))
        if path is None:
            raise Problem(f"'{preferred}' is not a program: correct the path in the preferences of the extension")
        return path
    path = program_in_wheel() or shutil.which(NAME)
    if path is None:
        raise Problem("the program drench was not found: enter its path in the preferences of the extension")
    return path


def call(path, *words, seconds=SECONDS_OF_QUERY, cwd=None):
    """Runs a short command and returns the completed process with text output."""
    try:
        return subprocess.run([path, *map(str, words)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, encoding="utf-8", errors="replace", timeout=seconds, cwd=cwd,
                              check=False, **HIDDEN)
    except subprocess.TimeoutExpired:
        raise Problem(f"{path} {words[0]} did not end within {seconds} s: check the path in the preferences") from None
    except OSError as error:
        raise Problem(f"{path} cannot be started: {error.strerror}: check the path in the preferences") from None


@functools.lru_cache(maxsize=8)
def version(path):
    """For example 0.9.0."""
    found = re.search(r"^version: (\S+)", call(path, "info").stdout, re.M)
    if found is None:
        raise Problem(f"{path} is not the program drench: correct the path in the preferences of the extension")
    return found[1]


@functools.lru_cache(maxsize=8)
def fabrics(path):
    """The named fabrics of this program, without none."""
    row = re.search(r"^\| `fabric` \| word \| ([^|]+) \|", call(path, "schema").stdout, re.M)
    return tuple(word for word in re.split(r",\s*", row[1].strip()) if word != "none") if row else ()

"""Shared by the tests in Python: the folders that CTest passes, runs of drench and of tools, what they write."""

import csv
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
SOURCE, BUILD = (Path(word).resolve() for word in (*sys.argv[1:3], ".")[:2])
BINARY = BUILD / "drench"
TEST = Path(sys.argv[0]).stem


def expect(good, message):
    if not good:
        sys.exit(f"{TEST}: {message}")


def skip(reason):
    """CTest reports the test as skipped."""
    print(f"SKIPPED: {reason}")
    sys.exit(77)


def call(*words, **options):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, **options)


def drench(*words, code=0, **options):
    """Runs the program, which must end with this exit code."""
    done = call(BINARY, *words, **options)
    expect(done.returncode == code, f"{words} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done


def rejects(fragment, *words, **options):
    """The program rejects the command with one line that contains `fragment`."""
    done = drench(*words, code=2, **options)
    expect(done.stderr.count("\n") == 1 and fragment in done.stderr and not done.stdout, f"{words}: {done.stderr}")


def environment(**more):
    return {**os.environ, **{name: str(value) for name, value in more.items()}}


def stats(folder):
    with (Path(folder) / "stats.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class Case(unittest.TestCase):
    """A test with a folder of its own."""

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path


def main():
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])

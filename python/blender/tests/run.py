#!/usr/bin/env python3
"""run.py [NAME...]: run the tests of the Blender extension with a Python that has bpy (tools/setup blender).

DRENCH_PROGRAM names the program; otherwise it is searched on PATH. NAME selects a file, such as test_bake. Exit code 77
if tests were skipped because bpy or the program is missing and none failed; tests that need ssh and sshd do not
count."""

import importlib.util
import sys
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE))


def main():
    if importlib.util.find_spec("numpy") is None:
        print("run.py: skipped: this Python has no numpy; use one with Blender as a module (tools/setup blender)")
        sys.exit(77)
    import server
    names = sys.argv[1:] or sorted(path.stem for path in HERE.glob("test_*.py"))
    suite = unittest.TestSuite(unittest.defaultTestLoader.loadTestsFromName(name) for name in names)
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    sys.stdout.flush()
    missing = [reason for _, reason in result.skipped if reason != server.MISSING]
    sys.exit(1 if not result.wasSuccessful() else 77 if missing else 0)


if __name__ == "__main__":
    main()

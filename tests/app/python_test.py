#!/usr/bin/env python3
"""The Python package, built and tested: python_test.py SOURCE_DIR BUILD_DIR. Exit code 77, skipped, without the virtual
environment that `tools/setup python` makes, or without the sources of Kokkos that it needs."""

import os
import re
import subprocess
import sys


def cached(build, name):
    """A value of the build's CMake cache."""
    with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as file:
        found = re.search(rf"^{name}:\w+=(.*)$", file.read(), re.M)
    return found[1] if found else ""


def main():
    source, build = sys.argv[1:3]
    python = os.path.join(source, ".deps/python-venv/bin/python")
    if not os.path.exists(python):
        print("SKIPPED: there is no .deps/python-venv; tools/setup python makes it")
        return 77
    backend, precision = cached(build, "DRENCH_BACKEND"), cached(build, "DRENCH_PRECISION")
    install = [python, "-m", "pip", "install", "--no-build-isolation", "--no-deps", "--force-reinstall", source,
               "-C", f"cmake.define.DRENCH_BACKEND={backend}", "-C", f"cmake.define.DRENCH_PRECISION={precision}",
               "-C", f"build-dir={build}/python"]
    environment = dict(os.environ, PATH=os.path.dirname(python) + os.pathsep + os.environ["PATH"])
    ended = subprocess.run(install, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if ended.returncode and "No Kokkos >= 4.6" in ended.stdout:
        print("SKIPPED: the package needs a Kokkos of its own (docs/manual/python.md): name one in CMAKE_PREFIX_PATH, or its "
              "sources in FETCHCONTENT_SOURCE_DIR_KOKKOS")
        return 77
    if ended.returncode:
        print(ended.stdout[-5000:])
        return 1
    environment.update(DRENCH_PROGRAM=os.path.join(build, "drench"), OMP_WAIT_POLICY="passive")
    return subprocess.run([python, "-m", "pytest", "-q", "-rs", os.path.join(source, "python/tests")], env=environment, cwd=build,
                          check=False).returncode


sys.exit(main())

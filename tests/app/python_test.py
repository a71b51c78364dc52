#!/usr/bin/env python3
"""The Python package, built and tested: python_test.py SOURCE_DIR BUILD_DIR. Exit code 77, skipped, without the virtual
environment that `tools/setup python` makes, or without the sources of Kokkos that it needs. The same wheel is tested with the
oldest NumPy too, where `tools/setup python_oldest` has made an environment of the same Python."""

import glob
import os
import re
import subprocess
import sys
import tempfile


def cached(build, name):
    """A value of the build's CMake cache."""
    with open(os.path.join(build, "CMakeCache.txt"), encoding="utf-8") as file:
        found = re.search(rf"^{name}:\w+=(.*)$", file.read(), re.M)
    return found[1] if found else ""


def run(words, **options):
    """(exit code, what it said)"""
    ended = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **options)
    return ended.returncode, ended.stdout


def make_wheel(python, source, build, folder):
    """(exit code, what pip said)"""
    backend, precision = cached(build, "DRENCH_BACKEND"), cached(build, "DRENCH_PRECISION")
    return run([python, "-m", "pip", "wheel", "--no-build-isolation", "--no-deps", "--wheel-dir", folder, source,
                "-C", f"cmake.define.DRENCH_BACKEND={backend}", "-C", f"cmake.define.DRENCH_PRECISION={precision}",
                "-C", f"build-dir={build}/python"],
               env=dict(os.environ, PATH=os.path.dirname(python) + os.pathsep + os.environ["PATH"]))


def version_of(python):
    return run([python, "-c", "import sys; print(sys.version_info[:2])"])


def test_wheel(python, wheel, source, build):
    """The exit code of the tests with that wheel in the environment of this interpreter."""
    code, said = run([python, "-m", "pip", "install", "--no-deps", "--force-reinstall", wheel])
    if code:
        print(said[-5000:])
        return code
    print(run([python, "-c", "import sys, numpy; print('Python', sys.version.split()[0], 'NumPy', numpy.__version__)"])[1], end="", flush=True)
    environment = dict(os.environ, PATH=os.path.dirname(python) + os.pathsep + os.environ["PATH"],
                       DRENCH_PROGRAM=os.path.join(build, "drench"), OMP_WAIT_POLICY="passive")
    return subprocess.run([python, "-m", "pytest", "-q", "-rs", os.path.join(source, "python/tests")], env=environment, cwd=build,
                          check=False).returncode


def main():
    source, build = sys.argv[1:3]
    python, oldest = (os.path.join(source, f".deps/{name}/bin/python") for name in ("python-venv", "python-oldest-venv"))
    if not os.path.exists(python):
        print("SKIPPED: there is no .deps/python-venv; tools/setup python makes it")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        code, said = make_wheel(python, source, build, folder)
        if code and "Kokkos is neither installed" in said:
            print("SKIPPED: the package needs a Kokkos of its own (docs/manual/python.md): name one in CMAKE_PREFIX_PATH, or its "
                  "sources in FETCHCONTENT_SOURCE_DIR_KOKKOS")
            return 77
        if code:
            print(said[-5000:])
            return 1
        wheel, = glob.glob(os.path.join(folder, "*.whl"))
        failed = test_wheel(python, wheel, source, build)
        if os.path.exists(oldest) and version_of(oldest) == version_of(python):
            failed = test_wheel(oldest, wheel, source, build) or failed
        return failed


sys.exit(main())

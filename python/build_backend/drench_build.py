"""The build backend of pyproject.toml: scikit-build-core, except that a configuration which drench itself explains in one line, such
as a missing Kokkos, ends with that line instead of CMake's output."""

import os
import sys
import threading

from scikit_build_core import build as _build
from scikit_build_core.build import *  # noqa: F403: the other hooks

EXPLANATION = b"drench: "  # begins such a line (tools/cmake/kokkos.cmake)
COMPILING = b"*** Building project"  # scikit-build-core prints this after the configuration


class _Output:
    """While it is entered, the process and its children print here. The output is passed on from the first compilation on."""

    def __init__(self):
        self.held = b""
        self.passing = False

    def __enter__(self):
        sys.stdout.flush()
        sys.stderr.flush()
        self.out, self.err = os.dup(1), os.dup(2)
        self.source, sink = os.pipe()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        os.dup2(sink, 1)
        os.dup2(sink, 2)
        os.close(sink)
        return self

    def __exit__(self, kind, error, trace):
        sys.stdout.flush()
        sys.stderr.flush()
        os.dup2(self.out, 1)
        os.dup2(self.err, 2)
        self.reader.join(10)  # a program left in the background could keep the pipe open
        explained = [line for line in self.held.splitlines(keepends=True) if line.startswith(EXPLANATION)]
        self._write(b"".join(explained) if kind and explained else self.held)

    def _read(self):
        while block := os.read(self.source, 65536):
            self.held += block
            self.passing = self.passing or COMPILING in self.held
            if self.passing:
                self._write(self.held)
                self.held = b""

    def _write(self, data):
        while data:
            data = data[os.write(self.out, data):]


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    with _Output():
        return _build.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    with _Output():
        return _build.build_editable(wheel_directory, config_settings, metadata_directory)

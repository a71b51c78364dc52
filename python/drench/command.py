"""The command `drench`, which the package contains, and `python -m drench`."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import NoReturn

#: The program. It starts without Python.
program = Path(__file__).parent / "bin" / "drench"


def main() -> NoReturn:
    """Become the program with this process's arguments. `drench export --to usd` then uses this Python and its packages."""
    for name in ("DRENCH_PYTHON", "DRENCH_BLENDER_PYTHON"):
        os.environ.setdefault(name, sys.executable)
    sys.stdout.flush()
    try:
        os.execv(program, ["drench", *sys.argv[1:]])
    except OSError as error:
        print(f"drench: {program} cannot be started: {error.strerror}; install the package again", file=sys.stderr)
        sys.exit(2)

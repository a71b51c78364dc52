"""How the scripts of `drench export` and `drench import` refuse: one line, exit code 2."""

import sys


def fail(message):
    print(f"drench: {message}", file=sys.stderr)
    sys.exit(2)


def fail_without(module):
    fail(f"USD needs Python's {module}: run tools/setup export, or name a Python that has usd-core and numpy in DRENCH_PYTHON")

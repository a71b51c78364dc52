#!/usr/bin/env python3
"""includes_test.py SOURCE: no folder of src/ or of the Kokkos backend includes one that comes after it, so there is no circle
between them; the reference and src/ include nothing of the backend; the scene format knows nothing of the set-up."""

import re
import sys
from pathlib import Path

ROOT = Path(sys.argv[1])
BACKEND, SRC = ROOT / "backends/kokkos", ROOT / "src"
SRC_ORDER = ["base", "parallel", "scene", "state", "stages", "setup", "pipeline", "output", "report", "compare", "view", "app", "drench", "laboratory"]
KOKKOS_ORDER = re.search(r"set\(kokkos_folders ([a-z ]+)\)", (ROOT / "CMakeLists.txt").read_text())[1].split()


def includes(folder):
    """(file, number of the line, included name)"""
    for path in sorted(folder.rglob("*.?pp")):
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if found := re.match(r'\s*#include "([^"]+)"', line):
                yield path, number, found[1]


def upward(base, order):
    """How many includes there are between folders of `base`, and those of a folder that comes later."""
    folders = {path.name for path in base.iterdir() if path.is_dir() and any(path.rglob("*.?pp"))}
    wrong = [] if folders == set(order) else [f"the folders {order} have an order, there are {sorted(folders)}"]
    seen = 0
    for path, number, name in includes(base):
        if not (base / name).is_file():
            continue
        seen += 1
        own, other = path.relative_to(base).parts[0], Path(name).parts[0]
        if own in order and (other not in order or order.index(other) > order.index(own)):
            wrong.append(f"{path.relative_to(ROOT)}:{number}: includes {name}: {other} comes after {own}")
    return seen, wrong


counts, wrong = [], []
for base, order in ((BACKEND, KOKKOS_ORDER), (SRC, SRC_ORDER)):
    seen, found = upward(base, order)
    counts.append(seen)
    wrong += found
for folder in (SRC, ROOT / "reference"):
    for path, number, name in includes(folder):
        if (BACKEND / name).is_file() and not (SRC / name).is_file() and not (path.parent / name).is_file():
            wrong.append(f"{path.relative_to(ROOT)}:{number}: includes the backend's {name}")
        if path.is_relative_to(SRC / "scene") and name.startswith("setup/"):
            wrong.append(f"{path.relative_to(ROOT)}:{number}: includes {name}: the format knows nothing of the set-up")
if counts[0] < 100 or counts[1] < 200:
    wrong.append("too few includes: does this test still read the sources?")
print(*wrong, f"{counts[0]} includes within the backend, {counts[1]} within src", sep="\n")
sys.exit(1 if wrong else 0)

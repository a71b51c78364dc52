#!/usr/bin/env python3
"""includes_test.py SOURCE: no folder of the Kokkos backend includes one that comes after it in CMakeLists.txt, so there is
no circle between them; the reference includes nothing of the backend; src includes neither."""

import re
import sys
from pathlib import Path

root = Path(sys.argv[1])
backend = root / "backends/kokkos"
order = re.search(r"set\(kokkos_folders ([a-z ]+)\)", (root / "CMakeLists.txt").read_text()).group(1).split()
folders = {path.name for path in backend.iterdir() if any(path.rglob("*.?pp"))}
wrong = []
if folders != set(order):
    wrong.append(f"CMakeLists.txt names the folders {order}, there are {sorted(folders)}")


def includes(path):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        found = re.match(r'\s*#include "([^"]+)"', line)
        if found:
            yield number, found.group(1)


def sources(folder):
    return [path for path in sorted(folder.rglob("*")) if path.suffix in (".hpp", ".cpp")]


arrows = 0
for path in sources(backend):
    own = path.relative_to(backend).parts[0]
    for number, name in includes(path):
        if not (backend / name).is_file():
            continue
        arrows += 1
        other = Path(name).parts[0]
        if own in order and (other not in order or order.index(other) > order.index(own)):
            wrong.append(f"{path.relative_to(root)}:{number}: includes {name}: {other} comes after {own}")
for folder in ("src", "reference"):
    for path in sources(root / folder):
        for number, name in includes(path):
            if (backend / name).is_file() and not (root / "src" / name).is_file() and not (path.parent / name).is_file():
                wrong.append(f"{path.relative_to(root)}:{number}: includes the backend's {name}")
            if path.is_relative_to(root / "src/scene") and name.startswith("setup/"):
                wrong.append(f"{path.relative_to(root)}:{number}: includes {name}: the format knows nothing of the set-up")
print(f"{arrows} includes within the backend")
if arrows < 100:
    wrong.append("too few includes: does this test still read the backend?")
for line in wrong:
    print(line)
sys.exit(1 if wrong else 0)

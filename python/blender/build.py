#!/usr/bin/env python3
"""build.py [-o FOLDER] [--wheel FILE]: write the Blender extension as drench-VERSION.zip, ready to be installed.

--wheel includes a wheel of the Python package drench (tools/wheel), which contains the program. Blender then installs
it with the extension; the wheel must be built for the Python of that Blender (3.11 for Blender 4.2 to 5.0)."""

import argparse
import re
import sys
import zipfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parent / "drench_blender"
ROOT = SOURCE.parents[2]
TIME = (1980, 1, 1, 0, 0, 0)  # of all entries, so that equal sources give equal files


def manifest_text(wheel):
    text = (SOURCE / "blender_manifest.toml").read_text(encoding="utf-8")
    version = re.search(r'^version = "([^"]+)"', text, re.M)[1]
    program = re.search(r"project\(drench VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
    if version != program:
        sys.exit(f"build.py: blender_manifest.toml has version {version}, CMakeLists.txt has {program}: correct the "
                 "manifest")
    if wheel:
        platform = "linux-arm64" if "aarch64" in wheel.name else "linux-x64"
        keys = f'platforms = ["{platform}"]\nwheels = ["./wheels/{wheel.name}"]\n\n'
        text = text.replace("blender_version_min =", keys + "blender_version_min =")
    return version, text


def build(folder, wheel=None):
    """Returns the path of the zip file."""
    version, manifest = manifest_text(wheel)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"drench-{version}.zip"
    entries = {"blender_manifest.toml": manifest.encode(), "LICENSE": (ROOT / "LICENSE").read_bytes()}
    entries.update((file.name, file.read_bytes()) for file in sorted(SOURCE.glob("*.py")))
    if wheel:
        entries[f"wheels/{wheel.name}"] = wheel.read_bytes()
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in sorted(entries.items()):
            archive.writestr(zipfile.ZipInfo(name, TIME), data, zipfile.ZIP_DEFLATED)
    return path


def main():
    parser = argparse.ArgumentParser(prog="build.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="folder", type=Path, default=Path("dist"), help="output folder (dist)")
    parser.add_argument("--wheel", type=Path, help="wheel of the package drench to include")
    options = parser.parse_args()
    if options.wheel and not options.wheel.is_file():
        parser.error(f"{options.wheel}: no such file")
    print(build(options.folder, options.wheel))


if __name__ == "__main__":
    main()

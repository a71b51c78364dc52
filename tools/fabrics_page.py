#!/usr/bin/env python3
"""tools/fabrics_page.py [--check]: writes the tables of docs/manual/fabrics.md and docs/manual/fabric_data.md, between their
marks, from src/scene/fabrics.yaml.

--check writes nothing: exit code 1 if a page differs from what would be written. Needs no YAML library: the file has one form."""

import re
import sys
from itertools import groupby
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DATA, PAGE, APPENDIX = (ROOT / name for name in ("src/scene/fabrics.yaml", "docs/manual/fabrics.md", "docs/manual/fabric_data.md"))
BEGIN, END = "<!-- made by tools/fabrics_page.py: begin -->", "<!-- made by tools/fabrics_page.py: end -->"
VALUE = re.compile(r'- \{key: (\S+), value: (\S+), how: (\w+), source: (\w+), note: "(.*)"\}$')
UNITS = {"areal_density": "kg/m²", "thickness": "m", "membrane": "N/m", "bending": "N·m", "permeability": "m²",
         "diffusivity": "m²/s", "capillary_height": "m"}
WICKING = ("porous.diffusivity", "porous.diffusion_exponent", "porous.capillary_height")
BASES = ("measured", "derived", "similar", "assumed")

def read(text):
    """({source: {title, link, read}}, {fabric: {about, values: [(key, value, how, source, note)]}})"""
    parts, part, name = {"sources": {}, "fabrics": {}}, None, None
    for line in text.splitlines():
        if line.startswith("#") or not line.strip():
            continue
        if top := re.fullmatch(r"(\w+):", line):
            part = parts[top[1]]
        elif entry := re.fullmatch(r"  (\w+):", line):
            name = entry[1]
            part[name] = {"values": []}
        elif value := VALUE.search(line):
            part[name]["values"].append(value.groups())
        elif field := re.fullmatch(r'    (\w+): "(.*)"', line):
            part[name][field[1]] = field[2]
        elif line.strip() != "values:":
            sys.exit(f"{DATA}: not read: {line}")
    return parts["sources"], parts["fabrics"]


def counts(values):
    return [sum(value[2] == how for value in values) for how in BASES]


def overview(fabrics):
    """One row per fabric, in the units that textile tables have."""
    lines = ["| `fabric` | Description | g/m² | mm | Measured | Derived | Similar | Assumed |", "|---|---|---|---|---|---|---|---|"]
    for name, fabric in fabrics.items():
        value = {key: float(text) for key, text, *_ in fabric["values"]}
        numbers = [f"{1000 * value['areal_density']:.0f}", f"{1000 * value['thickness']:.2g}", *counts(fabric["values"])]
        lines.append(f"| [`{name}`](fabric_data.md#{name}) | {fabric['about']} | " + " | ".join(map(str, numbers)) + " |")
    every = [value for fabric in fabrics.values() for value in fabric["values"]]
    return "\n".join(lines + [f"| all | {len(every)} values | | | " + " | ".join(map(str, counts(every))) + " |"])


def unit(key):
    return next((UNITS[word] for word in key.split(".") if word in UNITS), "")


def joined(values):
    """"1 m, 2 m, 3" → "1, 2 m, 3": a unit stands once behind the values that share it."""
    runs = [(u, [value for _, value, *_ in group]) for u, group in groupby(values, key=lambda value: unit(value[0]))]
    return ", ".join(f"{', '.join(numbers)} {u}".strip() for u, numbers in runs)


def subject(key):
    """Keys of one subject may share a row."""
    return key.split(".")[0] if not key.startswith("porous.") else key in WICKING


def rows(values):
    """Values of one subject with the same basis and source share a row."""
    for (_, how, source), group in groupby(values, key=lambda value: (subject(value[0]), value[2], value[3])):
        group = list(group)
        keys = ", ".join(f"`{key}`" for key, *_ in group)
        notes = "; ".join(dict.fromkeys(note for *_, note in group))
        yield f"| {keys} | {joined(group)} | {how} | {source} | {notes} |"


def appendix(sources, fabrics):
    lines = ["## Sources", "", "| Source | Title | Data taken from it |", "|---|---|---|"]
    lines += [f"| {name} | [{s['title']}]({s['link']}) | {s['read']} |" for name, s in sources.items()]
    for name, fabric in fabrics.items():
        lines += ["", f"## {name}", "", f"{fabric['about'][0].upper()}{fabric['about'][1:]}.", "",
                  "| Key | Value | Basis | Source | Sample or computation |", "|---|---|---|---|---|", *rows(fabric["values"])]
    return "\n".join(lines)


def main():
    sources, fabrics = read(DATA.read_text(encoding="utf-8"))
    for path, tables in ((PAGE, overview(fabrics)), (APPENDIX, appendix(sources, fabrics))):
        page = path.read_text(encoding="utf-8")
        head, rest = page.split(BEGIN)
        made = f"{head}{BEGIN}\n\n{tables}\n\n{END}{rest.split(END)[1]}"
        if "--check" not in sys.argv[1:]:
            path.write_text(made, encoding="utf-8")
        elif made != page:
            sys.exit(f"{path} does not match {DATA}: run tools/fabrics_page.py")


if __name__ == "__main__":
    main()

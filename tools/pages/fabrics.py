#!/usr/bin/env python3
"""tools/pages/fabrics.py [--check]: writes the tables of docs/manual/fabrics.md and docs/manual/fabric_data.md, between their
marks, from src/scene/fabrics.yaml.

--check writes nothing: exit code 1 if a page differs from what would be written. Needs no YAML library: the file has one form."""

import re
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
import figures  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
DATA, PAGE, APPENDIX = (ROOT / name for name in ("src/scene/fabrics.yaml", "docs/manual/fabrics.md", "docs/manual/fabric_data.md"))
BEGIN, END = "<!-- made by tools/pages/fabrics.py: begin -->", "<!-- made by tools/pages/fabrics.py: end -->"
VALUE = re.compile(r'- \{key: (\S+), value: (\S+), how: (\w+), source: (\w+), note: "([^"]*)"\}(?: +#.*)?$')
SUBJECTS = {"Mass": ["areal_density"], "Thickness": ["thickness"],
            "Stretch and shear": ["membrane.warp", "membrane.weft", "membrane.shear"],
            "Bending": ["bending.warp", "bending.weft", "bending.twist"],
            "Solid fraction": ["porous.solid_fraction"], "Permeability": ["porous.permeability"],
            "Wicking": ["porous.diffusivity", "porous.diffusion_exponent", "porous.capillary_height"]}
UNITS = {"areal_density": "kg/m²", "thickness": "m", "membrane.warp": "N/m", "membrane.weft": "N/m", "membrane.shear": "N/m",
         "bending.warp": "N·m", "bending.weft": "N·m", "bending.twist": "N·m", "porous.permeability": "m²",
         "porous.diffusivity": "m²/s", "porous.capillary_height": "m"}

def read(text):
    """({source: {title, link, read}}, {fabric: {about, values: [(key, value, how, source, note)]}})"""
    parts, part, name = {"sources": {}, "fabrics": {}}, None, None
    for line in text.splitlines():
        if line.lstrip().startswith("#") or not line.strip():
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


def overview(fabrics):
    """One row per fabric, in the units that textile tables have."""
    lines = ["| `fabric` | Description | g/m² | mm | Own values |", "|---|---|---|---|---|"]
    for name, fabric in fabrics.items():
        value = {key: float(text) for key, text, *_ in fabric["values"]}
        own = sum(how in ("measured", "derived") for _, _, how, *_ in fabric["values"])
        lines.append(f"| `{name}` | {fabric['about']} | {1000 * value['areal_density']:.0f} | {1000 * value['thickness']:.2g} | {own} |")
    bases = [how for fabric in fabrics.values() for _, _, how, *_ in fabric["values"]]
    measured, derived, similar, assumed = (bases.count(how) for how in ("measured", "derived", "similar", "assumed"))
    return "\n".join(lines + ["", f"Of all {len(bases)} values {measured} are measured, {derived} derived, {similar} similar and {assumed} assumed."])


def subject(fabrics, title, keys):
    """A table of some keys. Fabrics with the same values of the same basis and source share a row."""
    shared = {}
    for name, fabric in fabrics.items():
        values = [value for value in fabric["values"] if value[0] in keys]
        bases = {value[2:4] for value in values}
        if len(values) != len(keys) or len(bases) != 1:
            sys.exit(f"{DATA}: {name}: {', '.join(keys)}: not all there, or of several bases or sources")
        (how, source), = bases
        notes = "; ".join(dict.fromkeys(value[4] for value in values))
        row = *(value[1] for value in values), how, source, notes
        shared.setdefault(row, []).append(f"`{name}`")
    heads = [f"`{key}`{', ' + UNITS[key] if key in UNITS else ''}" for key in keys]
    lines = ["", f"## {title}", "", f"| Fabric | {' | '.join(heads)} | Basis | Source | Sample or computation |",
             "|" + "---|" * (len(keys) + 4)]
    return lines + [f"| {', '.join(names)} | {' | '.join(row)} |" for row, names in shared.items()]


def appendix(sources, fabrics):
    lines = ["## Sources", "", "| Source | Title | Data taken from it |", "|---|---|---|"]
    lines += [f"| {name} | [{s['title']}]({s['link']}) | {s['read']} |" for name, s in sources.items()]
    for title, keys in SUBJECTS.items():
        lines += subject(fabrics, title, keys)
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
            sys.exit(f"{path} does not match {DATA}: run tools/pages/fabrics.py")
    if "--check" not in sys.argv[1:]:
        figures.write(ROOT)  # other pages have figures of these


if __name__ == "__main__":
    main()

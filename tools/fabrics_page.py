#!/usr/bin/env python3
"""tools/fabrics_page.py [--check]: writes the tables of docs/manual/fabrics.md from src/scene/fabrics.yaml, between its marks.

--check writes nothing: exit code 1 if the page is not what would be written. Needs no YAML library: the file has one form."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DATA, PAGE = ROOT / "src/scene/fabrics.yaml", ROOT / "docs/manual/fabrics.md"
BEGIN, END = "<!-- made by tools/fabrics_page.py: begin -->", "<!-- made by tools/fabrics_page.py: end -->"
VALUE = re.compile(r'- \{key: (\S+), value: (\S+), how: (\w+), source: (\w+), note: "(.*)"\}$')
UNITS = {"areal_density": "kg/m²", "thickness": "m", "membrane": "N/m", "bending": "N·m", "permeability": "m²",
         "diffusivity": "m²/s", "capillary_height": "m"}


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


def unit(key):
    return next((UNITS[word] for word in key.split(".") if word in UNITS), "1")


def tables(sources, fabrics):
    lines = ["| `fabric` | what it is | measured | derived | similar | assumed |", "|---|---|---|---|---|---|"]
    for name, fabric in fabrics.items():
        counts = [sum(value[2] == how for value in fabric["values"]) for how in ("measured", "derived", "similar", "assumed")]
        lines.append(f"| [`{name}`](#{name}) | {fabric['about']} | " + " | ".join(map(str, counts)) + " |")
    lines += ["", "## Sources", "", "| source | what it is | what of it was read |", "|---|---|---|"]
    lines += [f"| {name} | [{s['title']}]({s['link']}) | {s['read']} |" for name, s in sources.items()]
    for name, fabric in fabrics.items():
        lines += ["", f"## {name}", "", f"{fabric['about'][0].upper()}{fabric['about'][1:]}.", "",
                  "| key | value | unit | | source | which, or how |", "|---|---|---|---|---|---|"]
        lines += [f"| `{key}` | {value} | {unit(key)} | {how} | {source} | {note} |" for key, value, how, source, note in fabric["values"]]
    return "\n".join(lines)


def main():
    page = PAGE.read_text(encoding="utf-8")
    head, rest = page.split(BEGIN)
    made = f"{head}{BEGIN}\n\n{tables(*read(DATA.read_text(encoding='utf-8')))}\n\n{END}{rest.split(END)[1]}"
    if "--check" in sys.argv[1:]:
        if made != page:
            sys.exit(f"{PAGE} is not what {DATA} says: run tools/fabrics_page.py")
    else:
        PAGE.write_text(made, encoding="utf-8")


if __name__ == "__main__":
    main()

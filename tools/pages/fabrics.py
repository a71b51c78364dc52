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
VALUE = re.compile(r'- \{key: (?P<key>\S+), value: (?P<value>\S+), how: (?P<how>\w+),(?: of: (?P<of>\w+),)? source: (?P<source>\w+), '
                   r'note: "(?P<note>[^"]*)"\}(?: +#.*)?$')
SUBJECTS = {"Mass": ["areal_density"], "Thickness": ["thickness"],
            "Stretch and shear": ["membrane.warp", "membrane.weft", "membrane.shear"],
            "Bending": ["bending.warp", "bending.weft", "bending.twist"],
            "Solid fraction": ["porous.solid_fraction"], "Permeability": ["porous.permeability"],
            "Wicking": ["porous.diffusivity", "porous.diffusion_exponent", "porous.capillary_height"]}


def read(text):
    """({key: unit}, {source: {title, link, read}}, {fabric: {about, values: [{key, value, how, of, source, note}]}})"""
    units, sources, fabrics = {}, {}, {}
    parts, part, name = {"units": units, "sources": sources, "fabrics": fabrics}, None, None
    for line in text.splitlines():
        if line.lstrip().startswith("#") or not line.strip():
            continue
        if top := re.fullmatch(r"(\w+):", line):
            part = parts[top[1]]
        elif unit := re.fullmatch(r'  ([\w.]+): "(.*)"', line):
            units[unit[1]] = unit[2]
        elif entry := re.fullmatch(r"  (\w+):", line):
            name = entry[1]
            part[name] = {"values": []}
        elif value := VALUE.search(line):
            part[name]["values"].append(value.groupdict())
        elif field := re.fullmatch(r'    (\w+): "(.*)"', line):
            part[name][field[1]] = field[2]
        elif line.strip() != "values:":
            sys.exit(f"{DATA}: not read: {line}")
    return units, sources, fabrics


def numbers(fabric):
    return {value["key"]: float(value["value"]) for value in fabric["values"]}


def basis(fabrics, values):
    """How some values of a fabric are known, as `drench check` prints it: one basis, and the fabric that they were taken from."""
    found = {(value["how"], value["of"]) for value in values}
    if len(found) != 1:
        sys.exit(f"{DATA}: {', '.join(value['key'] for value in values)}: of several bases or fabrics")
    (how, of), = found
    if not of:
        return how
    ratios = {value["key"]: float(value["value"]) / numbers(fabrics[of])[value["key"]] for value in values}
    changed = [f", {key.split('.')[-1]} times {ratio:.3g}" for key, ratio in ratios.items() if abs(ratio - 1) > 1e-6]
    return f"{how}: of `{of}`{''.join(changed)}"


def values_of(fabric, keys):
    return [value for value in fabric["values"] if value["key"] in keys]


def overview(fabrics):
    """One row per fabric, in the units that textile tables have, and one with the basis of each group of values."""
    lines = ["| `fabric` | Description | g/m² | mm | Own values |", "|---|---|---|---|---|"]
    for name, fabric in fabrics.items():
        value = numbers(fabric)
        own = sum(v["how"] in ("measured", "derived") for v in fabric["values"])
        lines.append(f"| `{name}` | {fabric['about']} | {1000 * value['areal_density']:.0f} | {1000 * value['thickness']:.2g} | {own} |")
    bases = [v["how"] for fabric in fabrics.values() for v in fabric["values"]]
    measured, derived, similar, assumed = (bases.count(how) for how in ("measured", "derived", "similar", "assumed"))
    return "\n".join(lines + ["", f"Of all {len(bases)} values {measured} are measured, {derived} derived, {similar} similar and {assumed} assumed."])


def listed(fabrics, names):
    """The names, with all fabrics of socks as one."""
    socks = [name for name in fabrics if name.startswith("sock_")]
    if set(socks) <= set(names):
        names = [name for name in names if name not in socks] + ["sock_…"]
    return ", ".join(f"`{name}`" for name in names)


def table_of_bases(fabrics):
    """Fabrics whose values have the same bases share a row."""
    shared = {}
    for name, fabric in fabrics.items():
        row = tuple(basis(fabrics, values_of(fabric, keys)) for keys in SUBJECTS.values())
        shared.setdefault(row, []).append(name)
    lines = ["| `fabric` | " + " | ".join(SUBJECTS) + " |", "|" + "---|" * (len(SUBJECTS) + 1)]
    return "\n".join(lines + [f"| {listed(fabrics, names)} | {' | '.join(row)} |" for row, names in shared.items()])


def subject(units, fabrics, title, keys):
    """A table of some keys. Fabrics with the same values of the same basis and source share a row. A value that all fabrics have
    stands above the table."""
    shared, common = {}, {}
    for key in keys:
        found = {value["value"] for fabric in fabrics.values() for value in fabric["values"] if value["key"] == key}
        if len(found) == 1:
            common[key] = found.pop()
    keys_shown = [key for key in keys if key not in common]
    for name, fabric in fabrics.items():
        values = values_of(fabric, keys)
        sources = {value["source"] for value in values}
        if len(values) != len(keys) or len(sources) != 1:
            sys.exit(f"{DATA}: {name}: {', '.join(keys)}: not all there, or of several sources")
        notes = "; ".join(dict.fromkeys(value["note"] for value in values))
        row = *(value["value"] for value in values if value["key"] in keys_shown), f"{basis(fabrics, values)} ({', '.join(sources)})", notes
        shared.setdefault(row, []).append(name)
    heads = [f"`{key}`{', ' + units[key] if key in units else ''}" for key in keys_shown]
    lines = ["", f"## {title}", ""]
    for key, value in common.items():
        lines += [f"All fabrics have `{key}` {value}.", ""]
    lines += [f"| Fabric | {' | '.join(heads)} | Basis (source) | Sample or computation |", "|" + "---|" * (len(keys_shown) + 3)]
    return lines + [f"| {listed(fabrics, names)} | {' | '.join(row)} |" for row, names in shared.items()]


def appendix(units, sources, fabrics):
    lines = ["## Sources", "", "| Source | Title | Data taken from it |", "|---|---|---|"]
    lines += [f"| {name} | [{s['title']}]({s['link']}) | {s['read']} |" for name, s in sources.items()]
    for title, keys in SUBJECTS.items():
        lines += subject(units, fabrics, title, keys)
    return "\n".join(lines)


def main():
    units, sources, fabrics = read(DATA.read_text(encoding="utf-8"))
    for path, parts in ((PAGE, (overview(fabrics), table_of_bases(fabrics))), (APPENDIX, (appendix(units, sources, fabrics),))):
        page = path.read_text(encoding="utf-8")
        made, *rest = page.split(BEGIN)
        if len(rest) != len(parts):
            sys.exit(f"{path} has {len(rest)} places for tables instead of {len(parts)}")
        for table, after in zip(parts, rest):
            made += f"{BEGIN}\n\n{table}\n\n{END}{after.split(END)[1]}"
        if "--check" not in sys.argv[1:]:
            path.write_text(made, encoding="utf-8")
        elif made != page:
            sys.exit(f"{path} does not match {DATA}: run tools/pages/fabrics.py")
    if "--check" not in sys.argv[1:]:
        figures.write(ROOT)  # other pages have figures of these


if __name__ == "__main__":
    main()

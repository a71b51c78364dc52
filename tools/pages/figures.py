"""Figures that stand on several pages (tools/docs figures). docs/benchmarks/figures.json lists each figure once, and pages
mark where they use it: `<!--fig:NAME-->7.2<!--/fig-->`. Neither GitHub nor the HTML site shows the marks.

A figure has `value` (the text on the pages), `unit`, `of` (a description) and `source`, a key of `sources`, which states
the measuring tool, machine, date and conditions. If the source has a `page`, the value is computed from it:

  cells      ["HEADING | CELL & OTHER=CELL | COLUMN"]: a number of a table below the heading that begins so, in this column of
             the row that has these cells, the second one in column OTHER
  quotients  [["CELL'S REFERENCE", "CELL'S REFERENCE"]]: the first number divided by the second
  pattern    a regular expression whose group is the number

`pick` chooses the "least" or "most" of several numbers, which is multiplied by `scale` and rounded to `decimals`.
`tools/docs figures --write` computes all values and puts them into the pages."""

import json
import re
from decimal import ROUND_HALF_UP, Decimal

from page_text import CODE, FIGURE, files, text_lines
from tables import tables

DATA = "docs/benchmarks/figures.json"
OPEN = "<!--fig:"


class Wrong(Exception):
    """A figure that cannot be computed."""


def plain(cell):
    return re.sub(r"[*`]", "", cell).strip()


def number(text):
    found = re.search(r"-?\d*\.?\d+(?:e[+-]?\d+)?", text.replace(",", ""), re.I)
    if not found:
        raise Wrong(f"no number in {text!r}")
    return Decimal(found[0])


def headings(text):
    """[(number of its line, level, heading)]"""
    return [(at, len(found[1]), found[2]) for at, line, block in text_lines(text)
            if not block and (found := re.match(r"^(#{1,6})\s+(.*)", line))]


def section(text, heading):
    """First and last line of what stands below a heading."""
    found = headings(text)
    for k, (at, level, name) in enumerate(found):
        if name.startswith(heading):
            return at, next((end for end, other, _ in found[k + 1:] if other <= level), len(text.splitlines()) + 1)
    raise Wrong(f"no heading {heading!r}")


def has(head, row, condition):
    column, _, wanted = condition.partition("=")
    return row[head.index(column)] == wanted if column in head else condition in row


def cell(text, reference):
    heading, wanted, column = reference.split(" | ")
    first, last = section(text, heading)
    found = []
    for at, head, rows in tables(text):
        head = [plain(name) for name in head]
        if first < at < last and column in head:
            for _, row in rows[1:]:
                row = [plain(one) for one in row]
                if len(row) == len(head) and all(has(head, row, one) for one in wanted.split(" & ")):
                    found.append(row[head.index(column)])
    if len(found) != 1:
        raise Wrong(f"{len(found)} cells are {reference!r}")
    return number(found[0])


def shown(value, decimals):
    return f"{value.quantize(Decimal(1).scaleb(-decimals), ROUND_HALF_UP):,f}"


def computed(root, figure, sources):
    """The text that the figure's source has now, or its value where no page has it."""
    if not figure.keys() & {"cells", "quotients", "pattern"}:
        return figure["value"]
    page = sources[figure["source"]]["page"]
    if not (root / page).is_file():
        raise Wrong(f"{page} is not in the tree")
    text = FIGURE.sub(lambda found: found[2], (root / page).read_text(encoding="utf-8"))
    try:
        values = [cell(text, one) for one in figure.get("cells", [])]
        values += [cell(text, top) / cell(text, bottom) for top, bottom in figure.get("quotients", [])]
        if "pattern" in figure:
            if not (found := re.search(figure["pattern"], text)):
                raise Wrong(f"nothing matches {figure['pattern']!r}")
            values.append(number(found[1]))
    except Wrong as wrong:
        raise Wrong(f"{page}: {wrong}") from None
    value = max(values) if figure.get("pick") == "most" else min(values)
    return shown(value * Decimal(str(figure.get("scale", 1))), figure.get("decimals", 0))


def read(root):
    path = root / DATA
    data = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return data.get("sources", {}), data.get("figures", {})


def dump(sources, figures):
    """One line per source and figure."""
    parts = []
    for name, entries in (("sources", sources), ("figures", figures)):
        lines = ",\n".join(f"    {json.dumps(key)}: {json.dumps(entry, ensure_ascii=False)}" for key, entry in entries.items())
        parts.append(f'  "{name}": {{\n{lines}\n  }}')
    return "{\n" + ",\n".join(parts) + "\n}\n"


def update(root):
    """Computes the values in the data file again."""
    sources, figures = read(root)
    for figure in figures.values():
        try:
            figure["value"] = computed(root, figure, sources)
        except Wrong:
            pass  # check reports it
    if figures and (root / DATA).read_text(encoding="utf-8") != (text := dump(sources, figures)):
        (root / DATA).write_text(text, encoding="utf-8")


def write(root):
    """Updates the data file and all pages."""
    update(root)
    _, figures = read(root)
    for page in files(root, {".md"}):
        text = page.read_text(encoding="utf-8")
        made = FIGURE.sub(lambda found: f"{OPEN}{found[1]}-->{figures[found[1]]['value']}<!--/fig-->"
                          if found[1] in figures else found[0], text)
        if made != text:
            page.write_text(made, encoding="utf-8")


def check(root):
    """(offenders, number of figures, number of places)."""
    sources, figures = read(root)
    offenders, used, places = [], set(), 0
    for page in files(root, {".md"}):
        text = page.read_text(encoding="utf-8")
        if OPEN not in text:
            continue
        for line, (at, _, block) in zip(text.splitlines(), text_lines(text)):
            line = CODE.sub("", line)
            where = f"{page.relative_to(root)}:{at}"
            found = FIGURE.findall(line)
            if line.count("<!--fig:") != len(found) or line.count("<!--/fig-->") != len(found):
                offenders.append(f"{where}: the mark of a figure is not closed")
            if found and block:
                offenders.append(f"{where}: a block of code shows the marks of a figure")
            if re.match(r"^\s*(?:>\s?)*(?:[-*+]\s+|\d+[.)]\s+)?<!--fig:", line):
                offenders.append(f"{where}: a figure begins the line, which makes it a comment")
            for name, value in found:
                places += 1
                used.add(name)
                if name not in figures:
                    offenders.append(f"{where}: figure {name} is not in {DATA}")
                elif value != figures[name]["value"]:
                    offenders.append(f"{where}: figure {name} is {figures[name]['value']}, not {value}")
    for name, figure in figures.items():
        if name not in used:
            offenders.append(f"{DATA}: no page uses {name}")
        if figure["source"] not in sources:
            offenders.append(f"{DATA}: {name}: no source {figure['source']}")
            continue
        try:
            if (value := computed(root, figure, sources)) != figure["value"]:
                offenders.append(f"{DATA}: {name} is {figure['value']}, {sources[figure['source']]['page']} has {value}")
        except Wrong as wrong:
            offenders.append(f"{DATA}: {name}: {wrong}")
    return offenders, len(figures), places

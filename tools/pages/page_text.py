"""How a page in Markdown is read by tools/docs: which pages there are, and their text without code and formulas."""

import re

LEFT_OUT = {".git", ".deps", "build", "out"}  # folders whose files are not ours
FENCE = re.compile(r"^\s*(```+|~~~+)")
FIGURE = re.compile(r"<!--fig:([\w.]+)-->(.*?)<!--/fig-->")  # tools/pages/figures.py
CODE = re.compile(r"(`+)(?!`)(.+?)(?<!`)\1(?!`)")


def files(root, suffixes):
    """All files of the tree with one of these suffixes, sorted."""
    found = []
    for entry in sorted(root.iterdir()):
        if entry.is_dir() and not entry.is_symlink():
            if entry.name not in LEFT_OUT:
                found += files(entry, suffixes)
        elif entry.suffix in suffixes:
            found.append(entry)
    return found


def text_lines(text):
    """[(number, line, block)] of a page; `block` is True in a block of code or of a displayed formula, and in a comment.
    Figures stand without their marks."""
    fence = formula = comment = None
    lines = []
    for number, line in enumerate(text.splitlines(), 1):
        mark = FENCE.match(line)
        if fence:
            lines.append((number, line, True))
            if mark and mark[1].startswith(fence) and not line.strip().strip(fence[0]):
                fence = None
            continue
        if mark and not formula and not comment:
            fence = mark[1]
            lines.append((number, line, True))
            continue
        line = FIGURE.sub(lambda found: found[2], line)
        dollars = CODE.sub("", line).count("$$")
        lines.append((number, line, bool(formula or comment or dollars or "<!--" in line)))
        formula = bool(formula) ^ bool(dollars % 2)
        if "<!--" in line or comment:
            comment = "-->" not in line
    return lines

"""Tables of a page (tools/docs tables): each row has as many cells as the head, and a blank line or a heading precedes the head.

GitHub drops excess cells without a warning. A `|` within code or a formula also splits a cell; write `\\|` there. Without a
blank line the HTML site shows the table as text."""

import re

from page_text import files, text_lines

DELIMITER = re.compile(r"^\s*\|?\s*:?-+:?\s*(\|\s*:?-+:?\s*)*\|?\s*$")


def cells(line):
    """The cells of a row, or [] if the line is not one."""
    line = re.sub(r"^\s*(?:>\s?)*", "", line).strip()
    if "|" not in line:
        return []
    line = re.sub(r"(?<!\\)\|$", "", line.removeprefix("|"))
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line)]


def tables(text):
    """[(number of the head's line, head, rows)]; a row is (number of its line, cells)."""
    lines = text_lines(text)
    for at in range(len(lines) - 1):
        number, head, block = lines[at]
        delimiter = lines[at + 1]
        if block or delimiter[2] or not cells(head) or "|" not in delimiter[1] or not DELIMITER.match(delimiter[1]):
            continue
        rows = []
        for row, line, inside in lines[at + 2:]:
            if inside or not line.strip():
                break
            rows.append((row, cells(line)))
        yield number, cells(head), [(delimiter[0], cells(delimiter[1])), *rows]


def check(root):
    """(offenders, number of tables)."""
    offenders, count = [], 0
    for page in files(root, {".md"}):
        name, text = page.relative_to(root), page.read_text(encoding="utf-8")
        lines = text.splitlines()
        for number, head, rows in tables(text):
            count += 1
            if number > 1 and lines[number - 2].strip() and not lines[number - 2].startswith("#"):
                offenders.append(f"{name}:{number}: no blank line before the table")
            for at, row in rows:
                if len(row) != len(head):
                    offenders.append(f"{name}:{at}: a row of {len(row)} cells in a table of {len(head)} columns")
    return offenders, count

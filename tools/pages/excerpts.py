"""Excerpts in the books: a block of code below `<!-- source: FILE -->` stands in that file, line for line."""

import re


def check(root):
    """(offenders, number of excerpts)."""
    offenders, count = [], 0
    for page in sorted((root / "docs").rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        for found in re.finditer(r"<!-- source: (\S+) -->\n```\w*\n(.*?)```", text, re.S):
            count += 1
            at = f"{page.relative_to(root)}:{text.count(chr(10), 0, found.start()) + 1}"
            source = root / found[1]
            if not source.is_file():
                offenders.append(f"{at}: excerpt of {found[1]}, which is not in the tree")
            elif "\n" + found[2] not in "\n" + source.read_text(encoding="utf-8"):
                offenders.append(f"{at}: excerpt is not in {found[1]} as it stands here")
    return offenders, count

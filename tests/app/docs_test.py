#!/usr/bin/env python3
"""docs_test.py SOURCE: tools/docs finds what is wrong with pages that are wrong, and nothing wrong with ours; CITATION.cff,
README.md and CHANGELOG.md name the version. Exit code 77, skipped, where Doxygen is missing and nothing else is wrong."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(sys.argv[1]).resolve()
GOOD = """# Good page
Two short sentences stand here. The second, of e.g. ten words, is not split at its abbreviation.

- an item of eleven words that ends without any full stop at all
- another one, which must not be joined to the item before it, for then both would be too long
  1. nested: `code with very many words that are not counted at all as they are code and no prose of ours`

| a table | is left out however long its cells are, for nobody reads a table as a sentence, and so on and on and on, on |
|---|---|

```
what stands in a block of code is left out too, and it may be as long as anybody wants it to be, on and on and on and on and on
[no link](nowhere.txt)
```
$$ a = \\text{formulas are left out, with as many words as anybody likes to put into their text, one two three four five six} $$

<!-- source: docs/code.cpp -->
```cpp
// as docs/good.md has it
```

## Twice
## Twice
| scene | s | errors |
|---|---|---|
| `falling` | 0.0072 | 6.3e-03 |
| **resting** | <!--fig:rest-->0.0031<!--/fig--> | a \\| b |

Both take <!--fig:time-->7.2<!--/fig--> ms and <!--fig:rest-->0.0031<!--/fig--> s, a ratio of <!--fig:ratio-->2.32<!--/fig-->; `<!--fig:code-->1<!--/fig-->`.

[this page](#good-page), [again](good.md#twice-1), [a line](code.cpp#L2), ![picture](../picture.png), `[no](link.txt)`
"""
FIGURES = """{"sources": {"good": {"page": "docs/good.md"}, "hand": {}}, "figures": {
"time": {"value": "7.2", "source": "good", "cells": ["Good page | falling | s", "Good page | resting | s"], "pick": "most", "scale": 1000, "decimals": 1},
"ratio": {"value": "2.32", "source": "good", "quotients": [["Good page | falling | s", "Good page | scene=resting | s"]], "decimals": 2},
"rest": {"value": "0.0031", "source": "hand"}}}
"""
LONG = "This sentence " + "goes on and on " * 9 + "to its end."
MEAN = "- " + "word " * 33 + "\n- " + "word " * 8
# A page's text, and what must be said of it.
BAD = {
    "long": (LONG, "docs/long.md:1: 41 words"),
    "long_by_lines": ("Fine.\n\nIt begins here\n" + "and goes on\n" * 12 + "to its end.", "docs/long_by_lines.md:3: 42 words"),
    "long_item": ("A list:\n\n- short\n- " + LONG, "docs/long_item.md:4: 41 words"),
    "mean": (MEAN, "docs/mean.md:1: 20.5 words a sentence on average"),
    "what": ("Good.\nWhat it does is this.", 'docs/what.md:2: a sentence begins with "what"'),
    "nowhere": ("[a page](absent.md)", "docs/nowhere.md:1: link absent.md leads nowhere"),
    "picture": ("\n![a picture](absent.png)", "docs/picture.md:2: link absent.png leads nowhere"),
    "anchor": ("[an anchor](good.md#absent)", "docs/anchor.md:1: link good.md#absent has no such anchor"),
    "third": ("[an anchor](good.md#twice-2)", "docs/third.md:1: link good.md#twice-2 has no such anchor"),
    "own": ("[an anchor](#twice)", "docs/own.md:1: link #twice has no such anchor"),
    "past": ("[a line](code.cpp#L9)", "docs/past.md:1: link code.cpp#L9 is longer than the file"),
    "out": ("[a page](../../README.md)", "docs/out.md:1: link ../../README.md leads out of the tree"),
    "definition": ("See [it][1].\n\n[1]: absent.md", "docs/definition.md:3: link absent.md leads nowhere"),
    "excerpt": ("<!-- source: docs/code.cpp -->\n```cpp\n// as it is not\n```",
                "docs/excerpt.md:1: excerpt is not in docs/code.cpp"),
    "excerpt_of": ("<!-- source: absent.cpp -->\n```cpp\n```", "docs/excerpt_of.md:1: excerpt of absent.cpp"),
    "cells": ("| a | b |\n|---|---|\n| 1 | 2 |\n| `x | y` | 3 |", "docs/cells.md:4: a row of 3 cells in a table of 2 columns"),
    "few": ("| a | b |\n|---|---|\n| 1 |", "docs/few.md:3: a row of 1 cells in a table of 2 columns"),
    "delimiter": ("| a | b |\n|---|\n| 1 | 2 |", "docs/delimiter.md:2: a row of 1 cells in a table of 2 columns"),
    "blank": ("Text.\n| a | b |\n|---|---|\n| 1 | 2 |", "docs/blank.md:2: no blank line before the table"),
    "other": ("It takes <!--fig:time-->8<!--/fig--> ms.", "docs/other.md:1: figure time is 7.2, not 8"),
    "unknown": ("It takes <!--fig:speed-->8<!--/fig--> ms.", "docs/unknown.md:1: figure speed is not in docs/benchmarks/figures.json"),
    "open": ("It takes <!--fig:time-->7.2 ms.", "docs/open.md:1: the mark of a figure is not closed"),
    "first": ("<!--fig:time-->7.2<!--/fig--> ms are needed.", "docs/first.md:1: a figure begins the line"),
    "block": ("```\n<!--fig:time-->7.2<!--/fig-->\n```", "docs/block.md:2: a block of code shows the marks of a figure"),
    "named": ("See `absent_page.md`.", "docs/named.md:1: names absent_page.md, which is not in the tree"),
}


CHECKS = ("prose", "links", "excerpts", "figures", "tables")


def docs(root, *arguments):
    ran = subprocess.run([SOURCE / "tools/docs", "--root", root, *arguments], capture_output=True, text=True)
    return ran.returncode, ran.stdout + ran.stderr


def expect(good, message):
    if not good:
        sys.exit(f"docs_test: {message}")


def check_figures(root):
    """A new measurement is reported, and --write puts it into the data file and the pages."""
    page, data = root / "docs/good.md", root / "docs/benchmarks/figures.json"
    page.write_text(GOOD.replace("| 0.0072 |", "| 0.0093 |"))
    code, said = docs(root, "figures")
    expect(code == 1 and "figures.json: time is 7.2, docs/good.md has 9.3" in said, f"a new measurement passes:\n{said}")
    code, said = docs(root, "figures", "--write")
    expect(code == 0 and "-->9.3<!--" in page.read_text() and "-->3.00<!--" in page.read_text(), f"it is not written:\n{said}")
    page.write_text(GOOD.replace("falling", "fell").replace("<!--fig:ratio-->2.32<!--/fig-->", "2"))
    code, said = docs(root, "figures")
    expect("figures.json: no page uses ratio" in said, f"a figure need not be used:\n{said}")
    expect("time: docs/good.md: 0 cells are 'Good page | falling | s'" in said, f"a cell that is missing is no error:\n{said}")
    page.write_text(GOOD)
    data.write_text(FIGURES)


def check_the_checks():
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "tree"
        (root / "docs/benchmarks").mkdir(parents=True)
        (root / "docs/benchmarks/figures.json").write_text(FIGURES)
        (root / "picture.png").touch()
        (root / "docs/code.cpp").write_text("// as docs/good.md has it\n\n")
        (root / "docs/good.md").write_text(GOOD)
        code, said = docs(root, *CHECKS)
        expect(code == 0 and "4 links" in said and "1 blocks" in said and "3 figures in 4 places" in said and "2 tables" in said, f"a good page is not:\n{said}")
        for name, (text, message) in BAD.items():
            page = root / "docs" / f"{name}.md"
            page.write_text(text + "\n")
            code, said = docs(root, *CHECKS)
            offenders = [line for line in said.splitlines() if not line.startswith(tuple(f"{check}:" for check in CHECKS))]
            expect(code == 1, f"{name}.md passes")
            expect(any(line.startswith(message) for line in offenders), f"'{message}' is not said of {name}.md:\n{said}")
            page.unlink()
        check_figures(root)
        (root / "docs/code.cpp").write_text("// gone: absent_page.md\n\n")
        code, said = docs(root, "links")
        expect(code == 1 and "docs/code.cpp:1: names absent_page.md" in said, f"a comment may name any page:\n{said}")


def check_citation():
    version = re.search(r"^project\(drench VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(), re.M)
    expect(f"\nversion: {version[1]}\n" in (SOURCE / "CITATION.cff").read_text(), f"CITATION.cff is not of {version[1]}")
    expect(f"version = {{{version[1]}}}" in (SOURCE / "README.md").read_text(), f"README.md's BibTeX is not of {version[1]}")
    newest = re.search(r"^## (\S+)", (SOURCE / "CHANGELOG.md").read_text(), re.M)
    expect(newest[1] in (version[1], "Unreleased"), f"CHANGELOG.md begins with {newest[1]}, the version is {version[1]}")


check_the_checks()
check_citation()
code, said = docs(SOURCE)
print(said, end="")
sys.exit(code)

#!/usr/bin/env python3
"""docs_test.py SOURCE: tools/docs reports the problems of bad pages and none in this tree, and updates figures; CITATION.cff,
README.md and CHANGELOG.md name the version. Exit code 77, skipped, where Doxygen is missing and nothing else is wrong."""

import re
import sys
import unittest

from support import SOURCE, Case, call

CHECKS = ("idioms", "links", "excerpts", "figures", "tables")
DATA = "docs/benchmarks/figures.json"
FIGURES = """{"sources": {"good": {"page": "docs/good.md"}, "hand": {}}, "figures": {
"time": {"value": "7.2", "source": "good", "cells": ["Times | falling | s", "Times | resting | s"], "pick": "most", "scale": 1000, "decimals": 1},
"ratio": {"value": "2.32", "source": "good", "quotients": [["Times | falling | s", "Times | scene=resting | s"]], "decimals": 2},
"cases": {"value": "1,204", "source": "good", "pattern": "all ([0-9,]+) cases"},
"rest": {"value": "0.0031", "source": "hand"}}}
"""
GOOD = """# Good page
- an item that ends without a full stop
  1. nested: `code in place of prose`, which is not searched for idioms

| a table | `is refused` |
|---|---|

```
what stands in a block of code is left out too, in place of nothing
[no link](nowhere.txt)
```
$$ a = \\text{formulas are left out, in place of nothing} $$

<!-- source: docs/code.cpp -->
```cpp
// as docs/good.md has it
```

## Twice
## Twice
[this page](#good-page), [again](good.md#twice-1), [a line](code.cpp#L2), ![picture](../picture.png), `[no](link.txt)`

Both take <!--fig:time-->7.2<!--/fig--> ms and <!--fig:rest-->0.0031<!--/fig--> s, a ratio of <!--fig:ratio-->2.32<!--/fig-->.
In code a mark is text: `<!--fig:code-->1<!--/fig-->`. Of all 1204 cases <!--fig:cases-->1,204<!--/fig--> are met.

## Times
| scene | s | errors |
|---|---|---|
| `falling` | 0.0072 | 6.3e-03 |
| **resting** | <!--fig:rest-->0.0031<!--/fig--> | a \\| b |
"""
# A page's text, and what must be reported for docs/bad.md.
BAD = [
    ("Good.\nWhat it does is this.", '2: "What it does is this."'),
    ("Use a key\nin place\nof another.", '2: "in place of"'),
    ("| Key | Use |\n|---|---|\n| `a` | is refused |", '3: "is refused"'),
    ("# The books", '1: "books"'),
    ("- Then the log says why.", '1: "the log says"'),
    ("[a page](absent.md)", "1: link absent.md leads nowhere"),
    ("[an anchor](good.md#twice-2)", "1: link good.md#twice-2 has no such anchor"),
    ("[an anchor](#twice)", "1: link #twice has no such anchor"),
    ("[a line](code.cpp#L9)", "1: link code.cpp#L9 is longer than the file"),
    ("[a page](../../README.md)", "1: link ../../README.md leads out of the tree"),
    ("See [it][1].\n\n[1]: absent.md", "3: link absent.md leads nowhere"),
    ("<!-- source: docs/code.cpp -->\n```cpp\n// as it is not\n```", "1: excerpt is not in docs/code.cpp"),
    ("<!-- source: absent.cpp -->\n```cpp\n```", "1: excerpt of absent.cpp"),
    ("See `absent_page.md`.", "1: names absent_page.md, which is not in the tree"),
    ("| a | b |\n|---|---|\n| 1 | 2 |\n| `x | y` | 3 |", "4: a row of 3 cells in a table of 2 columns"),
    ("| a | b |\n|---|\n| 1 | 2 |", "2: a row of 1 cells in a table of 2 columns"),
    ("Text.\n| a | b |\n|---|---|\n| 1 | 2 |", "2: no blank line before the table"),
    ("It takes <!--fig:time-->8<!--/fig--> ms.", "1: figure time is 7.2, not 8"),
    ("It takes <!--fig:speed-->8<!--/fig--> ms.", f"1: figure speed is not in {DATA}"),
    ("It takes <!--fig:time-->7.2 ms.", "1: the mark of a figure is not closed"),
    ("<!--fig:time-->7.2<!--/fig--> ms are needed.", "1: a figure begins the line"),
    ("```\n<!--fig:time-->7.2<!--/fig-->\n```", "2: a block of code shows the marks of a figure"),
]


class Docs(Case):
    def setUp(self):
        super().setUp()
        self.write("picture.png", "")
        self.write("docs/code.cpp", "// as docs/good.md has it\n\n")
        self.page, self.data = self.write("docs/good.md", GOOD), self.write(DATA, FIGURES)

    def docs(self, code, *arguments):
        ran = call(SOURCE / "tools/docs", "--root", self.folder, *arguments)
        self.assertEqual(ran.returncode, code, ran.stdout + ran.stderr)
        return ran.stdout + ran.stderr

    def test_good_page(self):
        printed = self.docs(0, *CHECKS)
        for summary in ("4 links", "1 quoted", "4 figures in 5 places", "2 tables"):
            self.assertIn(summary, printed)
        self.write("docs/dev/note.md", "In place of this.\n")  # idioms of pages for developers are not searched
        self.docs(0, "idioms")

    def test_bad_pages(self):
        for text, message in BAD:
            with self.subTest(message):
                self.write("docs/bad.md", text + "\n")
                self.assertIn(f"\ndocs/bad.md:{message}", "\n" + self.docs(1, *CHECKS))
        self.write("docs/bad.md", "")
        self.write("docs/code.cpp", "// gone: absent_page.md\n\n")
        self.assertIn("docs/code.cpp:1: names absent_page.md", self.docs(1, "links"))

    def test_new_measurement(self):
        self.page.write_text(GOOD.replace("| 0.0072 |", "| 0.0093 |"))
        self.assertIn(f"{DATA}: time is 7.2, docs/good.md has 9.3", self.docs(1, "figures"))
        self.docs(0, "figures", "--write")
        self.assertIn("-->9.3<!--", self.page.read_text())
        self.assertIn("-->3.00<!--", self.page.read_text())
        self.assertIn('"value": "9.3"', self.data.read_text())

    def test_figure_without_use_or_cell(self):
        self.page.write_text(GOOD.replace("falling", "fell").replace("<!--fig:ratio-->2.32<!--/fig-->", "2"))
        printed = self.docs(1, "figures")
        self.assertIn(f"{DATA}: no page uses ratio", printed)
        self.assertIn(f"{DATA}: time: docs/good.md: 0 cells are 'Times | falling | s'", printed)


class Version(unittest.TestCase):
    def test_it_is_named(self):
        version = re.search(r"^project\(drench VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(), re.M)[1]
        self.assertIn(f"\nversion: {version}\n", (SOURCE / "CITATION.cff").read_text())
        self.assertIn(f"version = {{{version}}}", (SOURCE / "README.md").read_text())
        newest = re.search(r"^## (\S+)", (SOURCE / "CHANGELOG.md").read_text(), re.M)[1]
        self.assertIn(newest, (version, "Unreleased"))


if __name__ == "__main__":
    done = unittest.main(argv=sys.argv[:1], exit=False).result
    tree = call(SOURCE / "tools/docs")
    print(tree.stdout, tree.stderr, sep="", end="")
    sys.exit(tree.returncode if done.wasSuccessful() else 1)

#!/usr/bin/env python3
"""docs_figures_test.py SOURCE: tools/docs reports figures that differ from their measured table, and broken tables; --write
updates the data file and the pages."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SOURCE = Path(sys.argv[1]).resolve()
DATA = "docs/benchmarks/figures.json"
FIGURES = """{"sources": {"good": {"page": "docs/good.md"}, "hand": {}}, "figures": {
"time": {"value": "7.2", "source": "good", "cells": ["Times | falling | s", "Times | resting | s"], "pick": "most", "scale": 1000, "decimals": 1},
"ratio": {"value": "2.32", "source": "good", "quotients": [["Times | falling | s", "Times | scene=resting | s"]], "decimals": 2},
"cases": {"value": "1,204", "source": "good", "pattern": "all ([0-9,]+) cases"},
"rest": {"value": "0.0031", "source": "hand"}}}
"""
GOOD = """# Good page

Both take <!--fig:time-->7.2<!--/fig--> ms and <!--fig:rest-->0.0031<!--/fig--> s, a ratio of <!--fig:ratio-->2.32<!--/fig-->.
In code a mark is text: `<!--fig:code-->1<!--/fig-->`. Of all 1204 cases <!--fig:cases-->1,204<!--/fig--> are met.

## Times
| scene | s | errors |
|---|---|---|
| `falling` | 0.0072 | 6.3e-03 |
| **resting** | <!--fig:rest-->0.0031<!--/fig--> | a \\| b |
"""
# A page's text, and the problem that must be reported.
BAD = {
    "cells": ("| a | b |\n|---|---|\n| 1 | 2 |\n| `x | y` | 3 |", "docs/cells.md:4: a row of 3 cells in a table of 2 columns"),
    "few": ("| a | b |\n|---|---|\n| 1 |", "docs/few.md:3: a row of 1 cells in a table of 2 columns"),
    "delimiter": ("| a | b |\n|---|\n| 1 | 2 |", "docs/delimiter.md:2: a row of 1 cells in a table of 2 columns"),
    "blank": ("Text.\n| a | b |\n|---|---|\n| 1 | 2 |", "docs/blank.md:2: no blank line before the table"),
    "other": ("It takes <!--fig:time-->8<!--/fig--> ms.", "docs/other.md:1: figure time is 7.2, not 8"),
    "unknown": ("It takes <!--fig:speed-->8<!--/fig--> ms.", f"docs/unknown.md:1: figure speed is not in {DATA}"),
    "open": ("It takes <!--fig:time-->7.2 ms.", "docs/open.md:1: the mark of a figure is not closed"),
    "first": ("<!--fig:time-->7.2<!--/fig--> ms are needed.", "docs/first.md:1: a figure begins the line"),
    "block": ("```\n<!--fig:time-->7.2<!--/fig-->\n```", "docs/block.md:2: a block of code shows the marks of a figure"),
}


class Docs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)
        self.page, self.data = self.root / "docs/good.md", self.root / DATA
        self.data.parent.mkdir(parents=True)
        self.data.write_text(FIGURES)
        self.page.write_text(GOOD)

    def docs(self, code, *arguments):
        ran = subprocess.run([SOURCE / "tools/docs", "--root", self.root, *arguments], capture_output=True, text=True)
        self.assertEqual(ran.returncode, code, ran.stdout + ran.stderr)
        return ran.stdout + ran.stderr

    def test_a_good_page(self):
        printed = self.docs(0, "figures", "tables")
        self.assertIn("4 figures in 5 places", printed)
        self.assertIn("1 tables", printed)

    def test_bad_pages(self):
        for name, (text, message) in BAD.items():
            with self.subTest(name):
                page = self.root / "docs" / f"{name}.md"
                page.write_text(text + "\n")
                self.assertIn("\n" + message, "\n" + self.docs(1, "figures", "tables"))
                page.unlink()

    def test_a_new_measurement(self):
        self.page.write_text(GOOD.replace("| 0.0072 |", "| 0.0093 |"))
        self.assertIn(f"{DATA}: time is 7.2, docs/good.md has 9.3", self.docs(1, "figures"))
        self.docs(0, "figures", "--write")
        self.assertIn("-->9.3<!--", self.page.read_text())
        self.assertIn("-->3.00<!--", self.page.read_text())
        self.assertIn('"value": "9.3"', self.data.read_text())

    def test_a_figure_without_use_or_cell(self):
        self.page.write_text(GOOD.replace("falling", "fell").replace("<!--fig:ratio-->2.32<!--/fig-->", "2"))
        printed = self.docs(1, "figures")
        self.assertIn(f"{DATA}: no page uses ratio", printed)
        self.assertIn(f"{DATA}: time: docs/good.md: 0 cells are 'Times | falling | s'", printed)

    def test_write_needs_the_check_of_figures(self):
        self.docs(2, "tables", "--write")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

#!/usr/bin/env python3
"""validation_pages_test.py SOURCE BUILD: tools/validate makes pages of logs: columns, counts, worst cases and reasons; every
validation test has a theme; the test program prints what the tool reads."""

import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
SOURCE, BUILD = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
sys.path.insert(0, str(SOURCE / "tools/pages"))
import validation as validation_pages  # noqa: E402

FLOAT = """[ RUN      ] hydrostatic.a_column_comes_to_rest
VALIDATION3-RUN|float|2026-01-02|abc123|OpenMP, 2 threads
12: VALIDATION3|hydrostatic.a_column_comes_to_rest|column: pressure|p = ρ g z|0.02|0.03|1|no|float|0.0315|0|Walls.
VALIDATION3|hydrostatic.a_column_comes_to_rest|column: load|weight|0.002|0.001|1|yes|float|0|0|\r
VALIDATION3|hydrostatic.the_three_kernels|column: speed|0|1e-6|3e-6|m/s|no|float|3.15e-06|0|Floats round.
VALIDATION3|ccd.no_hit_is_missed_and_none_is_invented|hits that are missed|referee|0|7|pairs|yes|float|0|0|
VALIDATION3|ccd.no_hit_is_missed_and_none_is_invented|hits that are missed|referee|0|2|pairs|no|float|2.1|0|Too fast.
VALIDATION3|drop.spreads_on_a_plate_that_it_adheres_to|angle|theory|0.2|0.15|1|yes|float|0|0|
VALIDATION3|drop.conserves_momentum_and_angular_momentum|momentum|conserved|1e-06|-3e-8|1|yes|float|0|0|
VALIDATION3|jet.carries_its_mass_and_does_not_burst|mass|ρ A v t|1|0.5|1|yes|float|0|0|
[       OK ] a line that mentions VALIDATION3| without being a row
"""
DOUBLE = """VALIDATION3-RUN|double|2026-01-03|abc123|OpenMP, 2 threads
VALIDATION3|hydrostatic.the_three_kernels|column: speed|0|1e-12|5e-13|m/s|yes|double|0|0|
VALIDATION3|hydrostatic.a_column_comes_to_rest|column: pressure|p = ρ g z|0.02|0.05|1|no|double|0.0525|0|Walls.
VALIDATION3|drop.spreads_on_a_plate_that_it_adheres_to|angle|theory|0.2|0.05|1|yes|double|0|0|
VALIDATION3|drop.conserves_momentum_and_angular_momentum|momentum|conserved|1e-12|0|1|yes|double|0|0|
"""


class Case(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)
        self.docs = self.folder / "docs"

    def validate(self, *logs):
        """tools/validate on logs of these texts."""
        arguments = []
        for k, text in enumerate(logs):
            log = self.folder / f"{k}.log"
            log.write_bytes(text.encode())
            arguments += ["--log", log]
        return subprocess.run([SOURCE / "tools/validate", "--docs", self.docs, *arguments], capture_output=True, text=True)

    def path(self, name):
        return self.docs / "validation" / f"{name}.md"

    def page(self, name):
        return self.path(name).read_text()


class Pages(Case):
    def setUp(self):
        super().setUp()
        done = self.validate(FLOAT, DOUBLE)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stderr, "")
        self.assertIn("7 cases", done.stdout)
        self.assertIn("3 not met", done.stdout)

    def test_precisions_are_columns_of_one_row(self):
        page = self.page("liquid_at_rest")
        self.assertIn("3 cases, 2 not met. [Each", page)
        self.assertIn(f"(../{validation_pages.CASES}#liquid-at-rest-between-walls)", page)
        for row in ("| Case | Quantity | Expected | Limit | Measured, float | Measured, double |",
                    "| column | pressure | p = ρ g z | 0.02 | **0.03**<sup>1</sup> | **0.05**<sup>1</sup> |",
                    "|  | load | weight | 0.002 | 0.001 | – |",
                    "|  | speed | 0 | 1e-6 (float), 1e-12 (double) m/s | **3e-6**<sup>2</sup> | 5e-13 |"):
            self.assertEqual(page.count(row), 1, row)
        self.assertRegex(page, r"## Reasons for missed limits\n\n1\. Walls\.\n2\. Floats round\.\n")
        self.assertTrue(page.startswith(validation_pages.MARK))

    def test_every_case_by_itself(self):
        page = (self.docs / "dev/validation_cases.md").read_text()
        self.assertIn("| Case | Expected | Limit | Measured, float | Measured, double | Unit | Met |", page)
        for row in ("## Liquid at rest, between walls",
                    "| column: pressure | p = ρ g z | 0.02 | **0.03** | **0.05** | 1 | **no** |",
                    "| column: load | weight | 0.002 | 0.001 | – | 1 | yes |",
                    "| column: speed | 0 | 1e-6 (float), 1e-12 (double) | **3e-6** | 5e-13 | m/s | **no** (float) |"):
            self.assertEqual(page.count(row), 1, row)

    def test_a_row_that_comes_again_replaces_the_one_before(self):
        self.assertEqual(self.page("collision").count("hits that are missed"), 1)
        self.assertIn("| 0 pairs | **2**<sup>1</sup> | – |", self.page("collision"))

    def test_an_exact_pattern_decides_over_a_wide_one(self):
        self.assertIn("| angle |", self.page("surface_tension"))
        self.assertNotIn("momentum |", self.page("surface_tension"))
        self.assertIn("| momentum |  | conserved | 1e-06 (float), 1e-12 (double) |", self.page("conservation"))

    def test_scorecard(self):
        page = self.page("README")
        for row in ("| [Liquid at rest, between walls](liquid_at_rest.md) | 3 | 1 | **2** | 3 (float) |",
                    "| [Collision](collision.md) | 1 | 0 | **1** | target is 0 (float) |",
                    "- [Collision](collision.md): hits that are missed. Too fast.",
                    "| [Surface tension](surface_tension.md) | 1 | 1 | 0 | 0.75 (float) |",
                    "| [Conservation](conservation.md) | 1 | 1 | 0 | 0 |",
                    "| [Whole scenes](whole_scenes.md) | 0 | 0 | 0 | – |",
                    "| **all** | **7** | **4** | **3** |  |",
                    "*Measured, float: OpenMP, 2 threads, 2026-01-02; double: OpenMP, 2 threads, 2026-01-03.*"):
            self.assertEqual(page.count(row), 1, row)
        picture = (self.docs / "validation/scorecard.svg").read_text()
        self.assertEqual((picture.count("<circle"), picture.count('fill="#c00"')), (7, 3))
        self.assertLess(page.index("scorecard.svg"), page.index("| Theme |"))

    def test_pages_of_themes_that_are_no_more_go(self):
        stale, own = self.path("stale"), self.path("own")
        stale.write_text(validation_pages.MARK + "\n# Stale\n")
        own.write_text("# By hand\n")
        self.assertEqual(self.validate(FLOAT).returncode, 0)
        self.assertFalse(stale.exists())
        self.assertTrue(own.exists())


class Rows(Case):
    """Rows that cases share."""
    def page_of(self, *cases):
        rows = "".join(f"VALIDATION3|hydrostatic.test|{case}|{expected}|1|{measured}|1|{'yes' if measured <= 1 else 'no'}|float|0|0|\n"
                       for case, expected, measured in cases).replace("|1|0|1|yes", "|0|0|1|yes")
        self.assertEqual(self.validate("VALIDATION3-RUN|float|2026-01-02|abc123|Cuda, H200\n" + rows).returncode, 0)
        return self.page("liquid_at_rest")

    def test_cases_that_differ_in_a_parameter_share_a_row(self):
        page = self.page_of(("column, d = 4 mm: speed", "at the end 0", 0.2), ("column, d = 2 mm: speed", "at the end 0", 0.5),
                            ("column, d = 1 mm: speed", "at the end 0", 0.3), ("column, d = 1 mm: force", "at the end 0", 0.4))
        self.assertIn("| column, d = 4, 2 or 1 mm (3 cases) | speed | at the end 0 | 1 | 0.5 | – |", page)
        self.assertIn("| column, d = 1 mm | force | at the end 0 | 1 | 0.4 | – |", page)
        self.assertIn("4 cases, all met. A row of several cases", page)

    def test_short_expectations_are_listed(self):
        self.assertIn("| n = 1 or 2 (2 cases) | exponent | 1/3 or 1/4 | 1 | 0.2 | – |",
                      self.page_of(("n = 1: exponent", "1/3", 0.2), ("n = 2: exponent", "1/4", 0.1)))

    def test_a_full_product_of_parameters_shares_a_row(self):
        cases = [(f"column of {n} cells, by {by}: sag", "theory of beams", 0.1) for n in (8, 16) for by in ("pd", "xpbd")]
        self.assertIn("| column of 8 or 16 cells, by pd or xpbd (4 cases) | sag |", self.page_of(*cases))

    def test_a_row_stands_for_no_case_that_is_missing(self):
        cases = [(f"column of {n} cells, by {by}: sag", "theory of beams", 0.1) for n, by in ((8, "pd"), (8, "xpbd"), (16, "pd"))]
        page = self.page_of(*cases)
        self.assertIn("| column of 8 cells, by pd or xpbd (2 cases) | sag |", page)
        self.assertIn("| column of 16 cells, by pd | sag |", page)

    def test_pairs_of_parameters_do_not_share_a_row(self):
        page = self.page_of(("column of 8 cells, by pd: sag", "theory of beams", 0.1),
                            ("column of 16 cells, by xpbd: sag", "theory of beams", 0.1))
        self.assertIn("| column of 8 cells, by pd | sag |", page)
        self.assertIn("| column of 16 cells, by xpbd | sag |", page)

    def test_a_case_that_is_missed_has_its_own_row(self):
        page = self.page_of(*((f"n = {n}: force", "at the end 0", measured) for n, measured in ((1, 0.2), (2, 3), (3, 0.1))))
        self.assertIn("| n = 1 or 3 (2 cases) | force | at the end 0 | 1 | 0.2 | – |", page)
        self.assertIn("| n = 2 | force | at the end 0 | 1 | **3**<sup>1</sup> | – |", page)

    def test_exact_conditions_share_a_table(self):
        page = self.page_of(("drops: error", "0", 0), ("drops: loss", "0", 0), ("strips: error", "none", 0),
                            ("strips: loss", "0", 0), ("wet: flow", "0", 0), ("the same, dry: flow", "theory", 0.5))
        self.assertIn("| error; loss | drops; strips |", page)
        self.assertIn("| wet | flow | 0 | 0 | 0 | – |\n| the same, dry | flow | theory |", page)


class Logs(Case):
    def test_a_test_without_a_theme_is_named(self):
        done = self.validate(FLOAT.replace("drop.spreads", "drip.spreads"))
        self.assertEqual(done.returncode, 0)
        self.assertIn("no theme for drip.spreads_on_a_plate", done.stderr)
        self.assertIn("| angle |", self.page("other"))
        self.assertIn("| [Other cases](other", self.page("README"))

    def test_a_reason_that_is_missing_shows(self):
        self.assertEqual(self.validate(FLOAT.replace("Floats round.", "")).returncode, 0)
        self.assertIn("2. The test gives no reason.", self.page("liquid_at_rest"))

    def test_what_is_no_log_changes_no_page(self):
        self.assertEqual(self.validate(FLOAT, DOUBLE).returncode, 0)
        before = self.page("README")
        for text, message in (("nothing\n", "have no row"),
                              ("VALIDATION|case|ref|1|2|1|no|float\n", "a row of version 1 of the format"),
                              ("VALIDATION2|a.b|case|ref|1|2|1|no|float|\n", "a row of version 2 of the format"),
                              (FLOAT[:FLOAT.index("|weight")] + "\n", "0.log:4: not a whole row")):
            done = self.validate(text)
            self.assertEqual(done.returncode, 1)
            self.assertIn(message, done.stderr)
            self.assertEqual(self.page("README"), before)
        done = subprocess.run([SOURCE / "tools/validate", "--docs", self.docs, "--log", self.folder / "none"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("none is no file", done.stderr)


class Bounds(Case):
    """Bounds of cases that are not met, against the worst number of all logs."""
    ROW = "VALIDATION3|hydrostatic.a_column_comes_to_rest|column|0|{target}|{measured}|1|{met}|float|{bound}|{scatter}|Why.\n"
    RUN = "VALIDATION3-RUN|float|2026-01-02|abc123|{}\n"

    def log(self, measured, bound, scatter=0, target=1, machine="OpenMP, 2 threads"):
        return self.RUN.format(machine) + self.ROW.format(measured=measured, bound=bound, scatter=scatter, target=target,
                                                          met="yes" if measured <= target else "no")

    def refused(self, *logs):
        done = self.validate(*logs)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertTrue(self.path("README").exists(), "the pages are written all the same")
        return done.stderr

    def passes(self, *logs):
        done = self.validate(*logs)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_a_bound_that_bites_passes(self):
        self.assertIn("1 bound of targets not met, 8 % above", self.passes(self.log(2, 2.16)))
        self.assertIn("0 bounds of targets not met, 0 %", self.passes(self.log(0.5, 0)))

    def test_a_slack_bound_is_refused(self):
        self.assertIn("column (float): the bound 2.3 is 15 % above 2", self.refused(self.log(2, 2.3)))

    def test_a_bound_of_a_case_that_is_met_is_refused(self):
        self.assertIn("column (float): 0.9 meets the target 1: take the bound away", self.refused(self.log(0.9, 1.2)))
        self.assertIn("0 meets the target 0", self.refused(self.log(0, 1, target=0)))

    def test_the_worst_of_all_logs_and_of_known_scatter_counts(self):
        self.passes(self.log(2.2, 2.3, machine="Cuda, H200"), self.log(2, 2.3))
        self.passes(self.log(0.5, 2.3, scatter=2.2))
        self.refused(self.log(0.5, 2.3, scatter=2))

    def test_a_gpu_alone_may_do_better(self):
        self.passes(self.log(1.5, 2.3, machine="Cuda, H200"))


class Themes(unittest.TestCase):
    def test_every_test_has_a_theme(self):
        introduction, themes = validation_pages.read_themes(SOURCE / "tests/validation/themes.txt")
        self.assertIn("met", introduction)
        self.assertEqual(len({theme.name for theme in themes}), len(themes))
        self.assertTrue(all(theme.introduction and theme.tests for theme in themes))
        seen = set()
        for file in sorted((SOURCE / "tests/validation").glob("*_test.cpp")):
            text = file.read_text()
            suites = dict((suite, f"{prefix}/{suite}") for prefix, suite in
                          re.findall(r"INSTANTIATE_TEST_SUITE_P\((\w+), (\w+)", text))
            for kind, suite, name in re.findall(r"^TEST(_P|)\((\w+), (\w+)\)", text, re.M):
                test = f"{suites[suite]}.{name}/0" if kind else f"{suite}.{name}"
                theme = validation_pages.theme_of(test, themes)
                if suite == "gates":  # they print no rows
                    continue
                self.assertIsNotNone(theme, f"{file.name}: tests/validation/themes.txt has no theme for {test}")
                seen.add(theme.name)
        self.assertEqual(seen, {theme.name for theme in themes}, "a theme without tests")


class Benchmarks(Case):
    def test_a_tool_s_table_replaces_the_one_before(self):
        for tool, name in validation_pages.BENCH_PAGES.items():
            page = SOURCE / "docs/benchmarks" / name
            copy = self.folder / name
            copy.write_text(page.read_text())
            validation_pages.put_bench(self.folder, tool, "| new |\n", "today, here")
            old, new = page.read_text(), copy.read_text()
            begin, end = f"<!-- begin tools/{tool} -->\n", f"<!-- end tools/{tool} -->"
            self.assertIn(f"{begin}Measured: today, here.\n\n| new |\n{end}", new)
            self.assertEqual(new.split(begin)[0], old.split(begin)[0])
            self.assertEqual(new.split(end)[1], old.split(end)[1])
            copy.write_text(old.replace(end, ""))
            with self.assertRaises(SystemExit):
                validation_pages.put_bench(self.folder, tool, "| new |\n", "")


class Printed(Case):
    def test_the_test_program_prints_what_the_tool_reads(self):
        program = BUILD / "drench_tests_validation"
        if not program.exists():
            self.skipTest("no drench_tests_validation")
        test = "cloth_mechanics.sheet_on_an_incline_sticks_or_slides_as_coulomb_says"  # fast; on a GPU in float a target is missed
        ran = subprocess.run([program, f"--gtest_filter={test}"], capture_output=True, text=True)
        self.assertEqual(ran.returncode, 0, ran.stdout)
        done = self.validate(ran.stdout)
        self.assertEqual(done.returncode, 0, done.stderr)
        page = self.page("contact")
        if "|no|float|" in ran.stdout:
            self.assertIn("5 cases, 1 not met.", page)
            self.assertRegex(page, r"\| sheet on an incline of 25°, friction 0\.4 \| acceleration \| [^|]+ \| 0\.02 \| \*\*[^|]+\*\*<sup>1")
            self.assertIn("1. Near the limit of sticking", page)
        else:
            self.assertIn("5 cases, all met.", page)
            self.assertRegex(ran.stdout, r"\|(float|double)\|")
        self.assertRegex(self.page("README"), r"\*Measured, (float|double): \w+, .+, 20\d\d-\d\d-\d\d\.\*")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=2)

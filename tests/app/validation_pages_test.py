#!/usr/bin/env python3
"""validation_pages_test.py SOURCE BUILD: tools/validate makes pages from logs and rejects slack bounds; every validation test has
a theme; the test program prints what the tool reads."""

import re
import sys
import unittest
from dataclasses import replace

from support import BUILD, SOURCE, Case, call, main

sys.path.insert(0, str(SOURCE / "tools/pages"))
import validation  # noqa: E402

RUN = "VALIDATION3-RUN|float|2026-01-02|abc123|OpenMP, 2 threads\n"
FLOAT = RUN + """12: VALIDATION3|hydrostatic.a_column_comes_to_rest|column: pressure|p = ρ g z|0.02|0.03|1|no|float|0.0315|0|Walls.
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


class Pages(Case):
    def validate(self, *logs, code=0):
        """tools/validate on logs of these texts; what it printed."""
        arguments = [word for k, text in enumerate(logs) for word in ("--log", self.write(f"{k}.log", text))]
        done = call(SOURCE / "tools/validate", "--docs", self.folder / "docs", *arguments)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def page(self, name):
        return (self.folder / "docs/validation" / f"{name}.md").read_text()

    def test_pages(self):
        self.assertIn("7 cases", self.validate(FLOAT, DOUBLE))
        rows = {
            self.page("liquid_at_rest"): (
                "3 cases, 2 not met. [Each",
                "| Case | Quantity | Expected | Limit | Measured, float | Measured, double |",
                "| column | pressure | p = ρ g z | 0.02 | **0.03**<sup>1</sup> | **0.05**<sup>1</sup> |",
                "|  | load | weight | 0.002 | 0.001 | – |",
                "|  | speed | 0 | 1e-6 (float), 1e-12 (double) m/s | **3e-6**<sup>2</sup> | 5e-13 |",
                "\n1. Walls.\n2. Floats round.\n"),
            self.page("collision"): ("| 0 pairs | **2**<sup>1</sup> | – |",),  # the later of two equal rows
            self.page("conservation"): ("| momentum |  | conserved | 1e-06 (float), 1e-12 (double) |",),
            (self.folder / "docs/dev/validation_cases.md").read_text(): (
                "| column: speed | 0 | 1e-6 (float), 1e-12 (double) | **3e-6** | 5e-13 | m/s | **no** (float) |",),
            self.page("README"): (
                "| [Liquid at rest, between walls](liquid_at_rest.md) | 3 | 1 | **2** | 3 (float) |",
                "| [Collision](collision.md) | 1 | 0 | **1** | target is 0 (float) |",
                "- [Collision](collision.md): hits that are missed. Too fast.",
                "| [Whole scenes](whole_scenes.md) | 0 | 0 | 0 | – |",
                "| **all** | **7** | **4** | **3** |  |",
                "*Measured, float: OpenMP, 2 threads, 2026-01-02; double: OpenMP, 2 threads, 2026-01-03.*")}
        for page, lines in rows.items():
            for line in lines:
                self.assertEqual(page.count(line), 1, line)
        picture = (self.folder / "docs/validation/scorecard.svg").read_text()
        self.assertEqual((picture.count("<circle"), picture.count('fill="#c00"')), (7, 3))

    def test_cases_share_rows(self):
        cases = [*((f"column, d = {d} mm: speed", "at the end 0", 0.1 * d) for d in (4, 2, 1)), ("column, d = 1 mm: force", "at the end 0", 0.4),
                 *((f"n = {n}: exponent", f"1/{n + 2}", 0.1 * n) for n in (1, 2)),
                 *((f"beam of {n} cells, by {by}: sag", "theory of beams", 0.1) for n, by in ((8, "pd"), (8, "xpbd"), (16, "pd"))),
                 *((f"k = {n}: load", "at the end 0", value) for n, value in ((1, 0.2), (2, 3), (3, 0.1))),
                 ("drops: error", "0", 0), ("drops: loss", "0", 0), ("strips: error", "none", 0), ("strips: loss", "0", 0)]
        self.validate(RUN.replace("OpenMP, 2 threads", "Cuda, H200") + "".join(
            f"VALIDATION3|hydrostatic.test|{case}|{expected}|{1 if value else 0}|{value}|1|{'yes' if value <= 1 else 'no'}|float|0|0|\n"
            for case, expected, value in cases))
        page = self.page("liquid_at_rest")
        for row in ("| column, d = 4, 2 or 1 mm (3 cases) | speed | at the end 0 | 1 | 0.4 | – |",
                    "| column, d = 1 mm | force | at the end 0 | 1 | 0.4 | – |",
                    "| n = 1 or 2 (2 cases) | exponent | 1/3 or 1/4 | 1 | 0.2 | – |",
                    "| beam of 8 cells, by pd or xpbd (2 cases) | sag |",  # a row stands for no case that is missing
                    "| beam of 16 cells, by pd | sag |",
                    "| k = 1 or 3 (2 cases) | load | at the end 0 | 1 | 0.2 | – |",
                    "| k = 2 | load | at the end 0 | 1 | **3**<sup>1</sup> | – |",
                    "1. The test gives no reason.",
                    "| error; loss | drops; strips |"):
            self.assertIn(row, page)

    def test_abbreviations(self):
        file = self.write("themes.txt", "[scorecard]\n\n[drop]\ntests: drop.*\nshort: , over ρgH =>\nshort: mean of nine => mean\n"
                                       "detail: inner\n")
        theme = validation.read_themes(file)[1][0]
        row = validation.Row("drop.test", "drop: error, over ρgH", "mean of nine", "1", "0.1", "1", True, "float", 0, 0, "")
        short = validation.shortened(validation.Case({"float": row}), theme.short).any()
        self.assertEqual((short.case, short.reference, row.case), ("drop: error", "mean", "drop: error, over ρgH"))
        inner = replace(row, case="drop: inner", reference="0")
        for met, counted in ((True, "#drop) (1 is only there), [scorecard"), (False, "#drop), [scorecard")):
            theme.cases = [validation.Case({"float": row}), validation.Case({"float": replace(inner, met=met)})]
            self.assertIn(counted, validation.theme_page(theme))

    def test_quantities_share_rows(self):
        self.validate(RUN + "".join(
            f"VALIDATION3|hydrostatic.test|column: {what}|at rest|1|{value}|1|yes|float|0|0|\n"
            for what, value in (("speed at 4 ms", 0.1), ("mean force", 0.2), ("speed at 2 ms", 0.3))))
        page = self.page("liquid_at_rest")
        for row in ("| column | speed at 4 or 2 ms (2 cases) | at rest | 1 | 0.3 | – |", "|  | mean force |  | 1 | 0.2 | – |"):
            self.assertIn(row, page)

    def test_logs(self):
        self.assertIn("no theme for drip.spreads_on_a_plate", self.validate(FLOAT.replace("drop.spreads", "drip.spreads")))
        self.assertIn("| angle |", self.page("other"))
        before = self.page("README")
        for text, message in (("nothing\n", "have no row"),
                              ("VALIDATION2|a.b|case|ref|1|2|1|no|float|\n", "a row of version 2 of the format"),
                              (FLOAT[:FLOAT.index("|weight")] + "\n", "0.log:3: not a whole row")):
            self.assertIn(message, self.validate(text, code=1))
            self.assertEqual(self.page("README"), before)

    def test_bounds(self):
        """Bounds of cases that are not met, against the worst number of all logs."""
        def log(measured, bound, scatter=0, target=1, machine="OpenMP, 2 threads"):
            return (RUN.replace("OpenMP, 2 threads", machine) + "VALIDATION3|hydrostatic.a_column_comes_to_rest|column|0|"
                    f"{target}|{measured}|1|{'yes' if measured <= target else 'no'}|float|{bound}|{scatter}|Why.\n")

        gpu = "Cuda, H200"
        for code, message, *logs in (
                (0, "1 bound of targets not met, 8 % above", log(2, 2.16)),
                (0, "0 bounds of targets not met, 0 %", log(0.5, 0)),
                (1, "column (float): the bound 2.3 is 15 % above 2", log(2, 2.3)),
                (1, "column (float): 0.9 meets the target 1: take the bound away", log(0.9, 1.2)),
                (1, "0 meets the target 0", log(0, 1, target=0)),
                (0, "", log(2.2, 2.3, machine=gpu), log(2, 2.3)),
                (0, "", log(0.5, 2.3, scatter=2.2)),
                (1, "", log(0.5, 2.3, scatter=2)),
                (0, "", log(1.5, 2.3, machine=gpu))):
            self.assertIn(message, self.validate(*logs, code=code))
            self.assertIn("Liquid at rest", self.page("README"))

    def test_program_prints_what_the_tool_reads(self):
        program = BUILD / "drench_tests_validation"
        if not program.exists():
            self.skipTest("no drench_tests_validation")
        test = "cloth_mechanics.sheet_on_an_incline_sticks_or_slides_as_coulomb_says"  # fast; on a GPU in float a target is missed
        ran = call(program, f"--gtest_filter={test}")
        self.assertEqual(ran.returncode, 0, ran.stdout)
        self.validate(ran.stdout)
        self.assertIn("5 cases, 1 not met." if "|no|float|" in ran.stdout else "5 cases, all met.", self.page("contact"))
        self.assertRegex(self.page("README"), r"\*Measured, (float|double): \w+, .+, 20\d\d-\d\d-\d\d\.\*")

    def test_table_of_a_benchmark_replaces_the_one_before(self):
        for tool, name in validation.BENCH_PAGES.items():
            old = (SOURCE / "docs/benchmarks" / name).read_text()
            copy = self.write(name, old)
            validation.put_bench(self.folder, tool, "| new |\n", "today, here")
            begin, end = f"<!-- begin tools/{tool} -->\n", f"<!-- end tools/{tool} -->"
            self.assertEqual(copy.read_text(), f"{old.split(begin)[0]}{begin}Measured: today, here.\n\n| new |\n{end}{old.split(end)[1]}")


class Themes(unittest.TestCase):
    def test_every_test_has_a_theme(self):
        _, themes = validation.read_themes(SOURCE / "tests/validation/themes.txt")
        seen = set()
        for file in sorted((SOURCE / "tests/validation").glob("*_test.cpp")):
            text = file.read_text()
            suites = {suite: f"{prefix}/{suite}" for prefix, suite in re.findall(r"INSTANTIATE_TEST_SUITE_P\((\w+), (\w+)", text)}
            for kind, suite, name in re.findall(r"^TEST(_P|)\((\w+), (\w+)\)", text, re.M):
                if suite != "gates":  # they print no rows
                    test = f"{suites[suite]}.{name}/0" if kind else f"{suite}.{name}"
                    theme = validation.theme_of(test, themes)
                    self.assertIsNotNone(theme, f"{file.name}: tests/validation/themes.txt has no theme for {test}")
                    seen.add(theme.name)
        self.assertEqual(seen, {theme.name for theme in themes}, "a theme without tests")


if __name__ == "__main__":
    main()

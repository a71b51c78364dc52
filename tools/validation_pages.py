#!/usr/bin/env python3
"""tools/validation_pages.py --log FILE... [--docs FOLDER] [--themes FILE] [--bench FILE] [--cloth-bench FILE] [--where TEXT]

Writes docs/validation/ from the rows that the validation tests print (report in tests/support/validation.hpp): a scorecard with
its picture and one page per theme, float and double as columns of one row. tests/validation/themes.txt assigns tests to
themes and introduces them. --bench and --cloth-bench put the output of those tools into their pages of docs/benchmarks/;
WHERE is the date, commit and machine of the times. Exit code 1, with the pages written, where the bound of a case that is not met is
more than a tenth above the worst number of all logs, or where all of them meet its target. tools/validate calls this."""

import argparse
import fnmatch
import math
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import docs_figures  # noqa: E402
import validation_picture  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent
VERSION = "3"
SLACK = 0.1  # allowed_slack of tests/support/validation.hpp
PRECISIONS = ("float", "double")
MARK = "<!-- Written by tools/validate: not edited by hand. -->"
PICTURE = "scorecard.svg"
HOW_TO = """`tools/validate` runs the tests and writes these pages; `tools/validate --log FILE` writes them from an existing log.
Run times, and the errors that they buy, are in the [benchmarks](../benchmarks/)."""
BENCH_PAGES = {"bench": "liquid.md", "cloth_bench": "cloth.md"}


@dataclass
class Row:
    """One case in one precision, as printed."""
    test: str
    case: str
    reference: str
    target: str
    measured: str
    unit: str
    met: bool
    precision: str
    bound: float  # today's, of a target that is missed; 0 if there is none
    scatter: float  # the worst that is known of other backends; 0 where they agree
    reason: str

    def over(self):
        """Measured over target; infinite where a target of 0 is missed."""
        measured, target = float(self.measured), float(self.target)
        if self.met:
            return max(measured, 0) / target if target > 0 else 0
        return measured / target if target > 0 else math.inf


@dataclass
class Case:
    rows: dict = field(default_factory=dict)  # by precision
    most: dict = field(default_factory=dict)  # by precision: the largest number of all logs, known scatter included
    hosts: set = field(default_factory=set)  # precisions in which a host has run it: bounds are set from these

    def add(self, row, host):
        self.rows[row.precision] = row
        if host:
            self.hosts.add(row.precision)
        number = float(row.measured)
        seen = self.most.get(row.precision, -math.inf)
        self.most[row.precision] = math.nan if math.isnan(number) else max(seen, number, row.scatter or -math.inf)

    def any(self):
        return next(iter(self.rows.values()))

    def missed(self):
        return [p for p in PRECISIONS if p in self.rows and not self.rows[p].met]

    def worst(self):
        """The worse row; a row that is not met is worse than one that is."""
        return max(self.rows.values(), key=lambda r: (not r.met, r.over()))


@dataclass
class Theme:
    name: str  # of the page
    title: str
    tests: list
    introduction: str
    cases: list = field(default_factory=list)

    def missed(self):
        return [c for c in self.cases if c.missed()]


def fail(text):
    sys.exit("tools/validation_pages.py: " + text)


def read_log(path, cases, runs):
    """Adds a log's rows to cases and its runs to runs; a row that comes again replaces the one before."""
    host = True
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        found = re.match(r"(?:\d+: )?VALIDATION(\d*)(-RUN)?\|(.*)", line)
        if not found:
            continue
        version, is_run, rest = found.groups()
        if version != VERSION:
            fail(f"{path}:{number}: a row of version {version or 1} of the format, {VERSION} is known: "
                 "build drench_tests_validation anew")
        fields = rest.split("|")
        if len(fields) != (4 if is_run else 11) or (precision := fields[0 if is_run else 7]) not in PRECISIONS:
            fail(f"{path}:{number}: not a whole row: {line}")
        if is_run:
            host = bool(re.search(r", \d+ threads?$", fields[3]))
            runs.setdefault(precision, set()).add(tuple(fields[1:]))
            continue
        test, case, reference, target, measured, unit, met, precision, bound, scatter, reason = fields
        row = Row(test, case, reference, target, measured, unit, met == "yes", precision, float(bound), float(scatter), reason)
        cases.setdefault((test, case, reference, unit), Case()).add(row, host)


def slack(cases):
    """(the largest slack of a bound, [an objection a row]): bounds against the worst numbers of all logs."""
    largest, wrong = 0, []
    for case in cases.values():
        for precision, row in case.rows.items():
            worst, target = case.most[precision], float(row.target)
            if row.bound <= 0 or precision not in case.hosts:
                continue
            if worst <= target:
                wrong.append(f"{row.case} ({precision}): {worst:.3g} meets the target {row.target}: take the bound away")
                continue
            here = row.bound / worst - 1
            largest = max(largest, here)
            if here > SLACK + 0.006:  # rows are printed to three digits
                wrong.append(f"{row.case} ({precision}): the bound {row.bound:.4g} is {100 * here:.0f} % above {worst:.3g}")
    return largest, wrong


def read_themes(path):
    """(the scorecard's introduction, [Theme])"""
    themes = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("#") or not themes and not line:
            continue
        if section := re.fullmatch(r"\[(\w+)\]", line):
            themes.append(Theme(section[1], section[1], [], ""))
        elif not themes:
            fail(f"{path}: not in a section: {line}")
        elif found := re.fullmatch(r"title: (.*)", line):
            themes[-1].title = found[1]
        elif found := re.fullmatch(r"tests: (.*)", line):
            themes[-1].tests += found[1].split()
        else:
            themes[-1].introduction += line + "\n"
    if not themes or themes[0].name != "scorecard":
        fail(f"{path} does not begin with [scorecard]")
    for theme in themes:
        theme.introduction = theme.introduction.strip()
    return themes[0].introduction, themes[1:]


def theme_of(test, themes):
    """The theme with the longest pattern that fits the test, or None."""
    fits = [(len(pattern), theme) for theme in themes for pattern in theme.tests if fnmatch.fnmatchcase(test, pattern)]
    return max(fits, key=lambda fit: fit[0])[1] if fits else None


def sort_into_themes(cases, themes):
    other = Theme("other", "Other cases", [], "`tests/validation/themes.txt` has no theme for their tests.")
    for (test, *_), case in sorted(cases.items(), key=lambda one: one[0][0]):  # logs of CTest have any order of tests
        (theme_of(test, themes) or other).cases.append(case)
    if not other.cases:
        return themes
    other.tests = sorted({case.any().test for case in other.cases})
    print(f"tools/validation_pages.py: tests/validation/themes.txt has no theme for {' '.join(other.tests)}",
          file=sys.stderr)
    return [*themes, other]


def text(cell):
    """A cell of a table, whatever marks it holds."""
    return re.sub(r"([*<])", r"\\\1", cell)


def table_row(*cells):
    return f"| {' | '.join(str(cell) for cell in cells)} |"


def value(row):
    return "–" if row is None else row.measured if row.met else f"**{row.measured}**"


def target(case):
    targets = {p: r.target for p, r in case.rows.items()}
    if len(set(targets.values())) == 1:
        return case.any().target
    return ", ".join(f"{targets[p]} ({p})" for p in PRECISIONS if p in targets)


def why(row):
    return row.reason or "The test gives no reason."


def met(case, reasons):
    """The last cell of a row; reasons gets those that it does not have yet."""
    missed = case.missed()
    if not missed:
        return "yes"
    numbers = []
    for precision in missed:
        reason = why(case.rows[precision])
        if reason not in reasons:
            reasons.append(reason)
        if (number := str(reasons.index(reason) + 1)) not in numbers:
            numbers.append(number)
    only = f" ({missed[0]})" if len(missed) < len(case.rows) else ""
    return f"**no**{only}<sup>{', '.join(numbers)}</sup>"


def count(number, noun):
    return f"{number} {noun}{'' if number == 1 else 's'}"


def theme_page(theme):
    reasons = []
    table = [table_row("Case", "Expected", "Limit", *(f"Measured, {p}" for p in PRECISIONS), "Unit", "Met"), "|---" * 7 + "|"]
    for case in theme.cases:
        one = case.any()
        table.append(table_row(text(one.case), text(one.reference), target(case),
                          *(value(case.rows.get(p)) for p in PRECISIONS), text(one.unit), met(case, reasons)))
    missed = len(theme.missed())
    lines = [MARK, f"# {theme.title}", "", theme.introduction, "",
             f"{count(len(theme.cases), 'case')}, {f'{missed} not met' if missed else 'all met'}. [Scorecard](README.md)"]
    if theme.cases:
        lines += ["", *table]
    if reasons:
        lines += ["", "## Reasons for missed limits", "", *(f"{k}. {text(reason)}" for k, reason in enumerate(reasons, 1))]
    lines += ["", "## Running these tests", "", "```",
              f"build/openmp-float/drench_tests_validation --gtest_filter='{':'.join(theme.tests)}'", "```"]
    return "\n".join(lines) + "\n"


def scorecard_row(theme):
    cases, missed = len(theme.cases), len(theme.missed())
    worst = max((case.worst() for case in theme.cases), key=lambda r: (not r.met, r.over()), default=None)
    shown = ("–", "–", "")
    if worst and worst.over() == 0:
        shown = ("0", "all", "")
    elif worst:
        over = "target is 0" if math.isinf(worst.over()) else f"{worst.over():.2g}"
        shown = (f"{over} ({worst.precision})", text(worst.case), "" if worst.met else text(why(worst)))
    return table_row(f"[{theme.title}]({theme.name}.md)", cases, cases - missed, f"**{missed}**" if missed else 0, *shown)


def measured_where(runs):
    """One line: machine and date for each precision."""
    parts = []
    for precision in PRECISIONS:
        for machine in sorted({run[2] for run in runs.get(precision, ())}):
            dates = ", ".join(sorted({run[0] for run in runs[precision] if run[2] == machine}))
            parts.append(f"{precision}: {machine}, {dates}")
    return f"*Measured, {'; '.join(parts)}.*"


def scorecard(introduction, themes, runs):
    cases, missed = sum(len(t.cases) for t in themes), sum(len(t.missed()) for t in themes)
    return "\n".join([
        MARK, "# Validation", "", introduction, "",
        f"![measured deviation divided by its limit for each of {cases} cases, by theme]({PICTURE})", "",
        "*Each dot is a case in its worse precision; dots to the right of the line miss their limit.*", "",
        table_row("Theme", "Cases", "Met", "Not met", "Largest measured / limit", "Its case", "Reason if not met"),
        "|---" * 7 + "|", *map(scorecard_row, themes),
        table_row("**all**", *(f"**{n}**" for n in (cases, cases - missed, missed)), "", "", ""), "",
        measured_where(runs), "", HOW_TO]) + "\n"


def write_validation(folder, introduction, themes, runs):
    folder.mkdir(parents=True, exist_ok=True)
    pages = {"README.md": scorecard(introduction, themes, runs)}
    pages.update({f"{theme.name}.md": theme_page(theme) for theme in themes})
    for old in folder.glob("*.md"):  # a theme that is no more
        if old.name not in pages and old.read_text(encoding="utf-8").startswith(MARK):
            old.unlink()
    pages[PICTURE] = validation_picture.draw([(theme.title, [case.worst().over() for case in theme.cases]) for theme in themes])
    for name, page in pages.items():
        (folder / name).write_text(page, encoding="utf-8")


def put_bench(folder, tool, printed, where):
    """Puts what a tool printed between its marks in its page."""
    page = folder / BENCH_PAGES[tool]
    old = page.read_text(encoding="utf-8")
    begin, end = f"<!-- begin tools/{tool} -->\n", f"<!-- end tools/{tool} -->"
    if old.count(begin) != 1 or old.count(end) != 1:
        fail(f"{page} has no place for tools/{tool}: {begin.strip()} … {end}")
    head, rest = old.split(begin)
    said = f"Measured: {where}.\n\n" if where else ""
    page.write_text(f"{head}{begin}{said}{printed.strip()}\n{end}{rest.split(end)[1]}", encoding="utf-8")


def options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                                     usage=argparse.SUPPRESS)
    add = parser.add_argument
    add("--log", type=Path, action="append", required=True)
    add("--docs", type=Path, default=ROOT / "docs")
    add("--themes", type=Path, default=ROOT / "tests/validation/themes.txt")
    add("--bench", type=Path)
    add("--cloth-bench", type=Path)
    add("--where", default="")
    return parser.parse_args()


def main():
    o = options()
    cases, runs = {}, {}
    for log in o.log:
        if not log.is_file():
            fail(f"{log} is no file")
        read_log(log, cases, runs)
    if not cases:
        fail("the logs have no row")
    introduction, themes = read_themes(o.themes)
    themes = sort_into_themes(cases, themes)
    write_validation(o.docs / "validation", introduction, themes, runs)
    for tool, printed in (("bench", o.bench), ("cloth_bench", o.cloth_bench)):
        if printed:
            put_bench(o.docs / "benchmarks", tool, printed.read_text(encoding="utf-8"), o.where)
    if o.docs.resolve() == ROOT / "docs":
        docs_figures.write(ROOT)  # other pages have figures of these
    missed = sum(len(theme.missed()) for theme in themes)
    print(f"== {count(len(cases), 'case')} in {o.docs / 'validation'}, {missed} not met")
    largest, wrong = slack(cases)
    bounds = sum(row.bound > 0 for case in cases.values() for row in case.rows.values())
    print(f"== {count(bounds, 'bound')} of targets not met, {100 * largest:.0f} % above the worst number at most")
    if wrong:
        sys.exit("\n".join([*wrong, f"tools/validation_pages.py: bounds must be at most {100 * SLACK:.0f} % above what is "
                            "measured"]))


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""tools/pages/validation.py --log FILE... [--docs FOLDER] [--themes FILE] [--bench FILE] [--cloth-bench FILE] [--where TEXT]

Writes docs/validation/ from the rows that the validation tests print (report in tests/support/validation.hpp): a scorecard with
its picture and one page per theme, float and double as columns of one row. Cases that differ in a parameter share a row with
their largest values; docs/dev/validation_cases.md lists each case. tests/validation/themes.txt assigns tests to themes and
introduces them. --bench and --cloth-bench put the output of those tools into their pages of docs/benchmarks/; WHERE is
the date, commit and machine of the times. Exit code 1, with the pages written, where the bound of a case that is not met
is more than a tenth above the worst number of all logs, or where all of them meet its target. tools/validate calls this."""

import argparse
import fnmatch
import math
import re
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import figures  # noqa: E402
import validation_picture  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
VERSION = "3"
SLACK = 0.1  # allowed_slack of tests/support/validation.hpp
PRECISIONS = ("float", "double")
MARK = "<!-- Written by tools/validate -->"
MEASURED = [f"Measured, {precision}" for precision in PRECISIONS]
PICTURE = "scorecard.svg"
CASES = "dev/validation_cases.md"
LONGEST_VARIATION = 4  # words
HOW_TO = """`tools/validate` runs the tests and writes these pages; `tools/validate --log FILE` writes them from an existing log.
The [benchmarks](../benchmarks/) list run times and how they depend on the accuracy."""
BENCH_PAGES = {"bench": "liquid.md", "measure/cloth_bench": "cloth.md"}


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
    short: list = field(default_factory=list)  # [(text of its cases, what its page writes for it)]
    details: list = field(default_factory=list)  # texts of cases that only the list of each case has, unless they are missed

    def missed(self):
        return [c for c in self.cases if c.missed()]


def fail(text):
    sys.exit("tools/pages/validation.py: " + text)


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
        elif found := re.fullmatch(r"detail: (.*)", line):
            themes[-1].details.append(found[1])
        elif found := re.fullmatch(r"short: (.*) =>(?: (.*))?", line):
            themes[-1].short.append((found[1], found[2] or ""))
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
    print(f"tools/pages/validation.py: tests/validation/themes.txt has no theme for {' '.join(other.tests)}",
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


@dataclass
class Line:
    """One row of a theme's table: a case, or cases that differ in a parameter."""
    cases: list

    def subjects(self):
        return list(dict.fromkeys(split(case)[0] for case in self.cases))

    def key(self):
        """Equal for lines that may share a row. Short expectations, such as 1/3 and 1/4, are listed."""
        one = self.cases[0].any()
        expected = "" if len(one.reference.split()) <= 2 else one.reference
        return split(self.cases[0])[1], expected, target(self.cases[0]), one.unit

    def quantities(self):
        return list(dict.fromkeys(split(case)[1] for case in self.cases))

    def subject(self):
        subjects = self.subjects()
        many = f" ({len(subjects)} cases)" if len(subjects) > 1 else ""
        return text(joined(subjects)[0]) + many

    def quantity(self):
        quantities = self.quantities()
        many = f" ({len(quantities)} cases)" if len(quantities) > 1 else ""
        return text(joined(quantities)[0]) + many

    def cells(self, reasons):
        one = self.cases[0].any()
        expected = either([case.any().reference for case in self.cases])
        limit = target(self.cases[0]) + ("" if one.unit == "1" else f" {text(one.unit)}")
        return self.quantity(), text(expected), limit, *(self.largest(p, reasons) for p in PRECISIONS)

    def largest(self, precision, reasons):
        rows = [case.rows[precision] for case in self.cases if precision in case.rows]
        if not rows:
            return "–"
        row = max(rows, key=lambda r: (not r.met, float(r.measured)))
        if row.met:
            return row.measured
        if why(row) not in reasons:
            reasons.append(why(row))
        return f"{value(row)}<sup>{reasons.index(why(row)) + 1}</sup>"


def split(case):
    """(subject, quantity) of a case; the quantity may be empty."""
    label = case.any().case
    at = [found.start() for found in re.finditer(": ", label)]
    at = [k for k in at if label[:k].count("(") == label[:k].count(")")]
    return (label[:at[-1]], label[at[-1] + 2:]) if at else (label, "")


def either(texts):
    """"a, b or c" without repetitions."""
    texts = list(dict.fromkeys(texts))
    return texts[0] if len(texts) == 1 else f"{', '.join(texts[:-1])} or {texts[-1]}"


def runs_of(words):
    """[(first, end)]: neighbouring positions at which the texts differ; words has their words."""
    runs = []
    for k, column in enumerate(zip(*words)):
        if len(set(column)) > 1:
            if runs and runs[-1][1] == k:
                runs[-1] = (runs[-1][0], k + 1)
            else:
                runs.append((k, k + 1))
    return runs


def variations(texts):
    """(the texts in one, with the words in which they differ as alternatives, how many texts that stands for);
    ("", 0) where they are too different."""
    words = [one.split(" ") for one in texts]
    if len({len(w) for w in words}) > 1:
        return (either(texts), len(texts)) if max(map(len, words)) <= LONGEST_VARIATION + 2 else ("", 0)
    varied = [(first, end, list(dict.fromkeys(" ".join(w[first:end]) for w in words))) for first, end in runs_of(words)]
    if any(end - first > LONGEST_VARIATION for first, end, _ in varied):
        return "", 0
    if len(varied) > 1 and len(texts) <= max(len(ones) for *_, ones in varied):  # pairs: their product would mislead
        return (either(texts), len(texts)) if len(words[0]) <= LONGEST_VARIATION + 2 else ("", 0)
    made = words[0]
    for first, end, ones in reversed(varied):
        made = [*made[:first], either(ones), *made[end:]]
    return " ".join(made), math.prod(len(ones) for *_, ones in varied)


def parts_of(subject):
    """The parts of a subject and what is between them."""
    return re.split(r"(, |: )", subject)


def joined(subjects):
    """(the subjects in one text, part by part, how many subjects that stands for);
    ("", 0) where they are not variations of one."""
    parts = [parts_of(subject) for subject in subjects]
    if len({(one[0].split(" ")[0], *one[1::2]) for one in parts}) > 1:
        return "", 0
    columns = [list(dict.fromkeys(column)) for column in zip(*parts)]
    varied = [len(column) for column in columns if len(column) > 1]
    if len(varied) > 1 and len(subjects) <= max(varied):
        return "", 0
    made = [variations(column) if len(column) > 1 else (column[0], 1) for column in columns]
    if not all(one for one, _ in made):
        return "", 0
    return "".join(one for one, _ in made), math.prod(many for _, many in made)


def whole(line):
    """[Line] that stand for no more than their cases: the line, or its parts by that part of the subject that leaves the fewest."""
    subjects = line.subjects()
    if len(subjects) == 1 or joined(subjects)[1] == len(subjects):
        return [line]
    found = []
    for k, column in enumerate(zip(*map(parts_of, subjects))):
        if len(set(column)) > 1:
            parts = {}
            for case in line.cases:
                parts.setdefault(parts_of(split(case)[0])[k], []).append(case)
            found.append([one for cases in parts.values() for one in whole(Line(cases))])
    return min(found, key=len)


def is_exact(case):
    """Whether a case is 0 and must be."""
    zeros = all(r.met and float(r.target) == float(r.measured) == 0 for r in case.rows.values())
    return zeros and case.any().reference in ("0", "none")


def lines_of(cases):
    """[Line]: cases that differ in a parameter together, lines of one subject together."""
    found = []
    for case in cases:
        one = Line([case])
        for line in found:
            if not case.missed() and not line.cases[0].missed() and line.key() == one.key():
                if split(case)[0] not in line.subjects() and joined([*line.subjects(), split(case)[0]])[1]:
                    line.cases.append(case)
                    break
        else:
            found.append(one)
    found = [part for line in found for part in whole(line)]
    subjects = list(dict.fromkeys(line.subject() for line in found))
    merged = []
    for line in sorted(found, key=lambda line: subjects.index(line.subject())):
        if not any(merge_quantity(one, line) for one in merged):
            merged.append(line)
    return merged


def merge_quantity(line, other):
    """Adds the other line to the line where they differ in a parameter of the quantity alone."""
    quantities = [*line.quantities(), *other.quantities()]
    references = {case.any().reference for case in (*line.cases, *other.cases)}
    alike = (line.subject(), *line.key()[2:]) == (other.subject(), *other.key()[2:]) and len(references) == 1
    if not alike or any(case.missed() for case in (*line.cases, *other.cases)) or joined(quantities)[1] != len(quantities):
        return False
    line.cases += other.cases
    return True


def exact_table(cases):
    """Conditions that hold exactly: their quantities and the subjects that share them."""
    quantities = {}
    for case in cases:
        subject, quantity = split(case)
        unit = case.any().unit
        quantities.setdefault(subject, []).append((quantity or subject) + ("" if unit == "1" else f" ({unit})"))
    subjects = {}
    for subject, ones in quantities.items():
        subjects.setdefault(tuple(ones), []).append(subject)
    table = [table_row("Quantity", "Case"), "|---" * 2 + "|"]
    return table + [table_row(text("; ".join(ones)), text("; ".join(of))) for ones, of in subjects.items()]


def count(number, noun):
    return f"{number} {noun}{'' if number == 1 else 's'}"


def shortened(case, short):
    """The case with the abbreviations of its page."""
    if not short:
        return case
    rows = {}
    for precision, row in case.rows.items():
        label, reference = row.case, row.reference
        for long, brief in short:
            label, reference = label.replace(long, brief), reference.replace(long, brief)
        rows[precision] = replace(row, case=label, reference=reference)
    return replace(case, rows=rows)


def theme_page(theme):
    reasons, before, table = [], ("", ""), []
    shown = [case for case in theme.cases if case.missed() or not any(one in case.any().case for one in theme.details)]
    exact = [case for case, after in zip(shown, [*shown[1:], None])
             if is_exact(case) and not (after and after.any().case.startswith("the same"))]
    found = lines_of([shortened(case, theme.short) for case in shown if case not in exact])
    for line in found:
        subject, (quantity, expected, *rest) = line.subject(), line.cells(reasons)
        same = subject == before[0]
        table.append(table_row("" if same else subject, quantity, "" if same and expected == before[1] else expected, *rest))
        before = subject, expected
    missed = len(theme.missed())
    counted = f"{count(len(theme.cases), 'case')}, {f'{missed} not met' if missed else 'all met'}."
    hidden = len(theme.cases) - len(shown)
    hidden = f" ({hidden} {'is' if hidden == 1 else 'are'} only there)" if hidden else ""
    lines = [MARK, f"# {theme.title}", "", theme.introduction, "",
             f"{counted} [Each case by itself](../{CASES}#{anchor(theme.title)}){hidden}, [scorecard and notation](README.md)"]
    if table:
        heads = "Case", "Quantity", "Expected", "Limit", *MEASURED
        lines += ["", table_row(*heads), "|---" * len(heads) + "|", *table]
    if reasons:
        lines += ["", "## Reasons for missed limits", "", *(f"{k}. {text(reason)}" for k, reason in enumerate(reasons, 1))]
    if exact:
        said = "Each of these quantities must be 0, and is 0."
        lines += ["", "## Exact conditions", "", said, "", *exact_table(exact)]
    lines += ["", "## Running these tests", "", "```",
              f"build/openmp-float/drench_tests_validation --gtest_filter='{':'.join(theme.tests)}'", "```"]
    return "\n".join(lines) + "\n"


def anchor(title):
    return re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")


def cases_page(themes):
    """Every case by itself."""
    lines = [MARK, "# Validation cases", "", "Each case of the [validation](../validation/) by itself."]
    for theme in themes:
        lines += ["", f"## {theme.title}", ""]
        if theme.cases:
            heads = "Case", "Expected", "Limit", *MEASURED, "Unit", "Met"
            lines += [table_row(*heads), "|---" * len(heads) + "|"]
        for case in theme.cases:
            one, missed = case.any(), case.missed()
            verdict = "yes" if not missed else "**no**" + (f" ({missed[0]})" if len(missed) < len(case.rows) else "")
            lines.append(table_row(text(one.case), text(one.reference), target(case),
                                   *(value(case.rows.get(p)) for p in PRECISIONS), text(one.unit), verdict))
    return "\n".join(lines) + "\n"


def scorecard_row(theme):
    cases, missed = len(theme.cases), len(theme.missed())
    worst = max((case.worst() for case in theme.cases), key=lambda r: (not r.met, r.over()), default=None)
    over = "–"
    if worst:
        over = "target is 0" if math.isinf(worst.over()) else f"{worst.over():.2g}"
        over += f" ({worst.precision})" if worst.over() > 0 else ""
    return table_row(f"[{theme.title}]({theme.name}.md)", cases, cases - missed, f"**{missed}**" if missed else 0, over)


def missed_list(themes):
    """The cases that are not met, with their reasons."""
    lines = [f"- [{theme.title}]({theme.name}.md): {text(case.any().case)}. {text(why(case.rows[case.missed()[0]]))}"
             for theme in themes for case in theme.missed()]
    return ["", "## Cases not met", "", *lines] if lines else []


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
        table_row("Theme", "Cases", "Met", "Not met", "Largest measured / limit"),
        "|---" * 5 + "|", *map(scorecard_row, themes),
        table_row("**all**", *(f"**{n}**" for n in (cases, cases - missed, missed)), ""), "",
        measured_where(runs), *missed_list(themes), "", "## Running the tests", "", HOW_TO]) + "\n"


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
    every = folder.parent / CASES
    every.parent.mkdir(parents=True, exist_ok=True)
    every.write_text(cases_page(themes), encoding="utf-8")


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
    for tool, printed in (("bench", o.bench), ("measure/cloth_bench", o.cloth_bench)):
        if printed:
            put_bench(o.docs / "benchmarks", tool, printed.read_text(encoding="utf-8"), o.where)
    if o.docs.resolve() == ROOT / "docs":
        figures.write(ROOT)  # other pages have figures of these
    missed = sum(len(theme.missed()) for theme in themes)
    print(f"== {count(len(cases), 'case')} in {o.docs / 'validation'}, {missed} not met")
    largest, wrong = slack(cases)
    bounds = sum(row.bound > 0 for case in cases.values() for row in case.rows.values())
    print(f"== {count(bounds, 'bound')} of targets not met, {100 * largest:.0f} % above the worst number at most")
    if wrong:
        sys.exit("\n".join([*wrong, f"tools/pages/validation.py: bounds must be at most {100 * SLACK:.0f} % above what is "
                            "measured"]))


if __name__ == "__main__":
    main()

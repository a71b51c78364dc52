"""Idioms and terms that user pages avoid (tools/docs idioms). Tables and headings are searched too; code and formulas are not.

User pages are README.md, CHANGELOG.md, the pages of scenes/, and docs/ without docs/dev."""

import re

from page_text import CODE, files, text_lines

UNITS = r"(?:ms|µs|ns|s|seconds?|minutes?|hours?|times|iterations?|sub-steps?|bytes|kB|MB|kg|g|pictures|frames|files)"
PER = r"(?:step|second|minute|frame|particle|node|rank|GPU|thread|iteration)"
PROGRAM = r"(?:drench|the (?:run|program|log|solver|build|report|warning|error|message|line)|CMake|[Ii]t|[Ww]hich)"

# Pattern and what to write. Matched within a paragraph, a heading or a row of a table, without regard to case.
IDIOMS = [
    (rf"\b{UNITS} an? {PER}\b", "per step, per second, …"),
    (r"\bin place of\b", "instead of"),
    (r"\b(?:to )?mend(?:ed|s|ing)?\b", "fix, fixed"),
    (r"\bbooks?\b", "documentation, guide"),
    (r"\btells? of\b", "report, describe"),
    (rf"\b{PROGRAM} (?:says?|tells?|knows?|wants?|told)\b", "print, report, warn, write, reject"),
    (r"\b(?:gives?|given|gave|giving) back\b", "release, return"),
    (r"\bat (?:the|its|their) caps?\b", "at the iteration limit"),
    (r"\b(?:is|are|was|were) refused\b|\brefuses?\b", "rejected, reject"),
    (r"\b(?:refused|rejected), never\b", "rejected with an error"),
    (r"\bas far as it is one\b", "leave it out"),
    (r"\bas (?:fast as )?time went\b", "in real time"),
    (r"\bshares? no law\b", "implements the equations independently"),
    (r"\bof a rounding\b", "discontinuities"),
    (r"\b(?:in|out of) reach\b", "available, internet access"),
    (r"\bplain value\b", "constant"),
    (r"\bkeys of it\b", "keyframes"),
    (r"\b\d+(?:\.\d+)? slacks?\b", "the value with its unit"),
    (r", as in (?:an?|the)\b", "for example"),
    (r"\bno healthy run\b", "no valid simulation"),
    (r"\bcontact wicking\b", "transfer between layers"),
    (r"\bcapillary height\b", "equilibrium wicking height"),
    (r"\bareal density\b", "mass per unit area"),
    (r"\bscaled start\b", "warm start"),
    (r"(?:^|(?<=[.!?] ))What (?:[^.!?]|[.!](?!\s))*(?:[.!](?=\s)|$)", "a sentence with a noun as its subject"),
]
PATTERNS = [(re.compile(pattern, re.IGNORECASE), better) for pattern, better in IDIOMS]


def pages(root):
    top = [root / name for name in ("README.md", "CHANGELOG.md")]
    found = [page for page in top if page.exists()]
    for folder in ("docs", "scenes"):
        if (root / folder).is_dir():
            found += files(root / folder, {".md"})
    return [page for page in found if not page.is_relative_to(root / "docs/dev")]


def plain(line):
    """A line of prose with a word for each code and formula, without marks, pictures and addresses."""
    line = re.sub(r"\$`[^`]*`\$", " formula ", line)
    line = CODE.sub(" code ", line)
    line = re.sub(r"(?<![\\$])\$(?=\S)[^$]*(?<=\S)\$", " formula ", line)
    line = re.sub(r"!\[[^]]*\]\([^)]*\)", " ", line)
    line = re.sub(r"\[([^]]*)\](?:\([^)]*\)|\[[^]]*\])", r"\1", line)
    line = re.sub(r"</?[A-Za-z][^>]*>|https?://\S+", " ", line)
    return re.sub(r"[*]+|(?<!\w)_+|_+(?!\w)", "", line)


def passages(text):
    """[[(number, plain line)]]: paragraphs; each heading, list item and row of a table by itself."""
    current = []
    for number, line, block in text_lines(text):
        bare = line.strip()
        alone = bare.startswith(("|", "#"))
        if block or not bare or alone or re.match(r"(?:[-*+]|\d+[.)])\s", bare):
            if current:
                yield current
            current = []
        if block or not bare:
            continue
        current.append((number, plain(bare)))
        if alone:
            yield current
            current = []
    if current:
        yield current


def check(root, page):
    """['file:line: message']"""
    name = page.relative_to(root) if page.is_relative_to(root) else page
    offenders = []
    for passage in passages(page.read_text(encoding="utf-8")):
        text, starts = "", []
        for number, line in passage:
            starts.append((len(text), number))
            text += line + " "
        for pattern, better in PATTERNS:
            for match in pattern.finditer(text):
                number = max(line for begin, line in starts if begin <= match.start())
                offenders.append(f'{name}:{number}: "{match[0]}": write: {better}')
    return offenders

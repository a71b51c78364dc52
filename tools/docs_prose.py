"""Sentences of a page: how long they are and how they begin (tools/docs prose).

A sentence is short enough to be read once: at most 35 words, 20 on average over a page. Words have two letters or more.
An item of a list is a sentence of its own, whatever it ends with. Headings, tables, blocks of code and displayed formulas
are left out; code and a formula within a sentence are a word each."""

import re
from dataclasses import dataclass, field

from docs_pages import CODE, files, text_lines

LONGEST, MEAN = 35, 20
ITEM = re.compile(r"^\s*(?:[-*+]|\d+[.)])\s+")
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|etc|al|cf|vs|approx|Eqs?|Figs?|Sec|No)\.(?=\s)")
END = re.compile(r"(?<=[.!?])[\"')\]]*\s+")


@dataclass
class Measured:
    offenders: list = field(default_factory=list)
    sentences: int = 0
    words: int = 0
    longest: int = 0


def pages(root):
    top = [root / name for name in ("README.md", "CONTRIBUTING.md")]
    return [page for page in top if page.exists()] + (files(root / "docs", {".md"}) if (root / "docs").is_dir() else [])


def plain(line):
    """A line of prose with a word for each code and formula, without marks, pictures and addresses."""
    line = re.sub(r"\$`[^`]*`\$", " formula ", line)
    line = CODE.sub(" code ", line)
    line = re.sub(r"(?<![\\$])\$(?=\S)[^$]*(?<=\S)\$", " formula ", line)
    line = re.sub(r"!\[[^]]*\]\([^)]*\)", " ", line)
    line = re.sub(r"\[([^]]*)\](?:\([^)]*\)|\[[^]]*\])", r"\1", line)
    line = re.sub(r"</?[A-Za-z][^>]*>|https?://\S+", " ", line)
    return ABBREVIATION.sub(lambda found: found[1].replace(".", ""), re.sub(r"[*]+|(?<!\w)_+|_+(?!\w)", "", line))


def paragraphs(text):
    """[[(number, plain line)]]: what is read in one go; a list's items are paragraphs of their own."""
    found, current = [], []

    def close():
        nonlocal current
        if current:
            found.append(current)
        current = []

    for number, line, block in text_lines(text):
        line = re.sub(r"^\s*(?:>\s?)+", "", line)
        bare = line.strip()
        if block or not bare or bare.startswith(("|", "#")) or re.match(r"^\[[^]]+\]:|^(---+|===+|\*\*\*+)$|^\[!\w+\]$", bare):
            close()
            continue
        if ITEM.match(line):
            close()
            bare = ITEM.sub("", line).strip()
        current.append((number, plain(bare)))
    close()
    return found


def sentences(paragraph):
    """[(number of its first line, text)]"""
    text, starts = "", []
    for number, line in paragraph:
        starts.append((len(text), number))
        text += line + " "
    at = 0
    for part in END.split(text):
        start = text.index(part, at)
        at = start + len(part)
        if part.strip():
            yield max(number for begin, number in starts if begin <= start), part.strip()


def measure(root, page):
    name = page.relative_to(root) if page.is_relative_to(root) else page
    measured = Measured()
    for paragraph in paragraphs(page.read_text(encoding="utf-8")):
        for number, sentence in sentences(paragraph):
            words = re.findall(r"[A-Za-z]{2,}", sentence)
            if not words:
                continue
            measured.sentences += 1
            measured.words += len(words)
            measured.longest = max(measured.longest, len(words))
            if len(words) > LONGEST:
                measured.offenders.append(f"{name}:{number}: {len(words)} words in a sentence, {LONGEST} allowed: "
                                          f"{sentence[:80]}…")
            if words[0].lower() == "what" and not sentence.endswith("?"):
                measured.offenders.append(f'{name}:{number}: a sentence begins with "what": {sentence[:80]}…')
    if measured.sentences and measured.words > MEAN * measured.sentences:
        measured.offenders.append(f"{name}:1: {measured.words / measured.sentences:.1f} words a sentence on average, "
                                  f"{MEAN} allowed")
    return measured

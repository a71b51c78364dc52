"""Sentences of a page (tools/docs prose): none begins with a bare "what", unless it is a question.

An item of a list is a sentence of its own, whatever it ends with. Headings, tables, code blocks and displayed formulas are
left out; code and a formula within a sentence count as a word each."""

import re
from dataclasses import dataclass, field

from page_text import CODE, files, text_lines

ITEM = re.compile(r"^\s*(?:[-*+]|\d+[.)])\s+")
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|etc|al|cf|vs|approx|Eqs?|Figs?|Sec|No)\.(?=\s)")
END = re.compile(r"(?<=[.!?])[\"')\]]*\s+")


@dataclass
class Found:
    offenders: list = field(default_factory=list)
    sentences: int = 0


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
    """[[(number, plain line)]]: lines that belong together; each item of a list is a paragraph of its own."""
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


def check(root, page):
    name = page.relative_to(root) if page.is_relative_to(root) else page
    found = Found()
    for paragraph in paragraphs(page.read_text(encoding="utf-8")):
        for number, sentence in sentences(paragraph):
            words = re.findall(r"[A-Za-z]{2,}", sentence)
            if not words:
                continue
            found.sentences += 1
            if words[0].lower() == "what" and not sentence.endswith("?"):
                found.offenders.append(f'{name}:{number}: sentence begins with "what": {sentence[:80]}')
    return found

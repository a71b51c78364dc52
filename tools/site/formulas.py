"""Formulas of a page as MathML: LaTeX between `$`, between `$$`, and in blocks ```math. A Markdown extension for MkDocs.

Browsers implement MathML Core, which has no bold or sans-serif letters and no numbered equations; classes of site.css replace
them. A command that latex2mathml does not know, or a `$` without its partner, ends the build with an error.
"""

import html
import re
import unicodedata
import xml.etree.ElementTree as xml

from latex2mathml.converter import convert
from markdown.extensions import Extension
from markdown.preprocessors import Preprocessor

from page_text import CODE

INLINE = re.compile(r"(?<![\\$\w])\$(?=[^\s$])([^$\n]*?)(?<=[^\s$])\$(?![$\w])")
DELIMITERS = {r"\lfloor": "⌊", r"\rfloor": "⌋", r"\lceil": "⌈", r"\rceil": "⌉", r"\lvert": "|", r"\rvert": "|",
              r"\lVert": "‖", r"\rVert": "‖", r"\langle": "⟨", r"\rangle": "⟩"}
CLASSES = {"bold": "bold", "bold-italic": "bold", "sans-serif": "sans", "monospace": "mono"}
ALPHABETS = {"script": "MATHEMATICAL SCRIPT", "double-struck": "MATHEMATICAL DOUBLE-STRUCK"}


class FormulaError(ValueError):
    pass


def prepare(latex):
    """(LaTeX that latex2mathml knows, tag or None)."""
    tags = re.findall(r"\\tag\{([^}]*)\}", latex)
    if len(tags) > 1:
        raise FormulaError(f"two tags in {latex.strip()}")
    latex = re.sub(r"\\tag\{[^}]*\}", "", latex)
    latex = re.sub(r"\\cr\b", r"\\\\", latex)
    latex = re.sub(r"\\\\\s*\[[^]]*\]", r"\\\\ ", latex)  # space between rows
    latex = re.sub(r"(\\[bB]ig+[lr]?)\s*(\\[lr](?:floor|ceil|[vV]ert|angle))(?![a-zA-Z])",
                   lambda found: found[1] + DELIMITERS[found[2]], latex)
    latex = re.sub(r"\\mathrel\{([^}]*)\}", r"\1", latex)
    latex = re.sub(r"\\arg(?![a-zA-Z])", r"\\operatorname{arg}", latex)
    latex = re.sub(r"\\texttt\{([^}]*)\}", lambda found: r"\mathtt{" + found[1].replace(r"\_", "_").replace("_", r"\_") + "}", latex)
    latex = latex.replace(r"\begin{aligned}", r"\begin{array}{rlrlrl}").replace(r"\end{aligned}", r"\end{array}")
    latex = latex.replace(r"\begin{gathered}", r"\begin{array}{c}").replace(r"\end{gathered}", r"\end{array}")
    return latex.strip(), tags[0] if tags else None


def restyle(element):
    """Replaces attributes that MathML Core lacks."""
    for part in element.iter():
        if part.tag in ("mi", "mn", "mo", "mtext") and part.text:
            letter = unicodedata.normalize("NFKD", part.text)
            if len(part.text) == 1 and unicodedata.name(part.text, "").startswith("MATHEMATICAL BOLD"):
                part.text = letter
                part.set("mathvariant", "bold")
        variant = part.get("mathvariant")
        if variant in CLASSES:
            part.set("class", CLASSES[variant] + (" italic" if "italic" in variant else ""))
            part.set("mathvariant", "normal")
        elif variant in ALPHABETS:
            case = "CAPITAL" if part.text.isupper() else "SMALL"
            try:
                part.text = unicodedata.lookup(f"{ALPHABETS[variant]} {case} {part.text.upper()}")
            except KeyError:
                part.text = unicodedata.lookup(f"{ALPHABETS[variant].split()[-1]} {case} {part.text.upper()}")
            part.set("mathvariant", "normal")


def mathml(latex, display):
    """The HTML of a formula."""
    source, tag = prepare(latex)
    try:
        text = convert(source, display="block" if display else "inline")
        tree = xml.fromstring(re.sub(r' xmlns="[^"]*"', "", text))
    except Exception as error:  # latex2mathml has an exception for each mistake
        raise FormulaError(f"{error!r} in {source}") from error
    for part in tree.iter():
        if "\\" in (part.text or "") or (part.text or "").strip() == "&":
            raise FormulaError(f"{part.text} is not known, in {source}")
    restyle(tree)
    if display:
        for table in tree.iter("mtable"):
            table.set("displaystyle", "true" if "aligned}" in latex or "gathered}" in latex else "false")
    text = xml.tostring(tree, encoding="unicode").replace("\n", " ")
    if not display:
        return text
    number = f'<span class="number">({html.escape(tag)})</span>' if tag else ""
    return f'<div class="formula">{text}{number}</div>'


class FormulaPreprocessor(Preprocessor):
    """Runs after blocks of code are gone, and leaves placeholders that Markdown does not look into."""

    def run(self, lines):
        text = "\n".join(lines)
        text = re.sub(r"^([ ]*)\$\$(.*?)\$\$[ ]*$", self.block, text, flags=re.S | re.M)
        return [self.inline(line) for line in text.split("\n")]

    def store(self, latex, display):
        return self.md.htmlStash.store(mathml(latex, display))

    def block(self, found):
        return f"\n{found[1]}{self.store(found[2], True)}\n"

    def inline(self, line):
        codes = []

        def hide(found):
            codes.append(found[0])
            return f"\x00{len(codes) - 1}\x00"

        line = CODE.sub(hide, line)
        line = re.sub(r"\$\$(.+?)\$\$", lambda found: self.store(found[1], False), line)
        line = INLINE.sub(lambda found: self.store(re.sub("\x00(\\d+)\x00", lambda code: codes[int(code[1])], found[1]), False), line)
        if "$" in line.replace(r"\$", ""):
            raise FormulaError(f"a $ without its partner: {line}")
        return re.sub("\x00(\\d+)\x00", lambda found: codes[int(found[1])], line)


class Formulas(Extension):
    def extendMarkdown(self, md):  # noqa: N802 (Markdown's name)
        md.preprocessors.register(FormulaPreprocessor(md), "formulas", 22)  # after fenced code (25), before raw HTML (20)


def makeExtension(**settings):  # noqa: N802
    return Formulas(**settings)

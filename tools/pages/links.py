"""Links of all pages (tools/docs links): relative ones and anchors lead somewhere, and every page that a page, a comment or
a script names by its file is in the tree."""

import html
import re
from dataclasses import dataclass, field
from urllib.parse import unquote

from page_text import CODE, files, text_lines

SOURCES = {".cpp", ".hpp", ".py", ".cmake", ".yaml", ".sh", ".txt"}
# They name pages that have gone, pages that never were, and pages of the site.
EXEMPT = {"CHANGELOG.md", "tests/app/docs_test.py", "tools/site/stage.py", "tools/site/formulas.py"}
LINK = re.compile(r"\[(?:[^][]|\[[^]]*\])*\]\(\s*<?([^()\s>]*(?:\([^()\s]*\)[^()\s>]*)*)>?(?:\s+\"[^\"]*\")?\s*\)")
DEFINITION = re.compile(r"^\s*\[[^]^][^]]*\]:\s*<?(\S+?)>?(?:\s|$)")
ATTRIBUTE = re.compile(r"<(?:a|img)\b[^>]*?\b(?:href|src)=\"([^\"]*)\"")
NAMED_PAGE = re.compile(r"(?<![\w./$-])((?:\.{1,2}/)*(?:[\w-]+/)*[\w-]+\.md)\b(?!/)")


@dataclass
class Found:
    offenders: list = field(default_factory=list)
    pages: int = 0
    links: int = 0
    names: int = 0


def slug(heading):
    """The anchor that GitHub gives a heading."""
    heading = re.sub(r"!?\[([^]]*)\]\([^)]*\)", r"\1", heading)
    heading = html.unescape(re.sub(r"</?[A-Za-z][^>]*>", "", heading)).strip().lower()
    return re.sub(r"[^\w\- ]", "", heading.replace("*", "")).replace(" ", "-")


def anchors(text):
    found, seen = set(), {}
    for _, line, block in text_lines(text):
        if block:
            continue
        if heading := re.match(r"^#{1,6}\s+(.*?)\s*#*\s*$", line):
            name = slug(heading[1])
            found.add(f"{name}-{seen[name]}" if name in seen else name)
            seen[name] = seen.get(name, 0) + 1
        found.update(re.findall(r"<\w+\b[^>]*?\b(?:id|name)=\"([^\"]+)\"", line))
    return found


def targets(text):
    """[(line's number, address)] of a page's links."""
    for number, line, block in text_lines(text):
        if block:
            continue
        line = CODE.sub(lambda code: " " * len(code[0]), line)
        for address in [*LINK.findall(line), *DEFINITION.findall(line), *ATTRIBUTE.findall(line)]:
            yield number, address


def problem(root, page, address):
    """What is wrong with a link of `page`, or ""."""
    path, _, anchor = address.partition("#")
    target = (page.parent / unquote(path)).resolve() if path else page
    if path.startswith("/") or not target.is_relative_to(root):
        return "leads out of the tree"
    if not target.exists():
        return "leads nowhere"
    if not anchor:
        return ""
    if target.suffix == ".md":
        return "" if unquote(anchor) in anchors(target.read_text(encoding="utf-8")) else "has no such anchor"
    lines = re.fullmatch(r"L(\d+)(?:-L(\d+))?", anchor)
    if not lines or target.is_dir():
        return "has an anchor that only a page can have"
    last = int(lines[2] or lines[1])
    return "" if last <= len(target.read_text(encoding="utf-8").splitlines()) else "is longer than the file"


def named_pages(text):
    """[(line's number, name)] of the pages that a text names, but for addresses of the web."""
    for number, line in enumerate(text.splitlines(), 1):
        for name in NAMED_PAGE.findall(re.sub(r"https?://\S+", "", line)):
            yield number, name


def check(root):
    found = Found()
    all_pages = files(root, {".md"})
    said = set()  # a page that is not there is named once
    known = {str(page.relative_to(root)) for page in all_pages}
    for page in all_pages:
        name = page.relative_to(root)
        found.pages += 1
        for number, address in targets(page.read_text(encoding="utf-8")):
            if re.match(r"[a-z][a-z0-9+.-]*:", address):
                continue
            found.links += 1
            if wrong := problem(root, page, address):
                found.offenders.append(f"{name}:{number}: link {address} {wrong}")
                said.add((name, number))
    scripts = [path for path in sorted((root / "tools").rglob("*")) if path.is_file() and not path.suffix]
    for path in all_pages + files(root, SOURCES) + scripts:
        name = path.relative_to(root)
        if str(name) in EXEMPT:
            continue
        for number, page in named_pages(path.read_text(encoding="utf-8")):
            found.names += 1
            beside = (path.parent / page).resolve()
            if page.startswith(".") and beside.exists():
                continue
            if (name, number) not in said and not any(one == page or one.endswith("/" + page) for one in known):
                found.offenders.append(f"{name}:{number}: names {page}, which is not in the tree")
    return found

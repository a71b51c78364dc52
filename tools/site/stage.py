#!/usr/bin/env python3
"""stage.py ROOT FOLDER: copies the pages of the site and their pictures to FOLDER/pages and writes FOLDER/mkdocs.yml.

The pages stay ordinary Markdown for GitHub. What differs between GitHub and MkDocs is rewritten here: links, anchors of
headings, blank lines before lists and tables, indents of nested lists, and ```math blocks.
"""

import re
import shutil
import sys
from pathlib import Path
from urllib.parse import unquote

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "pages"))
sys.path.insert(0, str(Path(__file__).resolve().parent))
import core_stub  # noqa: E402
from links import slug  # noqa: E402
from page_text import CODE, FENCE  # noqa: E402

SINGLE = {"README.md": "index.md", "docs/README.md": "overview.md", "scenes/README.md": "scenes/keys.md",
          "scenes/gallery/README.md": "gallery/gallery.md", "examples/README.md": "examples/examples.md",
          "CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
LINK = re.compile(r"(!?)\[((?:[^][]|\[[^]]*\]\([^)]*\)|\[[^]]*\])*)\]\(\s*<?([^()\s>]+)>?(\s+\"[^\"]*\")?\s*\)")
LIST_ITEM = re.compile(r"^(\s*)([-*+]|\d+[.)])\s+")
FILE_NAME = re.compile(r"[\w./*-]+")


def pages(root):
    """{page: its name on the site}, both relative."""
    found = {name: target for name, target in SINGLE.items() if (root / name).exists()}
    for page in sorted((root / "docs").rglob("*.md")):
        name = page.relative_to(root).as_posix()
        found.setdefault(name, re.sub(r"README\.md$", "index.md", name.removeprefix("docs/")))
    return found


def from_page(page, target):
    """The address of `target` in the page `page`, both names on the site."""
    return Path(*[".."] * (len(Path(page).parts) - 1), target).as_posix()


class Stage:
    def __init__(self, root, folder):
        self.root, self.folder = root, folder / "pages"
        self.pages = pages(root)
        self.pictures = {}  # {file: its name on the site}

    def picture(self, path):
        name = path.relative_to(self.root).as_posix()
        name = name.removeprefix("docs/").replace("scenes/gallery/", "gallery/")
        self.pictures[path] = name
        return name

    def address(self, page, address):
        """The address of a link on the site, or None where it leads to a file that is no page."""
        if re.match(r"[a-z][a-z0-9+.-]*:|#", address):
            return address
        path, mark, anchor = address.partition("#")
        target = ((self.root / page).parent / unquote(path)).resolve()
        if target.is_dir():
            target /= "README.md"
        if not target.is_relative_to(self.root) or not target.exists():
            return None
        name = target.relative_to(self.root).as_posix()
        if name in self.pages:
            return from_page(self.pages[page], self.pages[name]) + mark + anchor
        if target.suffix in {".png", ".jpg", ".gif", ".webp", ".svg"}:
            return from_page(self.pages[page], self.picture(target))
        return None

    def link(self, page, found):
        mark, text, address, title = found.groups()
        text = LINK.sub(lambda inner: self.link(page, inner), text)
        new = self.address(page, address)
        if new is not None:
            return f"{mark}[{text}]({new}{title or ''})"
        path = ((self.root / page).parent / unquote(address.partition("#")[0])).resolve()
        name = path.relative_to(self.root).as_posix()
        if "`" in text or name.endswith(text.strip("/")):
            return text if "`" in text else f"`{text}`"
        return f"{text} (`{name}`)"

    def line(self, page, text):
        """Rewrites the links of a line, but not in code."""
        codes = []

        def hide(code):
            codes.append(code[0])
            return f"\x00{len(codes) - 1}\x00"

        text = LINK.sub(lambda found: self.link(page, found), CODE.sub(hide, text))
        text = re.sub(r'(<img\b[^>]*\bsrc=")([^"]*)"', lambda found: f'{found[1]}{self.address(page, found[2])}"', text)
        # Links that became code hold no code of their own.
        return re.sub("\x00(\\d+)\x00", lambda found: codes[int(found[1])], text)

    def convert(self, page):
        text = (self.root / page).read_text(encoding="utf-8")
        text = re.sub(r"<!--.*?-->\n?", "", text, flags=re.S)
        text = re.sub(r"^ *(\[?!\[[^]]*\]\(https?://[^)]*\)(\]\([^)]*\))?\s*)+$\n?", "", text, flags=re.M)  # badges
        text = re.sub(r"^( *)```math\n(.*?)^ *```", r"\1$$\n\2$$", text, flags=re.M | re.S)
        lines, fence, formula, seen, before, indents = [], None, False, {}, "", []
        for line in text.splitlines():
            mark = FENCE.match(line)
            if fence or mark or formula:
                if fence and mark and mark[1].startswith(fence) and not line.strip().strip(fence[0]):
                    fence = None
                elif mark and not fence:
                    fence = mark[1]
                formula ^= not fence and not mark and line.count("$$") % 2 == 1
                lines.append(self.indented(line, indents))
                before = line
                continue
            if line.count("$$") % 2 == 1:
                formula = True
                if before.strip() and not line.startswith(" "):
                    lines.append("")
            elif heading := re.match(r"^(#{1,6})\s+(.*?)\s*#*$", line):
                name = slug(heading[2])
                count = seen[name] = seen.get(name, -1) + 1
                line = f"{heading[1]} {heading[2]} {{: #{name + (f'-{count}' if count else '')} }}"
                indents = []
                if before.strip():
                    lines.append("")
            elif item := LIST_ITEM.match(line):
                while indents and indents[-1] > len(item[1]):
                    indents.pop()
                if not indents or indents[-1] < len(item[1]):
                    if not indents and before.strip():
                        lines.append("")
                    indents.append(len(item[1]))
                line = "    " * (len(indents) - 1) + line.lstrip()
                lines.append(self.line(page, line))
                before = line
                continue
            elif line.strip() and not line.startswith(" ") and not before.strip():
                indents = []
            if line.startswith("|") and before.strip() and not before.startswith("|"):
                lines.append("")
            if not line.startswith("|") and before.startswith("|") and line.strip():
                lines.append("")
            lines.append(self.line(page, self.indented(line, indents)))
            before = line
        return "\n".join(lines) + "\n"

    @staticmethod
    def indented(line, indents):
        """A line of a list item, indented as Python-Markdown wants it: four spaces per level."""
        if not indents or not line.startswith(" "):
            return line
        depth = sum(1 for indent in indents if len(line) - len(line.lstrip()) > indent)
        cut = indents[depth - 1] + 2 if depth else 0
        return "    " * depth + line[min(cut, len(line) - len(line.lstrip())):]

    def write(self):
        shutil.rmtree(self.folder, ignore_errors=True)
        for page, name in self.pages.items():
            target = self.folder / name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(self.convert(page), encoding="utf-8")
        for path, name in self.pictures.items():
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, self.folder / name)


def navigation(entries, names):
    """The entries of nav.yml with FOLDER/* replaced by the pages that no other entry names."""
    def named(entry):
        if isinstance(entry, str):
            return {entry}
        return set().union(*map(named, entry.values() if isinstance(entry, dict) else entry))

    left = names - named(entries)

    def expand(entry):
        if isinstance(entry, dict):
            return [{title: expand(value)[0] if isinstance(value, str) else
                     [one for part in value for one in expand(part)]} for title, value in entry.items()]
        if not entry.endswith("/*"):
            return [entry]
        return sorted(name for name in left if str(Path(name).parent) == entry[:-2])

    return [one for entry in entries for one in expand(entry)]


def main():
    root, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    here = Path(__file__).resolve().parent
    stage = Stage(root, folder)
    stage.write()
    for name in ("site.css", "iframe-worker.js"):
        shutil.copyfile(here / name, stage.folder / name)
    shutil.copyfile(here / "python_api.md.in", stage.folder / "api/python_api.md")
    doxygen = root / "build/docs/html"
    if (doxygen / "index.html").is_file():
        shutil.copytree(doxygen, stage.folder / "api/doxygen")
        with open(stage.folder / "api/mainpage.md", "a", encoding="utf-8") as page:
            page.write("\n## All classes and functions\n\nThe [reference by Doxygen](doxygen/index.html) describes every declaration.\n")
    package = folder / "python/drench"
    shutil.copytree(root / "python/drench", package, dirs_exist_ok=True)
    for module in package.glob("*.py"):  # mkdocstrings reads a text below a value, not `#:` above it
        text = module.read_text(encoding="utf-8")
        module.write_text(re.sub(r"^( *)#: (.*)\n(.*)$", r'\3\n\1"""\2"""', text, flags=re.M), encoding="utf-8")
    (package / "_core.py").write_text(core_stub.stub(root / "python/src"), encoding="utf-8")
    names = {page.relative_to(stage.folder).as_posix() for page in stage.folder.rglob("*.md")}
    nav = navigation(yaml.safe_load((here / "nav.yml").read_text(encoding="utf-8")), names)
    settings = {"INHERIT": str(here / "mkdocs.yml"), "docs_dir": str(stage.folder), "site_dir": str(root / "build/site"), "nav": nav}
    (folder / "mkdocs.yml").write_text(yaml.safe_dump(settings, sort_keys=False, allow_unicode=True), encoding="utf-8")


main()

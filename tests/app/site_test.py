#!/usr/bin/env python3
"""site_test.py SOURCE: `tools/docs site` builds without warnings; every address in its pages exists, no formula is left as
LaTeX, and nothing comes from the network. Exit code 77, skipped, without the environment .deps/site."""

import re
from html.parser import HTMLParser
from urllib.parse import unquote

from support import SOURCE, call, expect, skip

SITE = SOURCE / "build/site"
WEB = re.compile(r"[a-z][a-z0-9+.-]*:|//")
LATEX = re.compile(r"\$\$|\\(?:mathbf|frac|begin|tag|sum)\b")


class Page(HTMLParser):
    """Addresses, anchors and formulas of a page, and its text outside code."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loaded, self.ids, self.text, self.formulas, self._code = [], [], set(), [], 0, 0
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.ids.update(filter(None, (attributes.get("id"), attributes.get("name"))))
        loads = tag in ("img", "script", "iframe", "source") or (tag == "link" and attributes.get("rel") != "canonical")
        for address in filter(None, (attributes.get("href"), attributes.get("src"))):
            (self.loaded if loads else self.links).append(address)
        self.formulas += tag == "math"
        self._code += tag in ("code", "script", "style")

    def handle_endtag(self, tag):
        self._code -= tag in ("code", "script", "style")

    def handle_data(self, data):
        if not self._code:
            self.text.append(data)


def check_pages():
    pages = {path: Page(path) for path in sorted(SITE.rglob("*.html")) if "doxygen" not in path.parts}
    expect(len(pages) > 60 and sum(page.formulas for page in pages.values()) > 2000, f"only {len(pages)} pages, or few formulas")
    wrong = []
    for path, page in pages.items():
        name = path.relative_to(SITE)
        wrong += [f"{name} loads {address}" for address in page.loaded if WEB.match(address) and not address.startswith("data:")]
        if found := LATEX.search(" ".join(page.text)):
            wrong.append(f"{name} has LaTeX left: {found[0]}")
        for address in page.links + page.loaded:
            if WEB.match(address) or (name.name == "404.html" and address.startswith("/")):
                continue
            file, _, anchor = address.partition("#")
            target = (path.parent / unquote(file.partition("?")[0])).resolve() if file else path
            target = target / "index.html" if target.is_dir() else target
            if not target.is_file():
                wrong.append(f"{name}: {address} leads nowhere")
            elif anchor and target in pages and unquote(anchor) not in pages[target].ids:
                wrong.append(f"{name}: {address} has no such anchor")
    expect(not wrong, "\n".join(wrong[:20]))


stamp, wanted = SOURCE / ".deps/site/requirements.txt", SOURCE / "tools/site/requirements.txt"
if not stamp.is_file() or stamp.read_text() != wanted.read_text():  # a test must not download
    skip("no environment for the site; tools/docs site")
built = call(SOURCE / "tools/docs", "site")
expect(built.returncode == 0, f"tools/docs site ended with {built.returncode}:\n{built.stdout}{built.stderr}")
check_pages()

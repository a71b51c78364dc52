#!/usr/bin/env python3
"""site_test.py SOURCE: `tools/docs site` builds without warnings; every address in its pages exists, no formula is left as
LaTeX, nothing comes from the network, and Chromium shows formulas. Exit code 77, skipped, without the environment .deps/site."""

import re
import shutil
import subprocess
import sys
import tempfile
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

SOURCE = Path(sys.argv[1]).resolve()
SITE = SOURCE / "build/site"
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
WEB = re.compile(r"[a-z][a-z0-9+.-]*:|//")
LATEX = re.compile(r"\$\$|\\(?:mathbf|frac|begin|tag|sum)\b")


def expect(good, message):
    if not good:
        sys.exit(f"site_test: {message}")


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


def browse(folder, page, script):
    """The title that `script` leaves in a copy of `page`. The browser knows no network."""
    copy = page.with_name("site_test_" + page.name)
    copy.write_text(page.read_text(encoding="utf-8").replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    try:
        ran = subprocess.run([BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--allow-file-access-from-files",
                              "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={folder}/profile", "--dump-dom",
                              f"file://{copy}"], capture_output=True, text=True, timeout=120)
    finally:
        copy.unlink()
    expect(ran.returncode == 0, f"{BROWSER} ended with {ran.returncode}: {ran.stderr[-400:]}")
    return re.search("<title>(.*?)</title>", ran.stdout, re.S)[1]


def check_in_browser():
    with tempfile.TemporaryDirectory(prefix="drench_site_") as folder:
        shown = browse(folder, SITE / "index.html", "document.title=[...document.images].filter(i=>!i.complete||i.naturalWidth==0).length"
                       "+' '+document.querySelectorAll('nav a').length")
        missing, links = map(int, shown.split())
        expect(missing == 0 and links > 60, f"the first page has {missing} pictures missing and {links} links to pages")
        shown = browse(folder, SITE / "theory/cloth.html", "const b=m=>m.getBoundingClientRect(),t=document.querySelector('math mfrac');"
                       "document.title=b(t).height/b(t.firstElementChild).height")
        expect(float(shown) > 1.5, "the browser does not stack fractions")


if __name__ == "__main__":
    stamp = SOURCE / ".deps/site/requirements.txt"
    wanted = SOURCE / "tools/site/requirements.txt"
    if not stamp.is_file() or stamp.read_text() != wanted.read_text():  # a test must not download
        print("SKIPPED: no environment for the site; tools/docs site")
        sys.exit(77)
    ran = subprocess.run([SOURCE / "tools/docs", "site"], capture_output=True, text=True)
    expect(ran.returncode == 0, f"tools/docs site ended with {ran.returncode}:\n{ran.stdout}{ran.stderr}")
    check_pages()
    if BROWSER:
        check_in_browser()
    print("site_test: all good" + ("" if BROWSER else ", but no Chromium: tools/setup browser"))

#!/usr/bin/env python3
"""docs_test.py SOURCE: tools/docs reports the problems of bad pages and none in this tree; CITATION.cff,
README.md and CHANGELOG.md name the version. Exit code 77, skipped, where Doxygen is missing and nothing else is wrong."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(sys.argv[1]).resolve()
CHECKS = ("prose", "idioms", "links", "excerpts")
GOOD = """# Good page
Two short sentences stand here. The second, of e.g. ten words, is not split at its abbreviation.

- an item that ends without a full stop
  1. nested: `code in place of prose`, which is not searched for idioms

| a table | `is refused` |
|---|---|

```
what stands in a block of code is left out too, in place of nothing
[no link](nowhere.txt)
```
$$ a = \\text{formulas are left out, in place of nothing} $$

<!-- source: docs/code.cpp -->
```cpp
// as docs/good.md has it
```

## Twice
## Twice
[this page](#good-page), [again](good.md#twice-1), [a line](code.cpp#L2), ![picture](../picture.png), `[no](link.txt)`
"""
# A page's text, and the problem that must be reported for it.
BAD = {
    "what": ("Good.\nWhat it does is this.", 'docs/what.md:2: sentence begins with "what"'),
    "place": ("Use a key\nin place\nof another.", 'docs/place.md:2: "in place of"'),
    "table": ("| Key | Use |\n|---|---|\n| `a` | is refused |", 'docs/table.md:3: "is refused"'),
    "heading": ("# The books", 'docs/heading.md:1: "books"'),
    "per": ("It takes 3 ms a step.", 'docs/per.md:1: "ms a step"'),
    "says": ("- Then the log says why.", 'docs/says.md:1: "the log says"'),
    "nowhere": ("[a page](absent.md)", "docs/nowhere.md:1: link absent.md leads nowhere"),
    "picture": ("\n![a picture](absent.png)", "docs/picture.md:2: link absent.png leads nowhere"),
    "anchor": ("[an anchor](good.md#absent)", "docs/anchor.md:1: link good.md#absent has no such anchor"),
    "third": ("[an anchor](good.md#twice-2)", "docs/third.md:1: link good.md#twice-2 has no such anchor"),
    "own": ("[an anchor](#twice)", "docs/own.md:1: link #twice has no such anchor"),
    "past": ("[a line](code.cpp#L9)", "docs/past.md:1: link code.cpp#L9 is longer than the file"),
    "out": ("[a page](../../README.md)", "docs/out.md:1: link ../../README.md leads out of the tree"),
    "definition": ("See [it][1].\n\n[1]: absent.md", "docs/definition.md:3: link absent.md leads nowhere"),
    "excerpt": ("<!-- source: docs/code.cpp -->\n```cpp\n// as it is not\n```",
                "docs/excerpt.md:1: excerpt is not in docs/code.cpp"),
    "excerpt_of": ("<!-- source: absent.cpp -->\n```cpp\n```", "docs/excerpt_of.md:1: excerpt of absent.cpp"),
    "named": ("See `absent_page.md`.", "docs/named.md:1: names absent_page.md, which is not in the tree"),
}


def docs(root, *arguments):
    ran = subprocess.run([SOURCE / "tools/docs", "--root", root, *arguments], capture_output=True, text=True)
    return ran.returncode, ran.stdout + ran.stderr


def expect(good, message):
    if not good:
        sys.exit(f"docs_test: {message}")


def check_the_checks():
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "tree"
        (root / "docs").mkdir(parents=True)
        (root / "picture.png").touch()
        (root / "docs/code.cpp").write_text("// as docs/good.md has it\n\n")
        (root / "docs/good.md").write_text(GOOD)
        code, said = docs(root, *CHECKS)
        expect(code == 0 and "4 links" in said and "1 quoted" in said, f"problems in a good page:\n{said}")
        for name, (text, message) in BAD.items():
            page = root / "docs" / f"{name}.md"
            page.write_text(text + "\n")
            code, said = docs(root, *CHECKS)
            offenders = [line for line in said.splitlines() if not line.startswith(tuple(f"{check}:" for check in CHECKS))]
            expect(code == 1, f"{name}.md passes")
            expect(any(line.startswith(message) for line in offenders), f"'{message}' is not reported for {name}.md:\n{said}")
            page.unlink()
        (root / "docs/code.cpp").write_text("// gone: absent_page.md\n\n")
        code, said = docs(root, "links")
        expect(code == 1 and "docs/code.cpp:1: names absent_page.md" in said, f"a comment that names a missing page passes:\n{said}")
        code, said = docs(root, "idioms")
        dev = root / "docs/dev/note.md"
        dev.parent.mkdir()
        dev.write_text("In place of this.\n")
        expect(code == docs(root, "idioms")[0] == 0, f"idioms of developer pages are checked:\n{said}")


def check_citation():
    version = re.search(r"^project\(drench VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text(), re.M)
    expect(f"\nversion: {version[1]}\n" in (SOURCE / "CITATION.cff").read_text(), f"CITATION.cff is not of {version[1]}")
    expect(f"version = {{{version[1]}}}" in (SOURCE / "README.md").read_text(), f"README.md's BibTeX is not of {version[1]}")
    newest = re.search(r"^## (\S+)", (SOURCE / "CHANGELOG.md").read_text(), re.M)
    expect(newest[1] in (version[1], "Unreleased"), f"CHANGELOG.md begins with {newest[1]}, the version is {version[1]}")


check_the_checks()
check_citation()
code, said = docs(SOURCE)
print(said, end="")
sys.exit(code)

#!/usr/bin/env python3
"""docs_test.py SOURCE: tools/docs finds what is wrong with pages that are wrong, and nothing wrong with ours; CITATION.cff,
README.md and CHANGELOG.md name the version. Exit code 77, skipped, where Doxygen is missing and nothing else is wrong."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(sys.argv[1]).resolve()
GOOD = """# Good page
Two short sentences stand here. The second, of e.g. ten words, is not split at its abbreviation.

- an item of eleven words that ends without any full stop at all
- another one, which must not be joined to the item before it, for then both would be too long
  1. nested: `code with very many words that are not counted at all as they are code and no prose of ours`

| a table | is left out however long its cells are, for nobody reads a table as a sentence, and so on and on and on, on |
|---|---|

```
what stands in a block of code is left out too, and it may be as long as anybody wants it to be, on and on and on and on and on
[no link](nowhere.txt)
```
$$ a = \\text{formulas are left out, with as many words as anybody likes to put into their text, one two three four five six} $$

<!-- source: docs/code.cpp -->
```cpp
// as docs/good.md has it
```

## Twice
## Twice
[this page](#good-page), [again](good.md#twice-1), [a line](code.cpp#L2), ![picture](../picture.png), `[no](link.txt)`
"""
LONG = "This sentence " + "goes on and on " * 9 + "to its end."
MEAN = "- " + "word " * 33 + "\n- " + "word " * 8
# A page's text, and what must be said of it.
BAD = {
    "long": (LONG, "docs/long.md:1: 41 words"),
    "long_by_lines": ("Fine.\n\nIt begins here\n" + "and goes on\n" * 12 + "to its end.", "docs/long_by_lines.md:3: 42 words"),
    "long_item": ("A list:\n\n- short\n- " + LONG, "docs/long_item.md:4: 41 words"),
    "mean": (MEAN, "docs/mean.md:1: 20.5 words a sentence on average"),
    "what": ("Good.\nWhat it does is this.", 'docs/what.md:2: a sentence begins with "what"'),
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
        code, said = docs(root, "prose", "links", "excerpts")
        expect(code == 0 and "4 links" in said and "1 blocks" in said, f"a good page is not:\n{said}")
        for name, (text, message) in BAD.items():
            page = root / "docs" / f"{name}.md"
            page.write_text(text + "\n")
            code, said = docs(root, "prose", "links", "excerpts")
            offenders = [line for line in said.splitlines() if not line.startswith(("prose:", "links:", "excerpts:"))]
            expect(code == 1, f"{name}.md passes")
            expect(any(line.startswith(message) for line in offenders), f"'{message}' is not said of {name}.md:\n{said}")
            page.unlink()
        (root / "docs/code.cpp").write_text("// gone: absent_page.md\n\n")
        code, said = docs(root, "links")
        expect(code == 1 and "docs/code.cpp:1: names absent_page.md" in said, f"a comment may name any page:\n{said}")


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

"""sanitizer_reports.py SOURCE_DIR MODULE FILE...: faults that AddressSanitizer wrote about a Python module. Ends with 1 if there
are any.

Python keeps much until it ends, and its own leaks are reported too. A leak is the module's where nobody else's lost memory leads to
it (it is direct), and where the module asks for the memory itself: its own file or source stands above the first function of
Python."""

import os
import re
import sys

PYTHON = re.compile(r" in (?:_?Py[A-Z_]\w*|_Py\w+) |(?:libpython|/python)[0-9.]*(?:\.so[0-9.]*)?\+0x")


def is_ours(leak, source, module):
    """The source holds .deps too, whose libraries are not ours."""
    for line in leak.splitlines():
        if not line.lstrip().startswith("#"):
            continue
        if re.search(rf"/{re.escape(module)}[^/]*\.so\+0x", line) or (source + "/" in line and "/.deps/" not in line):
            return True
        if PYTHON.search(line):
            return False
    return False


def faults_in(text, source, module):
    blocks = re.split(r"\n\s*\n", text)
    leaks = [block for block in blocks if re.search(r"(?:Direct|Indirect) leak of ", block)]
    others = [block for block in blocks if re.search(r"ERROR: AddressSanitizer|runtime error:", block)]
    return others + [leak for leak in leaks if "Direct leak" in leak and is_ours(leak, source, module)], len(leaks)


def main():
    source, module, found, leaks = sys.argv[1], sys.argv[2], [], 0
    for path in sys.argv[3:]:
        if not os.path.isfile(path):  # a pattern that nothing fits: nothing was written
            continue
        with open(path, encoding="utf-8", errors="replace") as file:
            faults, count = faults_in(file.read(), source, module)
        found += faults
        leaks += count
    print(*found[:20], sep="\n\n", end="\n\n" if found else "")
    print(f"{len(found)} faults of {module}; {leaks - len([f for f in found if 'leak of' in f])} leaks of Python and its libraries")
    sys.exit(1 if found else 0)


main()

#!/usr/bin/env python3
"""doxygen_filter.py FILE: a file as Doxygen is to read it (docs/api/Doxyfile). In a header the comment behind a member is its
documentation, and the table of the state's fields stands as members. In a page formulas stand as GitHub wants them, and
pages that it links to are not in the book."""

import os
import re
import sys

sys.dont_write_bytecode = True
from page_text import CODE, text_lines  # noqa: E402


FIELD = re.compile(r'^\s*FIELD\((\w+),\s*(\w+),\s*([\w:]+),\s*"([^"]*)".*?\)\s*(?:/\*\s*(.*?)\s*\*/)?\s*\\?$', re.M)


def fields(path):
    """The state's arrays as members, from the lists of state/fields.hpp."""
    with open(os.path.join(os.path.dirname(path), "fields.hpp"), encoding="utf-8") as file:
        lists = FIELD.findall(file.read())
    return "".join(f"  std::vector<{kind}> {owner}_{name};  ///< {unit}{'; ' if note else ''}{note}\n"
                   for owner, name, kind, unit, note in lists)


def of_header(text, path):
    text = re.sub(r"^ *DRENCH_STATE_FIELDS\(DRENCH_ARRAY\)\n", lambda _: fields(path), text, flags=re.M)
    text = re.sub(r"^ *bool operator==\(.*= default;$", "", text, flags=re.M)  # speaks for itself
    return re.sub(r"^(\s*[^/\s].*?[;,{]\s+)// (?=\S)", r"\1///< ", text, flags=re.M)


def of_page(text):
    lines = []
    for _, line, block in text_lines(text):
        if not block:
            parts, at = [], 0
            for code in [*CODE.finditer(line), None]:
                prose = line[at:code.start() if code else None]
                prose = re.sub(r"\[([^]]*)\]\((?:\.\./)*([^):]*)\)", r"\1 (\2)", prose)
                parts.append(re.sub(r"(?<![\\$])\$(?=\S)([^$]*)(?<=\S)\$", r"\\f$\1\\f$", prose))
                if code:
                    parts.append(code[0])
                    at = code.end()
            line = "".join(parts)
        elif line.count("$$") == 2:
            line = re.sub(r"\$\$(.*)\$\$", r"\\f[\1\\f]", line)
        lines.append(line)
    return "\n".join(lines) + "\n"


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        text = file.read()
    sys.stdout.reconfigure(encoding="utf-8")
    sys.stdout.write(of_page(text) if sys.argv[1].endswith(".md") else of_header(text, sys.argv[1]))


main()

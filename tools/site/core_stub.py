"""The public part of the compiled module drench._core as a Python file for mkdocstrings, from the C++ sources of the module."""

import re

TEXT = r'((?:"(?:[^"\\]|\\.)*"\s*)+)'
SIGNATURES = {"info": "info() -> dict[str, str]", "set_threads": "set_threads(threads: int) -> int", "schema": "schema() -> str"}
BASES = {"PyExc_RuntimeError": "RuntimeError", "of_value": "Error, ValueError", "base": "Error"}


def joined(literals):
    return "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', literals)).replace('\\"', '"')


def stub(folder):
    """The text of a module that has what drench/__init__.py takes from _core. `folder`: python/src."""
    source = "".join(path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.cpp")))
    lines = ["__version__: str", '"""Version of drench."""', "precision: str", '"""`float` or `double`."""', ""]
    for name, text, base in re.findall(r'new_class\(m, "(\w+)",\s*' + TEXT + r",\s*(\w+)\)", source):
        lines += [f"class {name}({BASES[base]}):", f'    """{joined(text)}"""', ""]
    if "class StaleView" not in "\n".join(lines):
        found = re.search(r'"(?:drench\._core\.)?StaleView",\s*' + TEXT, source)
        lines += ["class StaleView(Error):", f'    """{joined(found[1]) if found else "A view of a step that is over."}"""', ""]
    for name, text in re.findall(r'm\.def\("(\w+)",[^"]*?(?:nb::arg\("\w+"\),\s*)?' + TEXT + r"\)", source):
        if name in SIGNATURES:
            lines += [f"def {SIGNATURES[name]}:", f'    """{joined(text)}"""', ""]
    return "\n".join(lines)

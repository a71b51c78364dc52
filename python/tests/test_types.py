"""The types that tools read: a stub beside the module, and a mark that the package has types."""

import ast
import re
from pathlib import Path

import drench
from drench import _core

PACKAGE = Path(drench.__file__).parent


def declared(body):
    """{name: node} of what a module's or a class's stub declares."""
    names = {}
    for node in body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names[node.name] = node
        elif isinstance(node, ast.AnnAssign):
            names[node.target.id] = node
        elif isinstance(node, ast.Assign):
            names.update({target.id: node for target in node.targets})
    return names


def test_the_version_is_that_of_the_library():
    assert drench.__version__ == drench.info()["version"]
    assert re.fullmatch(r"\d+\.\d+\.\d+", drench.__version__)


def test_the_stub_declares_all_that_the_module_has():
    assert (PACKAGE / "py.typed").exists()
    stub = declared(ast.parse((PACKAGE / "_core.pyi").read_text()).body)
    public = {name for name in dir(_core) if not name.startswith("_")}
    assert public - set(stub) == set()
    for name in public:
        value = getattr(_core, name)
        if isinstance(value, type) and not issubclass(value, Exception):
            members = {member for member in vars(value) if not member.startswith("_")}
            assert members - set(declared(stub[name].body)) == set(), name


def test_every_function_of_the_stub_says_what_it_returns():
    functions = [node for node in ast.walk(ast.parse((PACKAGE / "_core.pyi").read_text())) if isinstance(node, ast.FunctionDef)]
    assert len(functions) > 10
    assert [node.name for node in functions if node.returns is None] == []

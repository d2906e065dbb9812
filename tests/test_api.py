"""The public API: lazy, complete, and functions stay functions in whatever order things are imported."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import workbench

SHADOWED = ("diagnose", "compensate", "simulate", "fit", "problem")
ORDERS = [
    "from workbench import diagnose, fit, problem",
    "import workbench.diagnose.run, workbench.fit, workbench.compensate.command, workbench.simulate",
    "import workbench.cli\nfrom workbench.problem import Problem\nfrom workbench.diagnose import verdict",
    "from workbench.report.outcome import write_outcome\nfrom workbench import *",
]


def run(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("name", workbench.__all__)
def test_every_name_is_there(name):
    value = getattr(workbench, name)
    assert value.__name__ == name
    assert value.__doc__
    assert name in dir(workbench)


def test_types_and_names_agree():
    tree = ast.parse(Path(workbench.__file__).read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    seen = {
        alias.name: node.module
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert seen == workbench._HOME
    assert (Path(workbench.__file__).parent / "py.typed").is_file()


@pytest.mark.parametrize("first", ORDERS)
def test_functions_are_not_shadowed_by_modules(first):
    names = ", ".join(f"w.{name}" for name in SHADOWED)
    code = f"{first}\nimport workbench as w\nprint([type(x).__name__ for x in ({names})])"
    assert run(code).strip() == str(["function"] * len(SHADOWED))


def test_import_costs_nothing():
    heavy = run(
        "import sys, workbench\n"
        "from workbench import InputError\n"
        "print([m for m in sys.modules if m.split('.')[0] in ('numpy', 'pydrake', 'scipy')])"
    )
    assert heavy.strip() == "[]"


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = workbench.nothing

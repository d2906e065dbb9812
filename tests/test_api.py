"""The public API: lazy, complete, and without tricks on modules."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import workbench

OTHER_NAMES = ("Array", "problem")  # of a NumPy type, of `problem_of`


def run(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("name", workbench.__all__)
def test_every_name_is_there(name):
    value = getattr(workbench, name)
    if name not in OTHER_NAMES:
        assert value.__name__.rpartition(".")[2] == name  # modules have their path
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


def test_every_module_imports_as_python_says():
    """`import a.b as m` gives the module, and public names stay what they are, whatever came first."""
    package = Path(workbench.__file__).parent
    names = [
        ".".join(("workbench", *p.relative_to(package).with_suffix("").parts)) for p in package.rglob("*.py")
    ]
    names = [name.removesuffix(".__init__") for name in names if not name.endswith("__main__")]
    code = "\n".join(f"import {name} as m; assert m.__name__ == {name!r}, m" for name in sorted(names))
    run(
        f"{code}\nimport workbench as w\nfor n in w.__all__:\n"
        f" assert getattr(w, n).__name__.rpartition('.')[2] == n or n in {OTHER_NAMES}, n"
    )


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


def test_the_version_is_that_of_the_source_tree():
    """And the page of changes begins with it."""
    root = Path(workbench.__file__).parents[1]
    assert workbench.__version__ in (root / "pyproject.toml").read_text(encoding="utf-8")
    changes = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    assert changes.split("## ")[1].startswith(workbench.__version__)

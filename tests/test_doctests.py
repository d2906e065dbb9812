"""The examples in the docstrings of what a user calls first run as they stand, in a folder of their own."""

from __future__ import annotations

import doctest

import pytest

import workbench

FIRST = (
    "compensate", "diagnose", "load_campaign", "load_path", "load_robot",
    "plan", "planned", "random_poses", "simulate", "verify",
)  # fmt: skip


@pytest.mark.parametrize("name", FIRST)
def test_the_example_runs(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    example = doctest.DocTestParser().get_doctest(
        getattr(workbench, name).__doc__, {}, name, getattr(workbench, name).__module__, 0
    )
    assert len(example.examples) >= 3
    runner = doctest.DocTestRunner(verbose=False)
    runner.run(example)
    assert runner.summarize(verbose=False).failed == 0, capsys.readouterr().out


def test_whatever_a_user_calls_says_what_it_takes():
    """A public function of several arguments says more than one line, or names them in it."""
    bare = []
    for name in workbench.__all__:
        said, code = (
            getattr(workbench, name).__doc__ or "",
            getattr(getattr(workbench, name), "__code__", None),
        )
        takes = code.co_varnames[: code.co_argcount] if code else ()
        if len(takes) > 1 and "\n" not in said.strip() and not any(argument in said for argument in takes):
            bare.append(name)
    assert bare == []

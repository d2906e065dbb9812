"""Options of the commands: each is read, stands where it acts, and says what it does."""

import argparse
import ast
import inspect
import textwrap
from pathlib import Path

import pytest

from workbench.cli.arguments import named_frame, only_frame
from workbench.cli.main import command_line, main
from workbench.files.faults import InputError
from workbench.studies import PUBLISHED

ROOT = Path(__file__).resolve().parents[1]


def leaves(parser, name=""):
    """Name → parser of every command that runs; what is below a command stands for it."""
    below = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    if not below:
        return {name: parser}
    found = {}
    for word, one in below[0].choices.items():
        found |= leaves(one, f"{name} {word}".strip())
    return found


COMMANDS = leaves(command_line())
STUDIES = {f"study {name}" for name in (*PUBLISHED, "all")}
BLIND = {"study blind", "study case"}


def options(name):
    """Name → action of what acts in a command."""
    idle = ("help", argparse.SUPPRESS)
    return {action.dest: action for action in COMMANDS[name]._actions if action.dest not in idle}


def read_by(function):
    """The attributes of `arguments` that a function reads, itself or where it hands all of them on."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    read = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "arguments":
            read.add(node.attr)
        if isinstance(node, ast.Call) and any(getattr(arg, "id", "") == "arguments" for arg in node.args):
            read |= read_by(function.__globals__[node.func.id])
    return read


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_of_a_command_is_read_by_it(name):
    read = read_by(COMMANDS[name].get_default("run"))
    assert read - {"name"} == set(options(name))
    assert all(action.help for action in options(name).values())


def test_options_stand_where_they_act():
    having = {}
    for name in COMMANDS:
        for option in options(name):
            having.setdefault(option, set()).add(name)
    assert having["json"] == set(COMMANDS)
    assert having["out"] == set(COMMANDS) - {"robots", "causes"}
    assert having["seed"] == having["out"] - {"init", "check", "export", "compare", "study archive"}
    assert having["quick"] == {"demo", "plan", "verify", "study blind"} | STUDIES
    assert having["workers"] == {"verify", "study followup"} | BLIND | STUDIES
    assert having["resume"] == {"study blind", "study followup"} | STUDIES
    assert having["draws"] == {"study blind", "study followup"}


@pytest.mark.parametrize("name", sorted(set(COMMANDS) - {"robots", "causes"}))
def test_out_says_what_it_is_and_where_by_default(name):
    out = options(name)["out"]
    assert out.help.startswith(("folder ", "file ", "the program's file"))
    assert out.default is None or f"({out.default})" in out.help


@pytest.mark.parametrize(
    "call",
    [
        ["study", "kr500", "--draws", "3"],
        ["study", "blind", "--quick", "--draws", "3"],
        ["verify", "path.csv", "--model", "model.toml", "--workers", "0"],
        ["robots", "--workers", "0"],
        ["robots", "--out", "here"],
    ],
)
def test_an_option_that_is_not_known_or_wrong_is_refused(call, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(call)
    assert "error: " in capsys.readouterr().err


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_takes_the_common_options(name):
    taken = set(COMMANDS[name]._option_string_actions)
    assert taken >= {"--seed", "--workers", "--resume", "--quick", "--json"}


def test_a_common_option_that_does_nothing_is_said_to(capsys):
    usual = main(["robots", "--json"]), capsys.readouterr().out
    status = main(["robots", "--seed", "1", "--workers", "2", "--quick", "--resume", "--json"])
    out, err = capsys.readouterr()
    assert (status, out) == usual
    assert err.splitlines() == [
        f"warning: {option} does nothing in `workbench robots`"
        for option in ("--seed", "--workers", "--quick", "--resume")
    ]


@pytest.mark.parametrize("call", [["plan", "kr500"], ["simulate", "kr500", "--random", "3"]])
def test_a_seed_below_zero_is_refused(call, capsys):
    with pytest.raises(SystemExit, match="2"):
        main([*call, "--seed", "-1"])
    assert "'-1' is no number from 0" in capsys.readouterr().err


def test_a_frame_may_begin_with_a_minus(capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["compensate", "p.csv", "--model", "m.toml", "--tool", "-12,0,150,0,0,left"])
    assert "'-12,0,150,0,0,left' is no x,y,z or x,y,z,a,b,c" in capsys.readouterr().err
    said = command_line().parse_args(["compensate", "p.csv", "--model", "m.toml", "--tool", "-12,0,150"])
    ((name, tool),) = said.tool
    assert name == ""
    assert tool[:3, 3].tolist() == [-0.012, 0.0, 0.15]
    said = command_line().parse_args(
        ["compensate", "p.src", "--model", "m.toml", "--base", "BASE_DATA[1]=-12,0,150"]
    )
    assert said.base[0][0] == "BASE_DATA[1]"


@pytest.mark.parametrize("place", ["", " "])
def test_an_empty_place_is_not_the_current_folder(place, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["diagnose", "campaign.toml", "--out", place])
    assert "--out: is empty" in capsys.readouterr().err


@pytest.mark.parametrize("given", [["A=0,0,1"], ["0,0,1", "0,0,2"]])
def test_frames_with_names_are_for_programs(given):
    pairs = [named_frame(text) for text in given]
    with pytest.raises(InputError, match="--tool"):
        only_frame("tool", pairs)


@pytest.mark.parametrize("tolerance", ["-1", "nan", "wide"])
def test_a_tolerance_below_zero_is_refused(tolerance, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["compensate", "p.csv", "--model", "m.toml", "--tolerance", tolerance])
    assert f"'{tolerance}' is no length of zero or more" in capsys.readouterr().err


def test_only_the_command_line_reads_arguments():
    reading = [path for path in (ROOT / "workbench").rglob("*.py") if "argparse" in path.read_text()]
    assert {path.parent.name for path in reading} == {"cli"}


@pytest.mark.parametrize("name", [name for name in COMMANDS if name])
def test_every_command_has_its_help(name, capsys):
    with pytest.raises(SystemExit) as end:
        command_line().parse_args([*name.split(), "--help"])
    assert end.value.code == 0
    assert capsys.readouterr().out.startswith(f"usage: workbench {name}")

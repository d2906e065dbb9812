"""The README says what is so: its Python runs, its commands exist, its table is the catalogue's."""

import argparse
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench import Conditions, load_robot
from workbench.campaign.file import CampaignFile
from workbench.cli.main import command_line, main
from workbench.effects import catalogue
from workbench.report.causes import causes_page, causes_table
from workbench.robot.equilibrium import equilibrium
from workbench.robot.yielding import own_yielding
from workbench.simulation.export.content import content_of

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
STALE = "run `python -m workbench.report.causes`"


def block(language):
    (text,) = re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)
    return text


def test_python_runs(tmp_path, monkeypatch, capsys):
    code = block("python")
    assert len([line for line in code.splitlines() if line.strip()]) == 10
    effect = "backlash:joint=joint_2,half_width=1e-4"
    arguments = ["--random", "40", "--approach", "--effect", effect, "--out", str(tmp_path / "campaign")]
    assert main(["simulate", "kr500", *arguments]) == 0
    rows = [f"{0.1 * i:.1f},{0.2 * i - 5},-70,90,5,45,0" for i in range(20)]
    header = "t_s," + ",".join(f"q{j}_deg" for j in range(1, 7))
    (tmp_path / "path.csv").write_text("\n".join([header, *rows, ""]))
    monkeypatch.chdir(tmp_path)
    capsys.readouterr()
    exec(compile(code, "README.md", "exec"), {})
    said = capsys.readouterr().out.splitlines()
    assert "backlash" in said[0]
    assert said[1].startswith("backlash(joint_2) named ")
    before, after = (float(part.split()[0]) for part in said[-1].split(", "))
    assert after < 0.001 < before
    assert (tmp_path / "found/index.html").is_file()


def test_a_drake_user_adds_the_exported_robot(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path / "kr500_drake"))
    assert main(["export", "kr500", "--to", "drake", "--out", "kr500_drake"]) == 0
    names: dict = {}
    exec(compile(block("py"), "README.md", "exec"), names)
    assert sum(bool(line.strip()) for line in block("py").splitlines()) <= 12
    names["simulator"].AdvanceTo(0.002)
    own = names["robot"].GetMyContextFromRoot(names["simulator"].get_context())
    tool = names["robot"].GetOutputPort("tool_pose").Eval(own).translation()
    robot = load_robot("kr500")
    content = content_of(robot, None, Conditions())
    arm, loads = content.loaded
    one = replace(loads, mass=loads.mass[:1], moment=loads.moment[:1], wrench=loads.wrench[:1])
    one = replace(one, torque=loads.torque[:1])
    still = np.zeros((1, arm.slots, 6))
    rest = equilibrium(arm, np.array([names["q"]]), still, one, own_yielding(arm).motion)[1].p[-1, 0]
    assert np.abs(tool - rest).max() < 1e-8


def test_the_table_is_the_catalogue():
    assert causes_table() in README, STALE
    assert (ROOT / "docs/causes.md").read_text(encoding="utf-8") == causes_page(), STALE
    assert re.findall(r"^\| `(\w+)` \|", README, flags=re.MULTILINE) == list(catalogue())


def test_every_command_of_the_table_exists():
    commands = re.findall(r"`workbench (\w+)([^`]*)`", README)
    known = subcommands(command_line())
    assert {name for name, _ in commands if name.islower()} == set(known)
    for name, rest in commands:
        if name in known:
            parsers = [known[name]]
            if studies := subcommands(known[name]):
                said = re.split(r"[ \\|]+", rest.strip())
                parsers = [studies[word] for word in said if word in studies]
                assert parsers, rest
            for parser in parsers:
                options = {option for action in parser._actions for option in action.option_strings}
                assert set(re.findall(r"--[\w-]+", rest)) <= options, (name, rest)


def subcommands(parser):
    return next((a.choices for a in parser._actions if isinstance(a, argparse._SubParsersAction)), {})


def test_the_example_campaign_is_one():
    file = CampaignFile.model_validate(tomllib.loads(block("toml")))
    assert file.noise.sigma_mm == 0.03


@pytest.mark.parametrize("path", sorted({*re.findall(r"\]\(([^)#:]+)\)", README), "models/kr500"}))
def test_links_lead_somewhere(path):
    assert (ROOT / path).exists()


def test_the_picture_is_small():
    assert (ROOT / "docs/demo.png").stat().st_size < 250_000

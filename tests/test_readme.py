"""The README says what is so: its Python runs, its commands exist, its table is the catalogue's."""

import argparse
import re
import tomllib
from pathlib import Path

import pytest

from workbench.campaign.file import CampaignFile
from workbench.cli.main import command_line, main
from workbench.effects import catalogue
from workbench.report.causes import causes_page, causes_table

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

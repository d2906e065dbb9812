"""docs/files says what is so: the pages are the models', and their schemas check what the program reads."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import pytest

from workbench.campaign.file import CampaignFile
from workbench.report.file_formats import FOLDER, pages
from workbench.robot.find import list_robots
from workbench.robot.schema import RobotFile

ROOT = Path(__file__).resolve().parents[1]
STALE = "run `python -m workbench.report.file_formats`"


def test_the_pages_are_up_to_date():
    made = pages()
    assert {path.name for path in FOLDER.iterdir()} == set(made), STALE
    for name, text in made.items():
        assert (FOLDER / name).read_text(encoding="utf-8") == text, STALE


@pytest.mark.parametrize("name", ["robot.md", "campaign.md", "poses.md", "points.md", "path.md"])
def test_every_key_has_a_meaning(name):
    rows = re.findall(r"^\| `(.*?)`.*\|(.*)\|$", pages()[name], flags=re.MULTILINE)
    assert rows
    assert [key for key, meaning in rows if not meaning.strip()] == []


@pytest.mark.parametrize("model", [RobotFile, CampaignFile])
def test_every_key_is_on_its_page(model):
    name = "robot.md" if model is RobotFile else "campaign.md"
    keys, page = [field.alias or key for key, field in model.model_fields.items()], pages()[name]
    assert all(f"| `{key}` |" in page for key in keys)


def test_the_schemas_know_the_keys_of_the_files_that_come_along():
    made = pages()
    schema = json.loads(made["robot.schema.json"])
    for path in list_robots():
        assert set(tomllib.loads(path.read_text(encoding="utf-8"))) <= set(schema["properties"])
    schema = json.loads(made["campaign.schema.json"])
    measured = tomllib.loads((ROOT / "tests/data/ur5/campaign.toml").read_text(encoding="utf-8"))
    assert set(measured) <= set(schema["properties"])
    assert schema["additionalProperties"] is False


@pytest.mark.parametrize("page", sorted((ROOT / "docs").rglob("*.md")), ids=lambda path: path.name)
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
        assert (page.parent / link).exists(), link

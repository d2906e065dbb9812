"""docs/architecture.md says what is so: its files are there, and its foreign layout is read as it says."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest

from workbench import load_campaign

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
MEASURED = ROOT / "tests/data/ur5"


def named():
    """Paths in backticks or links, as the page has them: from the root, the package, or a room of it."""
    words = {
        *re.findall(r"`([\w./-]+\.(?:py|toml|md)|[\w./-]+/)`", PAGE),
        *re.findall(r"\]\(([^)#:]+)\)", PAGE),
    }
    users = {
        "mine/",
        "reports/mine/",
        "path/to/robot.toml",
        "model.toml",
        "study.py",
        "printed.py",
        "story.md",
    }
    return sorted(words - users)


@pytest.mark.parametrize("path", named())
def test_every_file_is_there(path):
    assert any(folder.match(f"**/{path.rstrip('/')}") for folder in every_path()), path


def every_path():
    for place in ("workbench", "docs", "models", "tests"):
        yield from (ROOT / place).rglob("*")


def test_a_foreign_layout_is_read_as_the_page_says(tmp_path):
    (layout,) = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)
    with (MEASURED / "poses.csv").open() as poses, (MEASURED / "points.csv").open() as points:
        joints, seen = list(csv.reader(poses))[1:], list(csv.reader(points))[1:]
    rows = [["Name", *(f"A{i}" for i in range(1, 7))], *joints]
    (tmp_path / "joints.txt").write_text("\n".join("\t".join(row) for row in rows))
    lines = ["// frame A::World", "// metres"]
    for pose, target, *xyz in seen:
        metres = [f"{float(value) / 1000:.9f}".replace(".", ",") for value in xyz]
        lines.append(";".join(["World", "Main", pose, target, *metres, "11/22/2025 10:00:00"]))
    (tmp_path / "export.txt").write_text("\n".join(lines))
    (tmp_path / "campaign.toml").write_text(f'schema = 1\nrobot = "ur5"\n{layout}[targets.T1]\n')
    campaign, plain = load_campaign(tmp_path / "campaign.toml"), load_campaign(MEASURED / "campaign.toml")
    np.testing.assert_allclose(campaign.points, plain.points, atol=1e-9)
    np.testing.assert_array_equal(campaign.poses.q, plain.poses.q)
    assert campaign.warnings == ()

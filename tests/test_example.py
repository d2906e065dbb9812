"""The finished example in reports/: complete, small, and no link of its page leads nowhere."""

from __future__ import annotations

import json
import re
from pathlib import Path

from workbench import load_robot

FOLDER = Path(__file__).resolve().parents[1] / "reports/example"


def test_the_example_is_whole_and_small():
    names = {path.name for path in FOLDER.iterdir()}
    assert names == {
        "index.html",
        "report.pdf",
        "scene.html",
        "result.json",
        "residuals.csv",
        "model.toml",
        "urdf",
    }
    assert sum(path.stat().st_size for path in FOLDER.rglob("*")) < 4_000_000
    assert load_robot(FOLDER / "model.toml").joint_names == load_robot("kr500").joint_names
    result = json.loads((FOLDER / "result.json").read_text(encoding="utf-8"))
    assert (result["schema"], result["robot"]) == (1, "kr500")
    assert result["headline"].split(".")[0] in (FOLDER / "index.html").read_text(encoding="utf-8")


def test_its_links_lead_somewhere():
    page = (FOLDER / "index.html").read_text(encoding="utf-8")
    for link in re.findall(r'(?:href|src)="([^"#:]+)"', page):
        assert (FOLDER / link).is_file(), link

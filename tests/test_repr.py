"""What objects say of themselves at a prompt and in a notebook."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from campaign_example import write_example
from diagnosis_example import diagnosis

from workbench import Path, Problem, load_campaign, load_robot, problem_of


def test_a_robot_names_its_joints():
    said = repr(load_robot("cylindrical"))
    assert said.startswith("Robot cylindrical: ")
    assert "joint_2 (prismatic)" in said


def test_a_campaign_counts(tmp_path):
    campaign = load_campaign(write_example(tmp_path))
    assert repr(campaign) == "Campaign 'Tiny' of tiny: 3 poses, 4 points of T1, T2, payloads heavy"
    assert repr(problem_of(campaign)) == f"Problem: {campaign!r}"
    assert isinstance(problem_of(campaign), Problem)


def test_a_path_has_a_length():
    path = Path(np.linspace(0, 2, 5), q=np.zeros((5, 6)), title="spiral")
    assert repr(path) == "Path 'spiral': 5 samples of joints, 2 s"


@pytest.fixture(scope="module")
def found():
    return diagnosis(n_poses=20)


def test_a_diagnosis_is_a_paragraph(found):
    said = repr(found)
    assert found.headline in said
    assert len(said) < 1000
    for finding in found.causes:
        assert f"{finding.label} {finding.status}" in said


def test_a_diagnosis_is_a_table_in_a_notebook(found):
    html = replace(found, headline="a < b & c")._repr_html_()
    tree = ET.fromstring(f"<div>{html}</div>")  # well-formed
    assert tree.findtext("p/b") == "a < b & c"
    cells = [cell.text for cell in tree.iter("td")]
    assert {stage.name for stage in found.stages} <= set(cells)
    assert {finding.label for finding in found.causes} <= set(cells)
    assert not re.search(r"\bNone\b", html)

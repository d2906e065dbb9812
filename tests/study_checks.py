"""What the tests of every published study ask of its figures and poses."""

from __future__ import annotations

import re

from workbench.report.study import Study


def captions_stand_alone(found: Study, robot: str) -> None:
    """Robot, and how many draws or that there are none, under which seed."""
    for figure in found.figures:
        assert figure.note.startswith(robot), figure.name
        assert re.search(r"seed 0|[Nn]o draws|by the model", figure.note), figure.name


def poses_are_counted(found: Study, least: float) -> None:
    """How many the robot could stand in; least: share of all."""
    n = found.numbers
    assert 0 < n["clear_both"] <= min(n["clear_above"], n["clear_itself"]) <= n["clear_poses"]
    assert n["clear_both"] >= least * n["clear_poses"]

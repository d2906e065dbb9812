"""The catalogue in Markdown: the README's table and docs/causes.md. `python -m workbench.report.causes`
writes both anew; a test holds them to the catalogue."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..campaign.planned import planned
from ..campaign.problem import Problem, problem_of
from ..effects import catalogue, rivals, separation
from ..effects.base import Effect
from ..files.whole import put
from ..robot.description import load_robot

BEGIN, END = "<!-- causes: written by workbench.report.causes -->", "<!-- end of causes -->"
TABLE_HEAD = "| cause | what it is | sits at | not testable if | easily mistaken for |\n|---|---|---|---|---|"
ROOT = Path(__file__).resolve().parents[2]


def causes_table() -> str:
    """One row per cause: what it is, where it sits, what it needs, and what it looks like."""
    bare = _campaigns()
    rows = [
        f"| `{cause}` | {kind.title} | {_place(kind, bare[0])} | {_lacks(kind, bare)} | {_alike(kind)} |"
        for cause, kind in catalogue().items()
    ]
    return "\n".join([TABLE_HEAD, *rows])


def causes_page() -> str:
    """A section per cause: its equation and source, and the measurement that tells it from each rival."""
    bare = _campaigns()
    parts = ["# What a diagnosis can find", "Written from the catalogue (`workbench/effects`)."]
    for cause, kind in catalogue().items():
        place = _place(kind, bare[0])
        parts += [f"## {cause}", f"{kind.title}. Sits at: {place}.", f"```\n{inspect.getdoc(kind)}\n```"]
        if (why := _lacks(kind, bare)) != "–":
            parts.append(f"Not testable if {why}.")
        parts.append(f"In a simulated campaign: {kind.in_drake}.")
        told = [
            f"- from {'another place' if rival == cause else f'`{rival}`'}: {separation(cause, rival)}"
            for rival in rivals(cause)
        ]
        parts.append("\n".join(["Told apart", *told]))
    return "\n\n".join(parts) + "\n"


def parameters() -> dict[str, tuple[str, dict[str, str]]]:
    """Cause → where it sits, and its parameters with their units, as `--effect` takes them."""
    bare = _campaigns()[0]
    return {
        cause: (_place(kind, bare), _units(kind.places(_carrying(bare))))
        for cause, kind in catalogue().items()
    }


def _units(effects: Sequence[Effect]) -> dict[str, str]:
    """Names that any form of a cause understands, with the units in which they are reported."""
    out: dict[str, str] = {"order": "cycles per joint turn"} if effects[0].ordered else {}
    for one in effects:
        effect = replace(one, where=replace(one.where, order=1.0)) if one.ordered else one
        typical = np.array([param.typical for param in effect.params])
        said = effect.report(typical, np.diag(typical**2))
        units = {param.name: param.unit for param in effect.params}
        units |= {param.name: param.unit for param in said}
        for name in (*effect.names, *effect.settings):
            out.setdefault(name, units.get(name, ""))
    return out


def readme_with_table(text: str) -> str:
    """The README with the table in its place."""
    head, rest = text.split(BEGIN)
    return f"{head}{BEGIN}\n{causes_table()}\n{END}{rest.split(END)[1]}"


def _campaigns() -> tuple[Problem, ...]:
    """Nothing but poses, on robots that lack more and more."""
    robots = load_robot("kr500"), load_robot("cylindrical")
    full, slim = (problem_of(planned(robot, np.zeros((2, len(robot.joints))))) for robot in robots)
    arm = full.arm
    light = replace(arm, mass=0 * arm.mass, moment=0 * arm.moment)
    return full, slim, replace(full, arm=light, compensator=None)


def _place(kind: type[Effect], problem: Problem) -> str:
    """joint, link, payload, or the whole robot."""
    keys = kind.places(_carrying(problem))[0].where.keys()
    if "other" in keys:
        return "two joints"
    return next((key for key in keys if key != "order"), "robot")


def _carrying(problem: Problem) -> Problem:
    """The same with a payload."""
    carried = replace(
        problem.campaign.with_poses(payload=np.ones(2, dtype=np.int64)),
        payload_names=("", "any"),
        load_mass=np.array([0.0, 1.0]),
        load_com=np.zeros((2, 3)),
    )
    return replace(problem, campaign=carried)


def _lacks(kind: type[Effect], campaigns: tuple[Problem, ...]) -> str:
    """What is missing where it cannot be tested."""
    said = (kind.needs(campaign) for campaign in campaigns)
    why = next((why for why in said if why is not None), "–")
    return why.partition(":")[0].replace("..", " … ")


def _alike(kind: type[Effect]) -> str:
    return ", ".join(f"`{rival}`" for rival in rivals(kind.cause) if rival != kind.cause)


if __name__ == "__main__":
    readme = ROOT / "README.md"
    put(readme, readme_with_table(readme.read_text(encoding="utf-8")).encode())
    put(ROOT / "docs" / "causes.md", causes_page().encode())

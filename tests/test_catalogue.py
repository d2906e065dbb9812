"""What effects say of themselves is so, nothing else names them, and a new cause is one new file."""

from __future__ import annotations

import ast
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_effects import CASES, job, values_of

import workbench
from workbench import diagnose, effects, planned, random_poses, simulate
from workbench.campaign import Target
from workbench.campaign.problem import problem_of
from workbench.diagnosis.evidence import evidence
from workbench.effects import catalogue, rivals, separation
from workbench.identification.fit import fit, start_state
from workbench.identification.model import Model
from workbench.identification.noise import required_noise
from workbench.robot.description import load_robot
from workbench.robot.elastic_plant import elastic_twin
from workbench.simulation.virtual_campaign import Truth

PACKAGE = Path(workbench.__file__).parent
COLUMNS = ("side", "time", "temperature", "readback")
ids = [f"{name}-{effect.label}-{effect.variant}" for name, effect in CASES]
every = pytest.mark.parametrize(("name", "effect"), CASES, ids=ids)
on_one_robot = pytest.mark.parametrize(
    "effect", [e for name, e in CASES if name == "kr500"], ids=[i for i in ids if i.startswith("kr500-")]
)


@every
def test_an_effect_depends_on_what_it_says(name, effect):
    """Another column changes the points if, and only if, the effect says that it uses it."""
    case, state = job(name)
    state = replace(state, values=(values_of(effect),))
    points = Model(case, (effect,)).predict(state)
    changed = set()
    for word in COLUMNS:
        column = getattr(case.campaign.poses, word)
        other = -column if word == "side" else column + (1e-4 if word == "readback" else 5.0)
        there = Model(replace(case, campaign=case.campaign.with_poses(**{word: other})), (effect,))
        if not np.array_equal(points, there.predict(state)):
            changed.add(word)
    assert changed == effect.uses & set(COLUMNS)
    assert effect.uses <= effect.depends


@every
def test_what_acts_along_a_joint_moves_nothing_else(name, effect):
    case, _ = job(name)
    if effect.acts == "transmission" and effect.axial:
        columns = set(effect.motion(case))
    elif effect.acts == "yielding":
        columns = {6 * effect.slot(case.arm) + c for c in effect.components(case.arm)}
    else:
        return
    own = {int(case.arm.axial[case.joint(effect.where.joint)])} if effect.where.joint else set()
    assert effect.axial == (columns == own)


@every
def test_drake_has_what_the_effect_says(name, effect):
    """Joints for what moves and gives way; bodies whose mass is in the Context; for the rest, forces."""
    case, _ = job(name)
    if "joint" in effect.in_drake.split(" for each component")[0] and effect.acts != "load":
        moving = {"transmission", "geometry"}
        columns = (
            list(effect.motion(case))
            if effect.acts in moving
            else [6 * effect.slot(case.arm) + c for c in effect.components(case.arm)]
        )
        pairs = [divmod(int(column), 6) for column in columns]
        twin = elastic_twin(case.arm, case.robot, pairs)
        for pair in pairs:
            assert twin.plant.GetJointByName(twin.yielding[pair]).num_velocities() == 1
    else:
        assert effect.acts in ("load", "instrument")


@on_one_robot
def test_evidence_shows_the_hidden_curve(effect):
    """Simulated in Drake, fitted, drawn: the curve is the hidden one, and the points lie on it."""
    rng = np.random.default_rng(5)
    robot = load_robot("kr500")
    n_poses, n = 60, len(robot.joints)
    targets = (Target("T1", (0.15, 0.02, 0.05), fixed=True), Target("T2", (-0.1, 0.1, 0.1), fixed=True))
    q = random_poses(robot, n_poses, rng)
    plan = planned(
        robot, q, targets=targets, payloads={"heavy": (120.0, (0.05, 0.02, 0.2))},
        payload=["", "heavy"] * (n_poses // 2), tool=(20.0, (0.0, 0.0, 0.1)),
        direction=rng.choice([-1.0, 1.0], (n_poses, n)), time=np.linspace(0, 7200, n_poses),
        temperature=rng.uniform(20, 30, n_poses), readback=q + 1e-4 * rng.normal(size=q.shape),
    )  # fmt: skip
    whole = problem_of(plan)
    large = 5.0 if effect.cause != "readback_joints" else 1.0
    values = large * values_of(effect)
    truth = Truth(effects=((effect, values),), sigma=2e-6, repeatability=np.zeros(n))
    whole = problem_of(simulate(plan, truth, seed=1))
    found = fit(Model(whole, (effect,)), start_state(whole), required_noise(whole))
    seen = evidence(found, effect, found.state.values[0])
    shown = effect.drawn(whole, found.line.prediction, values)
    x, y = shown.line
    top = np.abs(y).max()
    assert top > 0
    fitted, covariance = found.effect_values(0)
    doubt = np.sqrt(np.trace(covariance)) / np.linalg.norm(fitted)
    np.testing.assert_allclose(np.interp(x, seen.curve_x, seen.curve_y), y, atol=(0.02 + 4 * doubt) * top)
    off = np.sqrt(np.median((seen.before - seen.after - np.interp(seen.x, x, y)) ** 2))
    if shown.curve is not None:
        assert off < (0.04 + 4 * doubt) * top
    assert np.sqrt(np.median(seen.after**2)) < 0.1 * np.sqrt(np.median(seen.before**2))


def test_what_tells_two_causes_apart_is_said_once_for_both():
    for cause in catalogue():
        for rival in rivals(cause):
            if rival in catalogue():
                assert cause in rivals(rival)
                assert separation(cause, rival)
                assert separation(rival, cause)


def test_no_cause_is_named_outside_effects():
    """Neither as text nor by its class, but where one effect is measured on purpose."""
    purpose = ("measurement", "identification/gravity_compensator", "identification/cells", "studies")
    causes = set(catalogue()) - {"payload", "gear_ratio"}  # words of the files as well
    named = []
    for path in PACKAGE.rglob("*.py"):
        room = path.relative_to(PACKAGE).as_posix()
        if room.startswith(("effects/", "studies/")):
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            by_text = isinstance(node, ast.Constant) and node.value in causes
            module = node.module or "" if isinstance(node, ast.ImportFrom) else ""
            by_class = "effects." in module and module.split(".")[-1] in catalogue()
            if by_text or (by_class and not room.startswith(purpose)):
                named.append(f"{room}:{node.lineno}")
    assert not named


def test_no_effect_is_asked_for_its_kind_outside_effects():
    asked = []
    for path in PACKAGE.rglob("*.py"):
        room = path.relative_to(PACKAGE).as_posix()
        text = path.read_text(encoding="utf-8")
        if not room.startswith("effects/") and ("isinstance(effect" in text or "issubclass(kind" in text):
            asked.append(room)
    assert not asked


NEW = '''
"""A slack dress pack: the joint lags by more, the further it is turned, on the side that it comes from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from workbench.campaign.problem import Problem
from workbench.effects.base import Depends, Param
from workbench.effects.kinds import TransmissionEffect
from workbench.effects.place import Where
from workbench.robot.kinematics import Array


@dataclass(frozen=True)
class DressPack(TransmissionEffect):
    """Δq = −s · dir · q of joint 1."""

    cause: ClassVar[str] = "dress_pack"
    title: ClassVar[str] = "Dress pack drags"
    depends: ClassVar[Depends] = frozenset({"joints", "side"})
    separate: ClassVar[dict[str, str]] = {"backlash": "reverse near the joint's zero"}

    @property
    def params(self) -> tuple[Param, ...]:
        return (Param("slack", "1", 1e-4),)

    @classmethod
    def needs(cls, problem: Problem) -> str | None:
        return None if problem.campaign.poses.side is not None else "no column dir1"

    @classmethod
    def sites(cls, problem: Problem) -> Sequence[DressPack]:
        return [cls(Where(joint=problem.arm.names[0]))]

    def basis(self, q: Array, direction: Array | None, joints: tuple[str, ...]) -> Array:
        return 0.0 * q[:, :1] if direction is None else -direction[:, :1] * q[:, :1]
'''


def test_a_new_cause_is_one_new_file(tmp_path, monkeypatch):
    """Written, it is simulated, found and drawn; its curve is not zero; its rival knows it."""
    (tmp_path / "dress_pack.py").write_text(NEW)
    monkeypatch.setattr(effects, "__path__", [*effects.__path__, str(tmp_path)])
    catalogue.cache_clear()
    try:
        rng = np.random.default_rng(3)
        robot = load_robot("kr500")
        targets = [
            Target("T1", (0.15, 0.02, 0.05)),
            Target("T2", (-0.1, 0.1, 0.1)),
            Target("T3", (0.0, -0.1, 0.15)),
        ]
        plan = planned(
            robot, random_poses(robot, 80, rng), targets=targets,
            direction=rng.choice([-1.0, 1.0], (80, len(robot.joints))),
        )  # fmt: skip
        (effect,) = catalogue()["dress_pack"].sites(problem_of(plan))
        truth = Truth(effects=((effect, np.array([3e-4])),), sigma=2e-5)
        diagnosis = diagnose(simulate(plan, truth, seed=4)).diagnosis
        (finding,) = diagnosis.causes
        assert (finding.cause, finding.status, diagnosis.verdict) == ("dress_pack", "named", "named")
        assert finding.parameters[0].value == pytest.approx(3e-4, rel=0.05)
        assert np.abs(finding.evidence.curve_y).max() > 1e-4
        assert "dress_pack" in rivals("backlash")
    finally:
        catalogue.cache_clear()
        sys.modules.pop("workbench.effects.dress_pack", None)

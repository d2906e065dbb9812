"""What effects say of themselves is so, nothing else names them, and a new cause is one new file."""

from __future__ import annotations

import ast
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.tree import ForceElementIndex, LinearSpringDamper, PrismaticSpring, RevoluteSpring
from test_effects import CASES, job, values_of

import workbench
from workbench import diagnose, effects, planned, random_poses, simulate
from workbench.campaign import Target
from workbench.campaign.problem import problem_of
from workbench.diagnosis.telling.evidence import evidence
from workbench.diagnosis.weighing.components import at_once
from workbench.effects import called, catalogue, rivals, separation, separation_beside
from workbench.effects.gravity_compensator import GravityCompensator
from workbench.effects.kinds import (
    DirectEffect,
    InstrumentEffect,
    LinearYield,
    LoadEffect,
    TransmissionEffect,
    YieldEffect,
)
from workbench.effects.masses import MassEffect
from workbench.effects.place import Where
from workbench.effects.records import parse_effect
from workbench.identification.fit import fit, start_state
from workbench.identification.model import Model
from workbench.identification.noise import required_noise
from workbench.measurement.design import settle
from workbench.report.numbers import words
from workbench.robot.compensator import compensator_law
from workbench.robot.description import load_robot
from workbench.robot.elastic_plant import elastic_twin
from workbench.robot.rigid_plant import arrays
from workbench.simulation.virtual_campaign import Truth, pose_loads, true_robot

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
        columns = {6 * one.slot(case.arm) + c for one in effect.parts for c in one.components(case.arm)}
    else:
        return
    own = {int(case.arm.axial[case.joint(effect.where.joint)])} if effect.where.joint else set()
    assert effect.axial == (columns == own)


@every
def test_drake_has_what_the_effect_says(name, effect):
    """Each sentence `in_drake`: the objects that it names are in the plant that is simulated."""
    case, _ = job(name)
    truth = Truth(effects=((effect, values_of(effect)),))
    direct = truth.acting.direct(case)
    twin, loads = true_robot(case, truth, direct)
    twin.set_loads(pose_loads(loads, 0))
    CLAIMS[effect.in_drake](case, effect, twin, direct)


def moves(case, effect, twin, direct):
    columns = [int(c) for c, basis in effect.motion(case).items() if (basis @ values_of(effect)).any()]
    assert columns
    first = int(np.argmax(np.abs(direct).max(axis=(1, 2))))
    twin.set_motion(case.q[first], direct[first], direct[first])
    for column in columns:
        joint = twin.plant.GetJointByName(twin.joints[divmod(column, 6)])
        at = twin.plant.GetPositions(twin.context)[joint.position_start()]
        own = case.arm.axial.tolist()
        if column in own:
            motor = twin.plant.GetJointByName(twin.motors[own.index(column)])
            at += twin.plant.GetPositions(twin.context)[motor.position_start()]
            at -= case.q[first][own.index(column)]
        assert at == pytest.approx(direct[first].reshape(-1)[column], abs=1e-15)


def drives(case, effect, twin, direct):
    (column,) = effect.motion(case)
    j = case.arm.axial.tolist().index(column)
    motor = twin.plant.GetJointByName(twin.motors[j]).position_start()
    for i in (0, 1):
        twin.set_motion(case.q[i], direct[i], direct[i])
        command = twin.plant.GetPositions(twin.context)[motor]
        assert command == pytest.approx(case.q[i, j] + direct[i].reshape(-1)[column], abs=1e-15)


def springs(case, effect, twin, direct):
    for part in effect.parts:
        has_springs(case, part, twin)


def has_springs(case, part, twin):
    slot = part.slot(case.arm)
    plant, C = twin.plant, twin.yielding.linear[slot]
    found = [plant.get_force_element(ForceElementIndex(i)) for i in range(plant.num_force_elements())]
    native = {e.joint().name(): e for e in found if isinstance(e, RevoluteSpring | PrismaticSpring)}
    for c in part.components(case.arm):
        joint = twin.joints[slot, c]
        if isinstance(part, LinearYield) and not (C - np.diag(np.diag(C))).any():
            spring = native[joint]
            rate = spring.stiffness() if isinstance(spring, PrismaticSpring) else spring.default_stiffness()
            assert rate == pytest.approx(1 / C[c, c], rel=1e-12)
        else:
            assert joint not in native
            (law,) = (law for law in twin.laws.springs if law.slot == slot)
            wrench = 10.0 * np.eye(6)[c]
            moved = twin.yielding.motion(np.tile(wrench, (1, case.arm.slots, 1)))[0, slot]
            back = np.zeros((1, case.arm.slots, 6))
            back[0, slot, law.components] = law.wrench(moved[law.components])
            there = twin.yielding.motion(back)[0, slot]
            assert there == pytest.approx(moved, abs=1e-9 * np.abs(moved).max())


def torques(case, effect, twin, direct):
    j = case.joint(effect.where.joint)
    force = twin.plant.get_applied_generalized_force_input_port().Eval(twin.context)
    (spring,) = (twin.joints[divmod(int(case.arm.axial[j]), 6)],)
    at = [twin.plant.GetJointByName(name).velocity_start() for name in (twin.motors[j], spring)]
    assert force[at].all()
    assert force[at[0]] == force[at[1]]
    assert not np.delete(force, at).any()


def pulls(case, effect, twin, direct):
    law = twin.compensator
    s = 1.1 * (law.data.reference or law.data.free_length)
    plant = twin.plant
    found = [plant.get_force_element(ForceElementIndex(i)) for i in range(plant.num_force_elements())]
    coils = [e for e in found if isinstance(e, LinearSpringDamper)]
    if law.data.kind == "spring":
        (coil,) = coils
        pull = coil.stiffness() * (s - coil.free_length())
        assert pull == pytest.approx(float(law.force(np.array([s]))[0][0]), rel=1e-12)
        return
    assert not coils
    there = plant.get_applied_spatial_force_input_port().Eval(twin.context)
    pair = [one.F_Bq_W.translational() for one in there[1:]]
    assert np.linalg.norm(pair[0]) > 100
    np.testing.assert_allclose(pair[0], -pair[1])
    others = twin.cylinder.GetMyContextFromRoot(twin.root).get_numeric_parameter(0).get_value()
    assert tuple(others) != (1.0, 0.0) or twin.cylinder.law.data != case.compensator.data


def weighs(case, effect, twin, direct):
    stated = elastic_twin(case.arm, case.robot, compensator=case.compensator)
    stated.set_loads(pose_loads(case.loads, 0))
    changed = [
        not np.allclose(
            a.CalcSpatialInertiaInBodyFrame(twin.context).CopyToFullMatrix6(),
            b.CalcSpatialInertiaInBodyFrame(stated.context).CopyToFullMatrix6(),
            rtol=1e-9, atol=1e-12,
        )
        for a, b in zip(twin.built.bodies, stated.built.bodies, strict=True)
    ]  # fmt: skip
    bodies = [case.arm.links.index(effect.where.link) if effect.where.link else len(changed) - 1]
    if effect.variant == "all":  # every link that has a mass
        bodies = (1 + np.flatnonzero(case.arm.mass[1:])).tolist()
    c = case.campaign
    carried = effect.where.payload in (None, c.tool_name, c.payload_names[c.poses.payload[0]])
    assert np.flatnonzero(changed).tolist() == (bodies if carried else [])


def nothing(case, effect, twin, direct):
    assert effect.acts == "instrument"
    assert not direct.any()


CLAIMS = {
    DirectEffect.in_drake: moves,
    TransmissionEffect.in_drake: drives,
    YieldEffect.in_drake: springs,
    LoadEffect.in_drake: torques,
    GravityCompensator.in_drake: pulls,
    MassEffect.in_drake: weighs,
    InstrumentEffect.in_drake: nothing,
}


@every
def test_a_result_is_read_back_as_the_effect_it_tells(name, effect):
    """With its form, beside what another form of the same cause shows."""
    case, _ = job(name)
    values = values_of(effect)
    told = effect.report(values, np.diag((0.01 * values) ** 2 + 1e-12))
    fainter = [
        (p, 0.1)
        for form in type(effect).places(case)
        if form.key == effect.key and not form.ordered
        for p in form.report(np.full(len(form.params), 1e-3), 1e-4 * np.eye(len(form.params)))
        if p.name not in {one.name for one in told}
    ]
    numbers = [(p, p.std) for p in told] + fainter
    listed = [{"name": p.name, "value": p.value, "std": std} for p, std in numbers]
    cause = {"cause": effect.cause, **effect.where.keys(), "variant": effect.variant, "parameters": listed}
    found, size = settle._effect(cause, case)
    assert (found.key, found.variant) == (effect.key, effect.variant)
    assert found.report(size, np.eye(len(size)))[0].value == pytest.approx(told[0].value)
    alone = {**cause, "variant": ""}  # as results were that did not tell the form
    assert set(settle._effect(alone, case)[0].names) <= {p.name for p in told} | set(effect.names)


def test_the_numbers_that_are_said_choose_the_form():
    case, _ = job("kr500")
    for text, form in (
        ("preload=-500", "preload"),
        ("exponent=0.2", "exponent"),
        ("relative=0.1", "charge"),
        ("coefficient=3e-3", "temperature"),
    ):
        assert parse_effect(f"gravity_compensator:{text}", case)[0].variant == form


def test_a_gas_may_be_off_in_charge_and_exponent_without_the_rest():
    """In its exponent never alone: who described the gas wrongly knows no better how much there is. Charge
    and preload are off in more machines than these."""
    case, _ = job("kr500")
    forms = at_once(GravityCompensator.sites(case))
    assert [[e.variant for e in form] for form in forms] == [
        ["charge", "preload", "temperature"],
        ["charge", "preload", "exponent", "temperature"],
        ["charge", "exponent"],
    ]
    assert [e.variant for e in GravityCompensator.sites(case) if not e.whole] == ["exponent"]
    coil = problem_of(planned(load_robot("rx170"), np.zeros((1, 6))))
    assert [e.variant for e in GravityCompensator.sites(coil)] == ["charge", "preload"]


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
    found = fit(Model(whole, (effect.sized(large),)), start_state(whole), required_noise(whole))
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
    ways = {
        way for kind in catalogue().values() for said in kind.separate.values() for way in said.split(", or ")
    }
    assert ways >= {kind.reading for kind in catalogue().values() if kind.reading}


@pytest.mark.parametrize("cause", ["gear_ratio", "link_bending", "lost_motion"])
def test_a_link_may_be_weighed_wherever_its_mass_fits_as_well(cause):
    assert "weigh the link" in separation(cause, "link_mass")


def test_what_was_read_is_not_asked_for_again():
    gas, link = ("gravity_compensator", Where()), ("link_mass", Where(link="link_2"))
    assert separation("gravity_compensator", "link_mass") == "read the pressure gauge, or weigh the link"
    assert separation_beside(link, gas, [gas], None) == "weigh the link"
    assert separation_beside(gas, link, [link, gas], None) is None


def test_what_tells_apart_is_said_of_this_robot():
    """A coil spring has no gauge; a joint is swept where it can go; no payload tells a mass from a gear."""
    coil = problem_of(planned(load_robot("rx170"), np.zeros((1, 6))))
    spring, link = ("gravity_compensator", Where()), ("link_mass", Where(link="link_2"))
    said = separation_beside(spring, link, [], coil)
    assert said == "measure the rate and the free length of its spring, or weigh the link"
    assert separation_beside(spring, link, [spring], coil) == "weigh the link"
    at = Where(joint="joint_2")
    ratio, gear, map_of = (("gear_ratio", at), ("gear_eccentricity", at), ("joint_map", at))
    gas = problem_of(planned(load_robot("kr500"), np.zeros((1, 6))))
    whole = "sweep the joint over its whole range, \N{MINUS SIGN}130 … 20°"
    assert separation_beside(gear, ratio, [], gas) == whole
    for one in (gear, map_of):
        words = separation_beside(one, link, [], gas)
        assert words is not None
        assert "payload" not in words
        assert "motor torque" in words


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


def test_a_coil_is_the_same_spring_for_any_number_of_poses():
    robot = load_robot("rx170")
    law = compensator_law(robot, arrays(robot))
    springs = {replace(law, charge=np.full(count, 0.9)).coil for count in (1, 20, 30, 60)}
    assert springs == {replace(law, charge=0.9).coil}


def test_a_cause_is_called_what_the_field_calls_it() -> None:
    assert called("joint_map") == words("joint_map") == "error over the range"
    assert called("gear_ratio") == "gear ratio"
    assert called("half_width") == "half width"

"""For every cause, place and variant of the catalogue: exact Jacobian, the same in Drake, text and back."""

import atexit
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from workbench.campaign import Target
from workbench.campaign.planned import planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.effects import catalogue
from workbench.effects.joint_compliance import JointCompliance
from workbench.effects.lost_motion import LostMotion
from workbench.effects.place import Where
from workbench.effects.records import effect_text, from_record, parse_effect, record, stated_effects
from workbench.effects.unnamed.campaign import PerPayload
from workbench.effects.unnamed.instrument import Bearing, Head, Views
from workbench.effects.unnamed.joints import Product
from workbench.effects.unnamed.loads import Load
from workbench.files.faults import InputError
from workbench.identification.model import Model, State
from workbench.identification.parameters import columns
from workbench.identification.rows import jacobian, moved
from workbench.robot.description import load_robot
from workbench.simulation.random_robot import write_random_robot
from workbench.simulation.virtual_campaign import Truth, simulate

FOLDER = TemporaryDirectory()  # the parameters of the tests need the robots
atexit.register(FOLDER.cleanup)
N_POSES = 8
ROBOTS = ("kr500", "longlink", "6R", "PRRR")


@cache
def job(name):
    """A problem with every column that an effect may need, and its robot's geometry errors."""
    known = name in ("kr500", "longlink")
    robot = load_robot(name if known else write_random_robot(Path(FOLDER.name), 7, name))
    rng = np.random.default_rng(11)
    n = len(robot.joints)
    q = random_poses(robot, N_POSES, rng, floor=-9.0, clear=0.0)
    targets = (
        Target("T1", (0.15, 0.02, 0.05), fixed=True),
        Target("T2", (-0.1, 0.1, 0.1), fixed=True),
        Target("L", (0.1, 0.0, 0.2), on=robot.links[2]),
        Target("B", (0.5, 0.3, 0.1), on="base"),
    )
    plan = planned(
        robot,
        q,
        targets=targets,
        payloads={"heavy": (120.0, (0.05, 0.02, 0.2))},
        payload=["", "heavy"] * (N_POSES // 2),
        tool=(20.0, (0.0, 0.0, 0.1)),
        wrench=rng.normal(0, 100, (N_POSES, 6)),
        direction=rng.choice([-1.0, 1.0], (N_POSES, n)),
        time=np.linspace(0, 7200, N_POSES),
        temperature=rng.uniform(20, 30, N_POSES),
        readback=q + 1e-4 * rng.normal(size=q.shape),
    )
    case = problem_of(plan)
    geometry = 1e-3 * rng.normal(size=(case.arm.slots, 6))
    geometry[[0, -1]] = 0.0
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    R *= np.sign(np.linalg.det(R))
    return case, State(
        case.arm.geometry + geometry, R[None], rng.normal(size=(1, 3)), case.stated_targets[None]
    )


def values_of(effect):
    """Typical, each a little different, inside the bounds."""
    return np.array([p.typical * (1 + 0.3 * i) for i, p in enumerate(effect.params)])


def places(name):
    """One place per cause and variant (the second, where there is one)."""
    case, _ = job(name)
    chosen = {}
    for cause, kind in catalogue().items():
        for effect in kind.places(case):
            if cause == "gear_kinematic_error" and effect.where.order is None:
                effect = replace(effect, where=replace(effect.where, order=37.5))
            form = cause, effect.variant, getattr(effect, "sliding", False)
            chosen.setdefault(form, []).append(effect)
    return [same[min(1, len(same) - 1)] for same in chosen.values()]


CASES = [(name, effect) for name in ROBOTS for effect in places(name)]
every = pytest.mark.parametrize(
    ("name", "effect"), CASES, ids=[f"{name}-{effect.label}-{effect.variant}" for name, effect in CASES]
)


def test_every_cause_has_a_file():
    causes = {
        "joint_compliance", "gear_ratio", "gear_eccentricity", "gear_kinematic_error", "wrist_coupling",
        "backlash", "lost_motion", "gravity_compensator", "payload", "link_mass", "link_bending",
        "bearing_tilt", "foundation", "thermal_growth", "drift", "hose_torque", "tracker_scale",
        "readback_joints",
        "joint_map",
    }  # fmt: skip
    assert set(catalogue()) == causes
    tested = {effect.cause for _, effect in CASES}
    assert tested == causes


@every
def test_jacobian_equals_finite_differences(name, effect):
    case, state = job(name)
    values = values_of(effect)
    model = Model(case, (effect,))
    J = model.effect_jacobian(model.linearise(replace(state, values=(values,))), effect, values)
    for i, p in enumerate(effect.params):
        step = np.zeros(len(values))
        step[i] = 0.1 * p.typical
        there, back = (
            model.predict(replace(state, values=(values + sign * step,))).reshape(N_POSES, -1)
            for sign in (1, -1)
        )
        change = (there - back) / (2 * step[i])
        scale = np.abs(change).max()
        assert scale > 0 or (name, effect.cause, effect.variant) == ("PRRR", "link_mass", "com")
        assert np.abs(J[:, :, i] - change).max() < 1e-5 * scale + 1e-12 / step[i]


@pytest.mark.parametrize("name", ROBOTS)
def test_every_column_knows_what_acts_beside_it(name):
    """Frames, targets and geometry, where instrument, transmission, springs and loads are off as well."""
    case, state = job(name)
    each = {effect.acts: effect for effect in places(name)}
    seen = measured_as(case, state)
    by_place = (one for kind in (Bearing, Head, Views) for one in kind.sites(seen))
    effects = (*each.values(), *by_place, *Load.sites(seen)[-1:])
    values = tuple(0.3 * values_of(effect) for effect in effects)
    model, state = Model(seen, effects), replace(state, values=values)
    cols, line = columns(seen, effects, True), model.linearise(state)
    unit = np.broadcast_to(np.eye(line.direct.shape[1]), (N_POSES, *[line.direct.shape[1]] * 2))
    J = jacobian(model, line, cols, state, unit).columns
    assert {"instrument", "yielding", "load"} <= set(each)
    for i, column in enumerate(cols.names):
        step = np.zeros(len(cols.names))
        step[i] = 1e-5 if i < cols.background else 0.1 * effects_typical(effects)[i - cols.background]
        there, back = (
            model.predict(moved(seen, cols, state, line.centre, sign * step)).reshape(N_POSES, -1)
            for sign in (1, -1)
        )
        change = (there - back) / (2 * step[i])
        scale = max(np.abs(change).max(), np.abs(J[:, :, i]).max())
        assert np.abs(J[:, :, i] - change).max() < 1e-5 * scale + 1e-11 / step[i], column


def measured_as(case, state):
    """The problem with points, as its robot without any effect gives them."""
    return replace(case, campaign=replace(case.campaign, points=Model(case).predict(state)))


def effects_typical(effects):
    return [p.typical for effect in effects for p in effect.params]


@every
def test_batch_equals_drake(name, effect):
    case, state = job(name)
    values = values_of(effect)
    predicted = Model(case, (effect,)).predict(replace(state, values=(values,)))
    truth = Truth(
        geometry=state.geometry - case.arm.geometry,
        effects=((effect, values),),
        repeatability=np.zeros(case.arm.n),
    )
    measured = simulate(case.campaign, truth, instrument=(state.R, state.t))
    assert np.abs(measured.points - predicted).max() < 1e-9


@every
def test_text_and_back(name, effect):
    case, _ = job(name)
    values = values_of(effect)
    same, numbers = from_record(record(effect, values), case)
    assert same == effect
    assert np.allclose(numbers, values, rtol=1e-14)
    same, numbers = parse_effect(effect_text(effect, values), case)
    assert same == effect
    assert np.allclose(numbers, values, rtol=1e-14)
    # the names of the report say the same
    reported = {p.name: p.value for p in effect.report(values, np.eye(len(values))) if p.name in effect.names}
    said = effect.given(reported)
    if effect.free:  # a whole function is told by its size
        assert np.linalg.norm(said) == pytest.approx(np.linalg.norm(values))
    else:
        assert np.allclose(said, values, rtol=1e-12)
    assert all(p.unit for p in effect.params)
    assert effect.sentence(values)
    assert effect.equation
    assert set(effect.separate) <= {*catalogue(), "geometry"}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("rust", "no cause 'rust'; known: backlash,"),
        ("gear_ratio:joint=joint_9,relative=1e-4", "no joint 'joint_9'; known: joint_1,"),
        ("gear_ratio:joint=joint_1,relativ=1e-4", "no parameter 'relativ'; known: relative"),
        ("gear_ratio:joint=joint_1,relative=much", "'much', not a number"),
        ("gear_ratio:joint_1", "'joint_1' is no key=value"),
        (
            "gear_kinematic_error:joint=joint_4,amplitude=1e-4",
            "possible: joint=joint_1,order=(cycles per joint turn)",
        ),
        ("wrist_coupling:joint=joint_1,other=joint_2", "possible: joint=joint_4,other=joint_5"),
        ("payload:payload=light", "no payload 'light'; known: heavy"),
    ],
)
def test_wrong_text_is_refused_with_what_is_known(text, said):
    with pytest.raises(InputError) as caught:
        parse_effect(text, job("kr500")[0])
    assert said in str(caught.value)


def test_a_share_of_a_stiffness_that_the_model_lacks_is_refused_with_the_reason():
    case = problem_of(planned(load_robot("irb120"), np.zeros((1, 6))))
    with pytest.raises(InputError) as caught:
        parse_effect("joint_compliance:joint=joint_2,relative=0.2", case)
    assert "known: compliance (compliance of the joint, which the model has rigid)" in str(caught.value)


def test_text_takes_the_names_of_result_json():
    case, _ = job("kr500")
    text = "gear_kinematic_error:joint=joint_4,order=200,amplitude=2e-4,phase=0.3"
    effect, values = parse_effect(text, case)
    assert effect.where.order == 200
    assert effect.variant == "2"
    assert np.allclose(values, [2e-4 * np.cos(0.3), 2e-4 * np.sin(0.3)])
    effect, values = parse_effect("lost_motion:joint=joint_2,variant=soft,torque=800,amplitude=1e-4", case)
    assert (effect.torque, values[0]) == (800.0, 1e-4)
    effect, values = parse_effect("payload:payload=heavy,variant=com,com_x=0.01", case)
    assert np.allclose(values, [1.2, 0, 0])


def test_what_the_data_cannot_show_is_said():
    robot = load_robot("kr500")
    bare = problem_of(planned(robot, np.zeros((4, 6))))
    whys = {cause: kind.needs(bare) for cause, kind in catalogue().items()}
    assert whys["backlash"] == "no column dir1..dir6: record the side of approach"
    missing = {cause for cause, why in whys.items() if why}
    columns = {"backlash", "drift", "readback_joints", "thermal_growth", "tracker_scale"}
    assert missing == {*columns, "joint_map"}  # no joint moves in these poses
    for cause, why in whys.items():
        assert why or catalogue()[cause].sites(bare)


def test_a_robot_s_own_effects_act_in_its_campaigns():
    case, _ = job("kr500")
    robot = replace(case.robot, effects=(record(*parse_effect("foundation:compliance=1e-8", case)),))
    changed = replace(case.campaign, robot=robot)
    assert [effect.cause for effect, _ in stated_effects(problem_of(changed))] == ["foundation"]
    still = np.zeros(6)
    with_it = simulate(changed, Truth(repeatability=still)).points
    without = simulate(case.campaign, Truth(repeatability=still)).points
    assert 1e-5 < np.abs(with_it - without).max() < 1e-3


def test_a_small_size_is_not_said_to_be_nothing():
    """A soft zone of half a newton metre on a small joint is not below 0 N·m."""
    zone = LostMotion(Where(joint="joint_6"), "soft 0.05", 0.4321)
    assert zone.sentence(np.array([3.21e-7])).endswith(": 0.32 µrad to either side, below about 0.43 N·m.")
    zone = LostMotion(Where(joint="joint_6"), "soft 0.05", 1234.5)
    assert zone.sentence(np.array([1e-4])).endswith(": 100 µrad to either side, below about 1234 N·m.")


def test_a_stiffness_is_told_as_tables_have_it():
    """In percent of the model's and as a whole; of a joint that the model has rigid the whole alone."""
    stated = JointCompliance(Where(joint="joint_5"), nominal=1 / 219000)
    said = stated.sentence(np.array([1 / 0.75 - 1])).replace("\N{NO-BREAK SPACE}", " ")
    assert said == "joint_5 is softer than the model: 25.0 % less stiffness (164 000 N·m/rad)."
    said = stated.sentence(np.array([1 / 30 - 1])).replace("\N{NO-BREAK SPACE}", " ")
    assert said == "joint_5 is 30 times as stiff as in the model (6 570 000 N·m/rad)."
    for nothing in (-0.999, -1.006):  # noise may put it beyond
        said = stated.sentence(np.array([nothing])).replace("\N{NO-BREAK SPACE}", " ")
        assert said == "joint_5 is as good as rigid, where the model has it yield (219 000 N·m/rad)."
    rigid = JointCompliance(Where(joint="elbow"))
    said = rigid.sentence(np.array([1 / 30000])).replace("\N{NO-BREAK SPACE}", " ")
    assert said == "elbow yields 33.3 µrad per N·m (30 000 N·m/rad); the model has it rigid."
    slide = JointCompliance(Where(joint="z"), sliding=True)
    assert "(500 N/m)" in slide.sentence(np.array([2e-3]))
    assert "()" not in slide.sentence(np.array([0.0]))


def test_what_the_data_do_not_show_stays_within_what_physics_allows():
    """A prior at whose standard deviation the bounds were let a sixth of all numbers lie beyond each."""
    (problem, _), bounded = job("6R"), 0
    for kind in catalogue().values():
        for effect in kind.sites(problem):
            for param, std in zip(effect.params, effect.prior(problem), strict=True):
                if np.isfinite(param.upper - param.lower) and param.spread is None:
                    bounded += 1
                    assert 3 * std <= max(-param.lower, param.upper) * (1 + 1e-9), (effect.label, param.name)
    assert bounded > 10


def test_a_tool_that_sits_otherwise_by_payload_has_its_numbers_at_other_loads_too():
    """A plan goes on with poses of loads that the campaign knows and did not carry, or without any: its
    columns were as many as the loads of those."""
    arm = load_robot("ur5")
    q = random_poses(arm, 9, np.random.default_rng(0))
    loads = {name: (mass, (0.0, 0.0, 0.1)) for name, mass in (("half", 2.0), ("full", 4.0), ("spare", 1.0))}
    carried = problem_of(planned(arm, q, payloads=loads, payload=["half", "full", "full"] * 3))
    (effect,) = PerPayload.sites(carried)
    line = Model(carried).linearise(Model(carried).in_base())
    for payload in (["half", "full", "full"], ["", "half", "full"], ["spare", "", "spare"]):
        other = problem_of(planned(arm, q, payloads=loads, payload=payload * 3))
        columns = effect.jacobian(other, line, np.zeros(len(effect.params)))
        assert columns.shape == (9, line.direct.shape[1], len(effect.params))
        moving = np.abs(columns).max(axis=(1, 2)) > 0
        assert moving.tolist() == [bool(name) for name in payload] * 3


def test_a_product_of_two_joints_that_wind_up_over_more_than_a_turn():
    """Periodic functions leave much of it, those over the whole travel next to nothing; joints that turn no
    more than once have the former alone."""

    def left(name):
        robot = load_robot(name)
        problem = problem_of(planned(robot, random_poses(robot, 400, np.random.default_rng(1))))
        product = problem.q[:, 3] * problem.q[:, 4]
        forms = [one for one in Product.sites(problem) if one.where.joint == problem.arm.names[0]]
        pair = [one for one in forms if (one.where.other, one.third) == (problem.arm.names[3], 4.0)]
        for one in pair:
            basis = one.basis(problem.q, None, problem.arm.names)
            yield np.std(product - basis @ np.linalg.lstsq(basis, product)[0]) / np.std(product)

    around, whole = left("ur5")
    assert whole < 0.1 < 0.5 < around
    assert len(list(left("irb120"))) == 1

"""The instrument's frame and the targets are found without a first guess; wrong units are named."""

from dataclasses import replace

import numpy as np
import pytest
from held_hand import held
from scipy.spatial.transform import Rotation

from workbench.campaign import Target
from workbench.campaign.planned import TARGETS, planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.files.faults import InputError
from workbench.identification.plausible import believed
from workbench.identification.registration import middle_of, register
from workbench.robot.description import load_robot
from workbench.robot.rotations import from_vectors
from workbench.simulation.random_robot import write_random_robot
from workbench.simulation.virtual_campaign import Truth, random_geometry, simulate

PLACES = np.array([target.xyz for target in TARGETS])
HALF_TURNS = {
    "none": np.eye(3),
    "half turn about x": np.diag([1.0, -1.0, -1.0]),
    "half turn about y": np.diag([-1.0, 1.0, -1.0]),
    "half turn about z": np.diag([-1.0, -1.0, 1.0]),
    "half turn askew": 2 * np.full((3, 3), 1 / 3) - np.eye(3),
}


def measured(R=None, targets=TARGETS, poses=40, seed=0, robot="ur5", share=0.9, off=5e-4, **columns):
    """A campaign of a robot that is off by half a millimetre, seen from 4 m away in any direction."""
    robot = load_robot(robot)
    rng = np.random.default_rng(seed)
    plan = planned(robot, random_poses(robot, poses, rng, share), targets=targets, **columns)
    count = len(plan.setup_names)
    R = Rotation.random(count, random_state=np.random.RandomState(seed)).as_matrix() if R is None else R[None]
    t = rng.normal(size=(count, 3))
    t *= 4 / np.linalg.norm(t, axis=1, keepdims=True)
    truth = Truth(random_geometry(problem_of(plan).arm, rng, off, off), targets=places(targets), sigma=3e-5)
    return problem_of(simulate(plan, truth, seed=seed, instrument=(R, t))), R, t


def places(targets):
    """True places: of targets without a stated one, those of the usual three."""
    return np.array([target.xyz or PLACES[i] for i, target in enumerate(targets)])


def unknown(count):
    return tuple(Target(f"T{i + 1}") for i in range(count))


def assert_found(job, R, t, turn=5e-3, shift=8e-3):
    """The frame as close as a robot that is off lets one see it."""
    R_found, t_found, targets = register(job)
    for k in range(len(R)):
        assert Rotation.from_matrix(R_found[k] @ R[k].T).magnitude() < turn
    assert np.linalg.norm(t_found - t, axis=1).max() < shift
    return targets


@pytest.mark.parametrize("turn", HALF_TURNS)
@pytest.mark.parametrize("count", [1, 2, 3])
def test_any_frame_is_found(turn, count):
    assert_found(*measured(HALF_TURNS[turn], TARGETS[:count]))


@pytest.mark.parametrize("seed", range(8))
def test_frame_and_unknown_targets_are_found_together(seed):
    count = 1 + seed % 3
    targets = assert_found(*measured(None, unknown(count), seed=seed))
    assert np.abs(targets[0] - PLACES[:count]).max() < 8e-3


@pytest.mark.parametrize("turn", HALF_TURNS)
def test_unknown_targets_do_not_mistake_a_half_turn(turn):
    targets = assert_found(*measured(HALF_TURNS[turn], unknown(1)))
    assert np.abs(targets[0, 0] - PLACES[0]).max() < 8e-3


@pytest.mark.parametrize("seed", range(4))
def test_wild_points_do_no_harm(seed):
    job, R, t = measured(seed=seed)
    rng = np.random.default_rng(seed)
    points = job.campaign.points.copy()
    points[rng.permutation(40)[:8]] += rng.normal(0, 1.0, (8, 3, 3))
    points[rng.permutation(40)[:2]] *= 1000.0
    assert_found(replace(job, campaign=replace(job.campaign, points=points)), R, t)


def test_points_that_were_not_seen_do_no_harm():
    job, R, t = measured(seed=2)
    rng = np.random.default_rng(2)
    points = job.campaign.points.copy()
    hidden = rng.random((40, 3)) < 0.4
    hidden[np.arange(40), rng.integers(0, 3, 40)] = False
    points[hidden] = np.nan
    assert_found(replace(job, campaign=replace(job.campaign, points=points)), R, t)


def test_every_setup_has_a_frame_of_its_own():
    job, R, t = measured(seed=1, poses=60, setup=["a", "b", "c"] * 20)
    assert len(R) == 3
    assert_found(job, R, t)


def test_targets_on_base_and_links():
    targets = (
        *TARGETS[:1],
        Target("B", (0.5, 0.4, 0.1), on="base"),
        Target("L", (0.0, 0.1, 0.2), on="link_2"),
    )
    assert_found(*measured(targets=targets, seed=3))


@pytest.mark.parametrize("kind", ["7R", "PRRR"])
def test_other_robots(tmp_path, kind):
    robot = str(write_random_robot(tmp_path, 4, kind, elastic=False))
    assert_found(*measured(robot=robot, seed=4))


def test_a_hand_that_never_turns_keeps_its_stated_target():
    """One turning joint, one target: the frame and the target cannot both be told."""
    job, _, _ = measured(targets=TARGETS[:1], seed=5, poses=30)
    q = np.tile(job.q[:1], (30, 1))
    q[:, 0] = np.linspace(-2, 2, 30)
    plan = job.campaign.with_poses(q=q)
    one = problem_of(simulate(plan, Truth(sigma=3e-5), instrument=(np.eye(3)[None], np.zeros((1, 3)))))
    _, t, targets = register(one)
    assert np.abs(targets[0, 0] - PLACES[0]).max() < 1e-3
    assert np.linalg.norm(t) < 5


@pytest.mark.parametrize("stated", [None, (0.0, 0.0, 0.1), (0.0, 0.0, 0.0), (0.05, 0.05, 0.15)])
def test_a_line_with_a_hand_that_never_turns_is_no_mistake(stated):
    """What the turn about the line and the target are, such poses do not say: no reason to go astray."""
    line = held(np.outer(np.linspace(0, 0.5, 30), [0, 1, 0]), np.zeros((30, 3)))
    plan = planned(load_robot("ur5"), line, targets=(Target("C", stated),))
    truth = Truth(targets=PLACES[:1], sigma=1e-4)
    job = problem_of(simulate(plan, truth, instrument=(np.eye(3)[None], np.array([[0.3, 4.0, 0.5]]))))
    assert not believed(job)[1]
    R, t, targets = register(job)
    seen = job.rigid.points(targets[0], job.on) @ R[0].T + t[0]
    assert np.median(np.linalg.norm(seen - job.campaign.points, axis=2)) < 3e-4
    assert np.allclose(targets[0, 0], stated or 0.0, atol=3e-3)


@pytest.mark.parametrize(
    ("factor", "said"),
    [(1e3, "they are millimetres, not metres"), (1e-3, "they are metres, not millimetres")],
)
def test_points_in_a_wrong_unit_are_named(factor, said):
    job, _, _ = measured(seed=6)
    wrong = replace(job, campaign=replace(job.campaign, points=job.campaign.points * factor))
    with pytest.raises(InputError) as caught:
        believed(wrong)
    assert len(caught.value.faults) == 1
    assert said in str(caught.value)
    assert "of the points" in str(caught.value)


@pytest.mark.parametrize(
    ("factor", "said"),
    [(180 / np.pi, "they are degrees, not radians"), (np.pi / 180, "they are radians, not degrees")],
)
@pytest.mark.parametrize("targets", [TARGETS, unknown(1)], ids=["three", "one unknown"])
def test_joints_in_a_wrong_unit_are_named(factor, said, targets):
    job, _, _ = measured(targets=targets, seed=7)
    wrong = replace(job, campaign=job.campaign.with_poses(q=job.q * factor))
    with pytest.raises(InputError) as caught:
        believed(wrong)
    assert len(caught.value.faults) == 1
    assert said in str(caught.value)
    assert "of the joints" in str(caught.value)


def test_both_in_a_wrong_unit_are_named_at_once():
    job, _, _ = measured(seed=8)
    c = job.campaign
    with pytest.raises(InputError) as caught:
        believed(replace(job, campaign=replace(c.with_poses(q=np.degrees(c.poses.q)), points=c.points * 1e3)))
    assert len(caught.value.faults) == 2


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("share", [0.9, 0.2])
def test_right_units_pass(seed, share):
    believed(measured(seed=seed, share=share)[0])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("targets", [TARGETS, unknown(1)], ids=["three", "one unknown"])
def test_a_small_range_is_legal(seed, targets):
    """±3° about one pose: as small as radians taken for degrees would be, and no fault."""
    job, _, _ = measured(targets=targets, seed=seed)
    q = job.q[:1] + np.radians(3) * np.random.default_rng(seed).uniform(-1, 1, job.q.shape)
    plan = job.campaign.with_poses(q=q)
    believed(problem_of(simulate(plan, Truth(sigma=3e-5, targets=places(targets)), seed=seed)))


def test_few_poses_are_not_judged():
    job, _, _ = measured(poses=5)
    believed(replace(job, campaign=replace(job.campaign, points=job.campaign.points * 1e3)))


def test_one_vector_turns_as_many_do_and_the_middle_is_numpys():
    """To the last bit: the short ways that registrations take."""
    rng = np.random.default_rng(0)
    vectors = rng.normal(size=(500, 3)) * 10.0 ** rng.uniform(-9, 1, (500, 1))
    assert np.array_equal([from_vectors(one) for one in vectors], from_vectors(vectors))
    assert np.array_equal(from_vectors(np.zeros(3)), np.eye(3))
    for count in (1, 2, 7, 8):
        numbers = rng.normal(size=(count, 3))
        assert np.array_equal(middle_of(numbers), np.median(numbers, axis=0))
        assert middle_of(numbers[:, 0]) == np.median(numbers[:, 0])

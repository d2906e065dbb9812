"""A simulated campaign has the noise that was asked for, the physics of Drake, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.campaign import Target, load_campaign, write_campaign
from workbench.campaign.planned import planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.effects.records import parse_effect
from workbench.files.faults import InputError
from workbench.identification.registration import register
from workbench.robot.description import load_robot
from workbench.robot.elastic_plant import elastic_twin
from workbench.robot.find import list_robots
from workbench.robot.loads import Loads
from workbench.robot.rigid_plant import arrays, rigid_twin
from workbench.robot.yielding import Yielding
from workbench.simulation.virtual_campaign import Truth, idle_effects, random_geometry, simulate

STILL = np.zeros(6)


def plan_of(n_poses, name="kr500", **columns):
    robot = load_robot(name)
    return planned(robot, random_poses(robot, n_poses, np.random.default_rng(5)), **columns)


def test_noise_is_as_large_as_stated():
    plan = plan_of(150)
    exact = simulate(plan, Truth(repeatability=STILL), seed=3)
    noisy = simulate(plan, Truth(repeatability=STILL, sigma=3e-5), seed=3, shots=3)
    spread = (noisy.points - exact.points) / (3e-5 / np.sqrt(3))
    assert abs((spread**2).mean() - 1) < 4 * np.sqrt(2 / spread.size)
    scatter, dof = noisy.shot_scatter
    assert dof == 2 * spread.size
    assert abs(scatter / dof / 3e-5**2 - 1) < 4 * np.sqrt(2 / dof)
    assert noisy.noise_sigma == 3e-5
    assert simulate(plan, Truth(sigma=3e-5), state_sigma=False).noise_sigma is None


def test_a_seed_gives_the_same_campaign_and_another_seed_another():
    plan = plan_of(5)
    truth = Truth(sigma=3e-5)
    one, same, other = (simulate(plan, truth, seed=seed, torque_sigma=0.03) for seed in (1, 1, 2))
    assert np.array_equal(one.points, same.points)
    assert np.array_equal(one.poses.torque, same.poses.torque)
    assert not np.isclose(one.points, other.points, atol=1e-6).any()


def test_more_shots_do_not_change_the_robot():
    plan = plan_of(4)
    few, many = (simulate(plan, Truth(sigma=1e-12), shots=shots).points for shots in (1, 5))
    assert np.abs(few - many).max() < 1e-10


def test_repeatability_moves_all_targets_of_a_pose_together():
    plan = plan_of(60)
    sigma = np.array([0, 2e-5, 0, 0, 0, 0])
    exact = simulate(plan, Truth(repeatability=STILL)).points
    moved = simulate(plan, Truth(repeatability=sigma)).points - exact
    # one joint's error: the three targets of a pose tell the same angle
    job = problem_of(plan)
    axis, pivot = job.rigid.axes[:, 2, 5], job.rigid.origin[:, 2]
    R, t = _frame(simulate(plan, Truth(repeatability=STILL)), job)
    arms = np.einsum("ji,ntj->nti", R, exact - t) - pivot[:, None]
    base = np.einsum("ji,ntj->nti", R, moved)
    lever = np.cross(axis[:, None], arms)
    angle = (base * lever).sum(axis=2) / (lever**2).sum(axis=2)
    assert np.abs(angle - angle.mean(axis=1, keepdims=True)).max() < 0.02 * 2e-5
    assert abs(angle[:, 0].std() / 2e-5 - 1) < 4 / np.sqrt(2 * 60)


def _frame(campaign, job):
    """Frame of the base in the instrument's, from the points themselves (the arm sags a little)."""
    R, t, _ = register(replace(job, campaign=campaign))
    return R[0], t[0]


def test_a_six_dof_measurement_has_six_errors_per_pose():
    targets = tuple(
        Target(f"T{i}", tuple(xyz)) for i, xyz in enumerate(np.random.default_rng(0).normal(size=(5, 3)))
    )
    plan = replace(plan_of(40, targets=targets), six_dof=True)
    exact = simulate(plan, Truth(repeatability=STILL)).points
    error = simulate(plan, Truth(repeatability=STILL, sigma=1e-4)).points - exact
    arms = exact - exact.mean(axis=1, keepdims=True)
    for e, x in zip(error, arms, strict=True):
        A = np.vstack([np.hstack([np.eye(3), np.cross(np.eye(3), v).T]) for v in x])
        assert np.linalg.norm(e.ravel() - A @ np.linalg.lstsq(A, e.ravel(), rcond=None)[0]) < 1e-12
    assert abs(error.mean(axis=1).std() / 1e-4 - 1) < 0.2


def test_torques_are_those_that_hold_the_arm():
    robot = load_robot("longlink")
    plan = planned(robot, random_poses(robot, 3, np.random.default_rng(5)), tool=(10.0, (0.0, 0.0, 0.1)))
    measured = simulate(plan, Truth(), torque_sigma=0.0)
    arm, twin = arrays(robot), elastic_twin(arrays(robot), robot, Yielding(0 * arrays(robot).compliance))
    for q, torque in zip(plan.poses.q, measured.poses.torque, strict=True):
        loads = Loads(np.array([10.0]), np.array([[0, 0, 1.0]]), np.zeros((1, 6)), np.zeros((1, 7)))
        twin.equilibrium(q, np.zeros((arm.slots, 6)), loads)
        up = twin.plant.CalcPotentialEnergy(twin.context)
        for j in range(arm.n):
            step = 1e-5 * np.eye(arm.n)[j]
            twin.equilibrium(q + step, np.zeros((arm.slots, 6)), loads)
            slope = (twin.plant.CalcPotentialEnergy(twin.context) - up) / 1e-5
            assert abs(torque[j] - slope) < 0.01 * np.abs(torque).max()


def test_hooks_do_what_the_effects_do():
    plan = plan_of(4, payloads={"heavy": (200.0, (0.1, 0.0, 0.2))}, payload=["heavy"] * 4)
    job = problem_of(plan)
    tilt = np.diag([0, 0, 0, 2e-8, 2e-8, 0])
    pairs = {
        "gear_ratio:joint=joint_3,relative=1e-4": {"joints": lambda p: 1e-4 * p.q * np.eye(6)[2]},
        "hose_torque:joint=joint_5,rate=20": {"torque": lambda p: -20 * p.q * np.eye(6)[4]},
        "bearing_tilt:joint=joint_2,compliance=2e-8": {"yields": {2: lambda wrench: tilt @ wrench}},
        "tracker_scale:scale=1e-4": {"seen": lambda p, points: points * (1 + 1e-4)},
    }
    for text, hook in pairs.items():
        by_effect = simulate(plan, Truth(effects=(parse_effect(text, job),)))
        by_hook = simulate(plan, Truth(**hook))
        assert np.abs(by_effect.points - by_hook.points).max() < 1e-11, text
        assert np.abs(by_hook.points - simulate(plan, Truth()).points).max() > 1e-6, text


def test_the_hook_for_motions_moves_a_frame():
    plan = plan_of(3)
    shifted = simulate(plan, Truth(motion=lambda p: {6 * 7 + 0: np.full(3, 1e-3)})).points
    moved = np.linalg.norm(shifted - simulate(plan, Truth()).points, axis=2)
    assert np.abs(moved - 1e-3).max() < 1e-6


def test_random_geometry_moves_the_hand_by_millimetres():
    plan = plan_of(20)
    job = problem_of(plan)
    geometry = random_geometry(job.arm, np.random.default_rng(2))
    assert not geometry[[0, -1]].any()
    moved = simulate(plan, Truth(geometry=geometry)).points - simulate(plan, Truth()).points
    assert 2e-4 < np.linalg.norm(moved, axis=2).mean() < 1e-2


def test_an_effect_that_does_nothing_is_refused():
    plan = plan_of(3)
    effect = parse_effect("backlash:joint=joint_1,half_width=1e-4", problem_of(plan))
    with pytest.raises(InputError, match=r"no column dir1\.\.dir6"):
        simulate(plan, Truth(effects=(effect,)))


def test_effects_that_move_no_point_are_told():
    """A rigid arm does not show what it carries; with a soft joint it does."""
    plan = plan_of(4, "irb120", payloads={"box": (3.0, (0.0, 0.0, 0.05))}, payload=["box"] * 4)
    problem = problem_of(plan)
    heavier = parse_effect("payload:payload=box", problem)
    soft = parse_effect("joint_compliance:joint=joint_2", problem)
    assert idle_effects(plan, Truth(effects=(heavier,))) == (heavier[0],)
    assert idle_effects(plan, Truth(effects=(heavier, soft))) == ()


def test_a_target_without_a_place_is_refused():
    with pytest.raises(InputError, match="state its xyz_mm"):
        simulate(plan_of(2, targets=(Target("T9"),)), Truth())


def test_a_written_campaign_loads_as_it_was(tmp_path):
    measured = simulate(plan_of(6, direction=np.ones((6, 6))), Truth(sigma=3e-5), seed=4, torque_sigma=0.03)
    loaded = load_campaign(write_campaign(tmp_path, measured))
    assert np.allclose(loaded.points, measured.points, atol=1e-12)
    assert np.allclose(loaded.poses.torque, measured.poses.torque)
    assert np.allclose(loaded.poses.q, measured.poses.q)
    assert loaded.noise_sigma == pytest.approx(3e-5)


@pytest.mark.parametrize("name", [path.stem for path in list_robots()])
def test_random_poses_are_within_limits_and_above_the_floor(name):
    robot = load_robot(name)
    q = random_poses(robot, 30, np.random.default_rng(1))
    assert q.shape == (30, len(robot.joints))
    assert (q > [joint.lower for joint in robot.joints]).all()
    assert (q < [joint.upper for joint in robot.joints]).all()
    twin = rigid_twin(robot)
    base = twin.plant.GetFrameByName(robot.base)
    for pose in q:
        twin.set_positions(pose)
        X = twin.plant.GetFrameByName(robot.flange).CalcPose(twin.context, base)
        assert X.translation()[2] > 0.0


def test_poses_that_cannot_be_had_are_refused():
    with pytest.raises(InputError, match="hardly any pose"):
        random_poses(load_robot("kr500"), 10, np.random.default_rng(0), floor=9.0)

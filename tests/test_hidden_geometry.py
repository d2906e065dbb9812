"""Corrections that no point shows are found by the chain alone; fits do not use them as levers of loads."""

import numpy as np
import pytest

from workbench import Truth, load_robot, parse_effect, planned, problem, random_poses, simulate
from workbench.diagnosis.prepared import prepare
from workbench.identification.parameters import GEOMETRY_PRIOR, LEVER_PRIOR, columns
from workbench.robot.hidden_geometry import hidden_corrections
from workbench.robot.kinematics import RX, RY, RZ, TX, TY, TZ, frames
from workbench.robot.rigid_plant import arrays
from workbench.robot.rotations import from_vectors


def motions(arm):
    """(R, 12 + 6 n) motions of three points on the flange by shift and turn of the base, of the tool, and by
    the corrections of all joints, zeros before shifts before other turns, by central differences; their
    columns 6 · slot + component."""
    rng = np.random.default_rng(7)
    q, places = rng.uniform(-3, 3, (30, arm.n)), rng.uniform(-0.4, 0.4, (3, 3))
    on, step, still = [arm.slots - 1] * 3, 1e-5, np.zeros(6)

    def points(geometry, base=still, tool=still):
        moved = places @ from_vectors(tool[3:]).T + tool[:3]
        return frames(arm.with_geometry(geometry), q).points(moved, on) @ from_vectors(base[3:]).T + base[:3]

    zero, out = arm.geometry, []
    for unit in step * np.eye(6):
        out.append(points(zero, base=unit) - points(zero, base=-unit))
    for unit in step * np.eye(6):
        out.append(points(zero, tool=unit) - points(zero, tool=-unit))
    columns = [6 * slot + component for slot in range(1, arm.n + 1) for component in (RZ, TX, TY, TZ, RX, RY)]
    for column in columns:
        change = np.zeros(zero.size)
        change[column] = step
        change = change.reshape(zero.shape)
        out.append(points(zero + change) - points(zero - change))
    return np.stack([(x / (2 * step)).ravel() for x in out], axis=1), columns


@pytest.mark.parametrize("name", ["ur5", "irb120", "kr500", "rx170", "cylindrical", "iiwa7"])
def test_hidden_corrections_move_no_point_that_others_do_not(name):
    """And of the others each moves some as nothing before it does."""
    arm = arrays(load_robot(name))
    J, columns = motions(arm)
    hidden = hidden_corrections(arm)
    assert {6, 7, 8} <= hidden < set(columns)  # the base's own place, never all
    own = [12 + i for i, column in enumerate(columns) if column in hidden]
    rest = [i for i in range(J.shape[1]) if i not in own]
    left = J[:, own] - J[:, rest] @ np.linalg.lstsq(J[:, rest], J[:, own], rcond=1e-8)[0]
    assert np.abs(left).max() < 1e-6
    for i, column in enumerate(columns):
        if column % 6 != RZ and column // 6 > 1 and column not in hidden:
            before = J[:, : 12 + i]
            left = J[:, 12 + i] - before @ np.linalg.lstsq(before, J[:, 12 + i], rcond=1e-8)[0]
            assert np.abs(left).max() > 1e-3


def test_their_prior_is_that_of_a_machine_and_who_chooses_columns_has_them_free():
    robot = load_robot("kr500")
    job = problem(planned(robot, random_poses(robot, 5, np.random.default_rng(1))))
    cols = columns(job, ())
    of = dict(zip(cols.geometry.tolist(), cols.prior[cols.geometry_slice], strict=True))
    hidden = hidden_corrections(job.arm) - job.flange_stays
    assert {column for column, prior in of.items() if prior == LEVER_PRIOR[column % 6 // 3]} == hidden
    chosen = columns(job, (), geometry=sorted(hidden))
    assert set(chosen.prior[chosen.geometry_slice]) == {GEOMETRY_PRIOR[0]}


def test_a_compensator_is_not_taken_for_a_shoulder_that_is_higher():
    """It would change the compensator's lever: by 26 mm, as far as the loaded points can say."""
    robot = load_robot("kr500")
    rng = np.random.default_rng(3)
    plan = planned(robot, random_poses(robot, 70, rng, share=0.7), tool=(150.0, (0.0, 0.0, 0.2)))
    leak = parse_effect("gravity_compensator:relative=-0.1", problem(plan))
    geometry = prepare(simulate(plan, Truth(effects=(leak,), sigma=2e-5), seed=2)).geometry
    shifts = [name for name in geometry.columns.names if name.startswith("geometry/joint_2/t")]
    assert max(abs(geometry.value(name)) for name in shifts) < 1e-3


def test_many_poses_of_a_soft_joint_do_not_turn_the_compensator_about_the_column():
    """The more poses, the more a prior gives way: of 400 the whole arm was turned by 22° on its column,
    and the robot refused as none of its kind."""
    robot = load_robot("kr120")
    plan = planned(robot, random_poses(robot, 400, np.random.default_rng(4)))
    known = problem(plan)
    hidden = [
        parse_effect("joint_compliance:joint=joint_3", known),
        parse_effect("gear_eccentricity:joint=joint_2", known),
    ]
    geometry = prepare(simulate(plan, Truth(effects=tuple(hidden), sigma=3e-5), seed=4)).geometry
    turns = geometry.state.geometry[2:, 3:] - known.arm.geometry[2:, 3:]
    assert geometry.chi2 > 3 * geometry.point_rows  # what is hidden is no geometry
    assert np.abs(turns).max() < 0.02

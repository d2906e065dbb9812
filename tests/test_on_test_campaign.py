"""What a test campaign shows besides its errors: that it stands elsewhere, or tests nothing."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from diagnosis_cases import measured, with_points

from workbench import Truth, diagnose, load_robot, parse_effect, planned, problem_of, random_poses, simulate
from workbench.diagnosis.found import FaultFound
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.telling.on_test_campaign import test_figures as figures_on
from workbench.effects.payload import Payload
from workbench.files.faults import InputError
from workbench.identification.fit import refit
from workbench.report.terminal import fault_lines
from workbench.robot.rotations import from_vectors


@cache
def halves():
    campaign = measured("ur5", poses=50, loads=())
    return prepare(campaign.some(np.arange(30))), campaign.some(np.arange(30, 50)), campaign


def figures(test):
    prepared, _, _ = halves()
    return figures_on(prepared.nominal, prepared.geometry, test)


def test_an_instrument_elsewhere_is_told_with_what_its_own_frame_leaves():
    _, test, _ = halves()
    assert figures(test).notes == ()
    turned = from_vectors(np.array([0.0, 0.0, 2e-3]))
    middle = np.nanmean(test.points, axis=(0, 1))
    moved = figures(with_points(test, (test.points - middle) @ turned.T + middle + [0.0, 0.004, 0.0]))
    (said,) = moved.notes
    assert "stands 4 mm and 0.11° from where the fit has it" in said
    ((setup, size, left),) = moved.moved
    assert (setup, size) == ("", pytest.approx(4.0, abs=0.1))
    assert left == pytest.approx(figures(test).after_mean_mm, rel=0.3)
    named = replace(with_points(test, test.points + 0.004), setup_names=("afterwards",))
    assert figures(named).notes == ()


def test_a_target_that_the_fit_found_elsewhere_is_there_in_the_test_too():
    """It was said of the fit's campaign; for the test's alone some mistake of the joints would explain it."""
    campaign = measured("ur5", poses=50, loads=(), targets=1)
    (target,) = campaign.targets
    x, y, z = target.xyz
    off = replace(campaign, targets=(replace(target, xyz=(x + 0.02, y - 0.02, z + 0.02)),))
    prepared = prepare(off.some(np.arange(30)))
    found = figures_on(prepared.nominal, prepared.geometry, off.some(np.arange(30, 50)))
    assert found.notes == ()
    assert found.after_mean_mm < 0.1


def test_a_test_of_another_year_has_its_own_set_up():
    """Instrument and base elsewhere, and another target in the place of one: nobody named either set-up."""
    _, test, _ = halves()
    turned = from_vectors(np.array([0.02, -0.01, 1.4]))
    far = with_points(test, test.points @ turned.T + [2.0, -1.0, 0.3])
    said = figures(far)
    (note,) = said.notes
    assert "was set up anew" in note
    assert said.moved == ()
    assert said.after_mean_mm == pytest.approx(figures(test).after_mean_mm, rel=0.3)
    other = figures(replace(far, targets=(replace(far.targets[0], name="Z"), *far.targets[1:])))
    assert other.after_mean_mm == pytest.approx(said.after_mean_mm)
    named = replace(far, setup_names=("afterwards",))
    assert figures(named).after_mean_mm == pytest.approx(said.after_mean_mm)
    assert figures(named).notes == ()


def test_what_was_found_of_a_tool_among_others_holds_for_a_test_with_that_tool():
    """Of campaigns with other tools each is a payload by a name of its own: the test was without it."""
    arm, rng, campaigns = load_robot("kr500"), np.random.default_rng(0), []
    for name, mass in (("one", 60.0), ("two", 260.0), ("test", 260.0)):
        plan = planned(arm, random_poses(arm, 25, rng), tool=(mass, (0.1, 0.0, 0.2)))
        heavier = parse_effect("payload:payload=tool,variant=mass,mass=60", problem_of(plan))
        seen = simulate(plan, Truth(sigma=3e-5, effects=(heavier,)), seed=len(campaigns))
        campaigns.append(replace(seen, path=Path(name) / "campaign.toml"))
    *two, test = campaigns
    prepared = prepare(two)
    sites = Payload.sites(prepared.problem)
    final = refit(prepared.geometry, [one for one in sites if one.variant == "mass"])
    assert figures_on(prepared.nominal, final, test).after_rms_mm < 0.12
    assert figures_on(prepared.nominal, prepared.geometry, test).after_rms_mm > 0.2
    lighter = replace(test, tool_mass=200.0)  # of another tool nothing was found
    assert figures_on(prepared.nominal, final, lighter).after_rms_mm > 0.2


def test_another_robot_is_no_test_though_its_joints_have_the_same_names():
    left, right = load_robot("ma1400-left"), load_robot("ma1400-right")
    assert left.joint_names == right.joint_names
    _, test, _ = halves()
    with pytest.raises(InputError, match="is of ma1400-right, which is not the robot of"):
        diagnose(replace(test, robot=left), test=replace(test, robot=right))


def test_an_instrument_that_steps_in_the_course_of_a_test_is_told_as_in_a_fit():
    campaign = measured("ur5", poses=60, loads=())
    prepared, test = prepare(campaign.some(np.arange(30))), campaign.some(np.arange(30, 60))
    sound = figures_on(prepared.nominal, prepared.geometry, test)
    assert sound.faults == ()
    points = test.points.copy()
    points[14:] += [1e-3, -5e-4, 0.0]
    stepped = figures_on(prepared.nominal, prepared.geometry, with_points(test, points))
    (fault,) = stepped.faults
    assert (fault.kind, fault.pose_id) == ("moved_instrument", test.poses.ids[14])
    assert stepped.after_mean_mm == pytest.approx(sound.after_mean_mm, rel=0.1)
    assert stepped.all_mean_mm > 0.5


def test_a_test_that_is_refused_is_refused_before_the_search():
    _, test, whole = halves()
    told = []
    shuffled = with_points(test, test.points[np.random.default_rng(0).permutation(len(test.points))])
    with pytest.raises(InputError):
        diagnose(whole.some(np.arange(30)), test=shuffled, progress=told.append)
    assert told[-1] == "looking at the test campaign"


def test_poses_that_were_fitted_are_no_test():
    campaign = halves()[2]
    (said,) = figures(campaign.some(np.arange(20))).notes
    assert said == (
        "20 of the test campaign's 20 poses are those that were fitted, with the same points: as a test they "
        "show nothing."
    )
    again = campaign.some(np.arange(20))
    noise = np.random.default_rng(0).normal(0, 3e-5, again.points.shape)
    (said,) = figures(with_points(again, again.points + noise)).notes
    assert "measured another time" in said


def test_targets_named_for_one_another_in_a_test_keep_their_points():
    _, test, _ = halves()
    mixed = figures(with_points(test, test.points[:, [1, 0, 2]]))
    assert mixed.faults == ()
    (said,) = mixed.notes
    assert "T1, T2 are stated for one another" in said
    assert mixed.after_rms_mm == pytest.approx(figures(test).after_rms_mm)


def test_faults_have_a_line_for_each_pose_with_its_targets():
    faults = [FaultFound("outlier", "20", f"T{k}", f"{k} mm off", "left out") for k in (1, 2, 3)]
    faults.append(FaultFound("outlier", None, "T1", "is nowhere", "all its points left out"))
    assert fault_lines(faults, "data fault") == [
        "data fault: outlier at pose 20, T1, T2, T3: 1 mm off (T1) (left out)",
        "data fault: outlier, T1: is nowhere (all its points left out)",
    ]
    many = [FaultFound("outlier", str(n), None, "off", "left out") for n in range(15)]
    (said,) = fault_lines(many, "data fault")
    assert "outlier at poses 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 … 14: off (left out)" in said
    many = [replace(fault, what=f"{n} mm off") for n, fault in enumerate(many)]
    assert fault_lines(many, "data fault")[10:] == ["... and 5 more lines like these"]

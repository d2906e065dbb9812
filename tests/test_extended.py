"""model.toml: the extended robot is written, loaded and written again without a digit changing."""

from dataclasses import replace

import numpy as np
import pytest
from extended_example import extended, extended_kr500

from workbench.campaign.planned import planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.correction.command import compensate
from workbench.correction.conditions import conditions_of, stated_conditions
from workbench.correction.paths import Path
from workbench.diagnosis.run import diagnose
from workbench.effects.backlash import Backlash
from workbench.effects.lost_motion import LostMotion
from workbench.effects.place import Where
from workbench.effects.readback_joints import ReadbackJoints
from workbench.effects.records import parse_effect
from workbench.files.faults import InputError
from workbench.identification.fit import fit, start_state
from workbench.identification.model import Model
from workbench.identification.model_file import write_fit, write_model
from workbench.identification.noise import Covariance
from workbench.robot.description import load_robot
from workbench.robot.rigid_plant import arrays
from workbench.robot.schema import LoadData
from workbench.simulation.virtual_campaign import Truth, simulate

LOADS = {"heavy": (250.0, (0.15, 0.0, 0.0712345)), "light": (80.5, (0.0, 0.01, 0.1))}
TOOL = (60.0, (0.0, 0.0, 0.08))


def corrections(robot):
    return arrays(robot).geometry


def line(robot, count=50):
    q = np.tile([0.0, -1.2, 1.6, 0.1, 0.8, 0.0], (count, 1))
    q[:, 0] = np.linspace(-0.2, 0.2, count)
    return Path(0.1 * np.arange(count), q=q)


def test_write_load_write_is_exact(tmp_path):
    robot = replace(
        extended_kr500(),
        tool=LoadData(mass_kg=60.0, com_mm=(0.0, 0.1, 80.0)),
        payloads={"heavy": LoadData(mass_kg=250.1, com_mm=(150.0, 0.0, 71.2345))},
    )
    first, second = tmp_path / "a" / "model.toml", tmp_path / "b" / "c" / "model.toml"
    write_model(first, robot, corrections(robot), robot.effects)
    once = load_robot(first)
    write_model(second, once, corrections(once), once.effects)
    twice = load_robot(second)
    assert replace(twice, path=None, urdf=robot.urdf) == replace(once, path=None, urdf=robot.urdf)
    assert once.geometry == robot.geometry
    assert once.effects == robot.effects
    assert once.pose_repeatability_mm == twice.pose_repeatability_mm == 0.08
    assert (once.tool, once.payloads) == (robot.tool, robot.payloads)
    strip = [text.read_text().replace("../", "") for text in (first, second)]
    assert strip[0] == strip[1]


def test_a_fit_is_written_with_the_loads_of_its_campaign(tmp_path):
    robot = load_robot("kr500")
    q = random_poses(robot, 20, np.random.default_rng(1))
    plan = planned(robot, q, payloads=LOADS, payload=["heavy"] * 20, tool=TOOL)
    measured = simulate(plan, Truth(sigma=3e-5))
    whole = problem_of(measured)
    noise = Covariance(np.full(whole.seen.shape, 3e-5), np.zeros(6), np.ones(20))
    write_fit(tmp_path / "model.toml", fit(Model(whole), start_state(whole), noise))
    model = load_robot(tmp_path / "model.toml")
    assert model.tool == LoadData(mass_kg=60.0, com_mm=(0.0, 0.0, 80.0))
    assert model.payloads["heavy"] == LoadData(mass_kg=250.0, com_mm=(150.0, 0.0, 71.2345))
    assert set(model.payloads) == {"heavy", "light"}
    said, known = stated_conditions(model, "heavy"), conditions_of(measured, "heavy")
    assert (said.payload, said.payload_mass, said.tool_mass) == ("heavy", 250.0, 60.0)
    assert np.allclose([said.payload_com, said.tool_com], [known.payload_com, known.tool_com], atol=1e-15)


def test_a_gear_line_of_unknown_order_survives_its_model(tmp_path):
    """What a scan found is written, loaded, compensated and known to the next diagnosis."""
    robot = load_robot("kr500")
    bare = tuple(
        replace(j, data=j.data.model_copy(update={"gear_ratio": None})) if j.name == "joint_3" else j
        for j in robot.joints
    )
    robot = replace(robot, joints=bare)
    plan = planned(robot, random_poses(robot, 120, np.random.default_rng(2)))
    hidden = parse_effect("gear_kinematic_error:joint=joint_3,order=88.4,amplitude=3e-4", problem_of(plan))
    measured = simulate(plan, Truth(effects=(hidden,), sigma=3e-5))
    outcome = diagnose(measured)
    (found,) = outcome.diagnosis.causes
    assert (found.cause, found.where.joint) == ("gear_kinematic_error", "joint_3")
    assert abs(found.where.order - 88.4) < 0.1
    write_fit(tmp_path / "model.toml", outcome.fit)
    model = load_robot(tmp_path / "model.toml")
    assert compensate(model, line(model)).before_mm.max() > 0.1
    again = diagnose(replace(measured, robot=model))
    assert again.diagnosis.verdict == "nothing_missing"


def test_compensation_takes_the_model_s_own_loads():
    robot = replace(
        load_robot("kr500"),
        tool=LoadData(mass_kg=60.0, com_mm=(0.0, 0.0, 80.0)),
        payloads={"heavy": LoadData(mass_kg=250.0)},
    )
    path = line(robot)
    bare = compensate(replace(robot, tool=None), path).before_mm.max()
    tool = compensate(robot, path).before_mm.max()
    heavy = compensate(robot, path, stated_conditions(robot, "heavy")).before_mm.max()
    assert bare + 0.05 < tool < heavy - 0.2
    with pytest.raises(InputError, match="known: heavy"):
        stated_conditions(robot, "light")


def test_lost_motion_stays_on_a_joint_that_carries_nothing_on_this_path():
    # the axis of joint_1 is vertical: gravity makes no torque about it
    soft = LostMotion(Where(joint="joint_1"), "soft 0.15", torque=1500.0)
    robot = extended(load_robot("kr500"), [(soft, [6e-5])], size=0.0)
    path = line(robot)
    assert compensate(robot, path).after_mm.max() < 1e-6
    assert not any("lost_motion" in note for note in compensate(robot, path).notes)
    sites = {place.where.joint for place in LostMotion.sites(problem_of(planned(robot, path.q)))}
    assert "joint_1" not in sites
    pushed = compensate(robot, replace(path, wrench=np.tile([0.0, 900, 0, 0, 0, 0], (50, 1))))
    free = compensate(replace(robot, effects=()), pushed.path)
    assert np.abs(pushed.q_command - free.q_command)[:, 0].min() > 3e-5


def test_read_back_joints_and_play_stay_without_their_columns():
    records = [(ReadbackJoints(), [0.8]), (Backlash(Where(joint="joint_2")), [4e-5])]
    robot = extended(load_robot("kr500"), records, size=0.0)
    assert not [note for note in compensate(robot, line(robot)).notes if "readback" in note]
    plan = planned(robot, random_poses(robot, 3, np.random.default_rng(1)))
    with_them = simulate(plan, Truth(repeatability=np.zeros(6))).points
    without = simulate(replace(plan, robot=replace(robot, effects=())), Truth(repeatability=np.zeros(6)))
    assert np.array_equal(with_them, without.points)
    asked = (Backlash(Where(joint="joint_2")), np.array([4e-5]))
    with pytest.raises(InputError, match=r"does nothing in these poses; no column dir1\.\.dir6"):
        simulate(plan, Truth(effects=(asked,)))

"""The exported robot in other programs: Drake's parser, MuJoCo, Pinocchio."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from workbench import Conditions, load_robot
from workbench.robot.equilibrium import equilibrium
from workbench.robot.find import list_robots
from workbench.robot.kinematics import frames
from workbench.robot.schema import GEOMETRY, EffectRecord
from workbench.simulation.export import export
from workbench.simulation.export.coil import nearest_coil
from workbench.simulation.export.content import content_of
from workbench.simulation.random_robot import write_random_robot

LOAD = Conditions("heavy", 40.0, (0.05, 0.02, 0.15), 5.0, (0.0, 0.01, 0.05))
YIELDS = (
    EffectRecord(cause="foundation", values={"compliance": 4e-9}),
    EffectRecord(cause="bearing_tilt", joint="joint_2", values={"compliance": 2e-8}),
    EffectRecord(cause="link_mass", link="link_3", variant="mass", values={"mass": 12.0}),
)
ELASTIC = ["kr500", "rx170", "cylindrical", "6R", "PRRR", "longlink"]


def model(folder, name, effects=()):
    """A robot with corrections of half a millimetre and half a milliradian, and with effects."""
    robot = load_robot(write_random_robot(folder, 5, name) if name[-1] == "R" else name)
    rng = np.random.default_rng(7)
    geometry = {j.name: dict(zip(GEOMETRY, 5e-4 * rng.normal(size=6), strict=True)) for j in robot.joints}
    known = set(robot.joint_names)
    effects = tuple(e for e in effects if e.joint is None or e.joint in known)
    return replace(robot, geometry=geometry, effects=effects)


def joints(content, count=5):
    return content.problem.q[:count]


def drakes(file):
    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -9.80665])  # Drake's own is 9.81
    Parser(plant).AddModels(str(file))
    base = next(body for body in ("ground", "base_link", "base") if plant.HasBodyNamed(body))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(base))
    plant.Finalize()
    return plant, plant.CreateDefaultContext()


def flange_of(robot, plant, context):
    return plant.GetFrameByName(robot.flange).CalcPoseInWorld(context)


def at_rest(content):
    """The flange (N, 3) [m] and its rotations where the batch arithmetic has the exported robot rest."""
    arm, loads = content.loaded
    loads = replace(loads, compensator=nearest_coil(content))
    arm = replace(arm, compliance=content.compliance)
    still = np.zeros((len(content.problem.q), arm.slots, 6))
    law = content.acting(frozenset({"spring"})).yielding(content.problem.arm)
    where = equilibrium(arm, content.problem.q, still, loads, law.motion)[1]
    return where.p[-1], where.R[-1]


@pytest.mark.parametrize("name", [*(path.stem for path in list_robots()), "6R", "7R", "PRRR"])
def test_urdf_is_the_calibrated_arm_in_drake_and_pinocchio(tmp_path, name):
    robot = model(tmp_path, name)
    written = export(robot, "urdf", tmp_path / "out")
    content = content_of(robot, None, Conditions())
    where = frames(content.arm, joints(content))
    plant, context = drakes(written.files[0])
    other = pinocchio.buildModelFromUrdf(str(tmp_path / "out" / f"{robot.name}.urdf"))
    data, tool = other.createData(), other.getFrameId(robot.flange)
    for i, q in enumerate(joints(content)):
        place = np.zeros(plant.num_positions())
        place[[plant.GetJointByName(joint).position_start() for joint in robot.joint_names]] = q
        plant.SetPositions(context, place)
        X = flange_of(robot, plant, context)
        assert np.abs(X.translation() - where.p[-1, i]).max() < 1e-9
        assert np.abs(X.rotation().matrix() - where.R[-1, i]).max() < 1e-9
        configuration = pinocchio.neutral(other)
        for joint, angle in zip(robot.joint_names, q, strict=True):
            configuration[other.joints[other.getJointId(joint)].idx_q] = angle
        pinocchio.framesForwardKinematics(other, data, configuration)
        assert np.abs(data.oMf[tool].translation - where.p[-1, i]).max() < 1e-9
        assert np.abs(data.oMf[tool].rotation - where.R[-1, i]).max() < 1e-9
    nominal = frames(replace(content.arm, geometry=0 * content.arm.geometry), joints(content))
    assert np.abs(where.p[-1] - nominal.p[-1]).max() > 1e-4


def drakes_rest(plant, context, robot, q):
    """Newton on Drake's own forces, springs' joints alone; compliance from the springs themselves."""
    forces = MultibodyForces(plant)
    sprung = [i for i in plant.GetJointIndices() if plant.get_joint(i).name() not in robot.joint_names]
    at = [plant.get_joint(i).position_start() for i in sprung if plant.get_joint(i).num_positions()]
    motors = [plant.GetJointByName(joint).position_start() for joint in robot.joint_names]
    place = np.zeros(plant.num_positions())
    place[motors] = q

    def left(x):
        there = place.copy()
        there[at] = x
        plant.SetPositions(context, there)
        plant.CalcForceElementsContribution(context, forces)
        return plant.CalcGeneralizedForces(context, forces)[at]

    x = np.zeros(len(at))
    for _ in range(8):
        r, h = left(x), 1e-6
        slope = np.array([(left(x + h * e) - left(x - h * e)) / (2 * h) for e in np.eye(len(at))]).T
        x = x - np.linalg.solve(slope, r)
    left(x)
    return flange_of(robot, plant, context)


@pytest.mark.parametrize("name", ELASTIC)
def test_sdf_rests_where_the_model_does(tmp_path, name):
    robot = model(tmp_path, name, YIELDS)
    written = export(robot, "sdf", tmp_path / "out", conditions=LOAD)
    content = content_of(robot, None, LOAD)
    p, R = at_rest(content)
    plant, context = drakes(written.files[0])
    far, turned = [], []
    for i, q in enumerate(joints(content)):
        X = drakes_rest(plant, context, robot, q)
        far.append(np.abs(X.translation() - p[i]).max())
        turned.append(np.abs(X.rotation().matrix() - R[i]).max())
    bends = bool(robot.bending_stiffness)
    assert max(far) < (1e-6 if bends else 1e-9)  # a link's bending turns about its middle: second order
    assert max(turned) < (1e-6 if bends else 1e-9)
    rigid = frames(content.arm, joints(content)).p[-1]
    assert np.abs(rigid - p[:5]).max() > 2e-5


@pytest.mark.parametrize("name", ELASTIC)
def test_mjcf_rests_where_the_model_does(tmp_path, name):
    robot = model(tmp_path, name, YIELDS)
    written = export(robot, "mjcf", tmp_path / "out", conditions=LOAD)
    content = content_of(robot, None, LOAD)
    p, _ = at_rest(content)
    m = mujoco.MjModel.from_xml_path(str(written.files[0]))
    data = mujoco.MjData(m)
    names = [mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_JOINT, i) for i in range(m.njnt)]
    driven = [names.index(joint) for joint in robot.joint_names]
    at = [i for i in range(m.njnt) if i not in driven]

    def left(q, x):
        data.qpos[driven], data.qpos[at], data.qvel[:] = q, x, 0.0
        mujoco.mj_forward(m, data)
        return (data.qfrc_passive - data.qfrc_bias)[at]

    far = []
    for i, q in enumerate(joints(content)):
        x = np.zeros(len(at))
        for _ in range(6):
            h = 1e-6
            slope = np.array([(left(q, x + h * e) - left(q, x - h * e)) / (2 * h) for e in np.eye(len(at))]).T
            x = x - np.linalg.solve(slope, left(q, x))
        left(q, x)
        far.append(np.abs(data.body(robot.flange).xpos - p[i]).max())
    assert max(far) < 1e-6

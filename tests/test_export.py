"""The exported robot in other programs: Drake's parser, MuJoCo, Pinocchio."""

import ast
import importlib.util
import json
import sys
from dataclasses import replace

import mujoco
import numpy as np
import pinocchio
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder

from workbench import Conditions, InputError, load_robot, planned, random_poses
from workbench.robot.equilibrium import equilibrium
from workbench.robot.find import list_robots
from workbench.robot.kinematics import frames
from workbench.robot.schema import GEOMETRY, EffectRecord
from workbench.simulation.export import export
from workbench.simulation.export.coil import nearest_coil
from workbench.simulation.export.content import content_of
from workbench.simulation.export.drake_package import MODULE
from workbench.simulation.export.formats import FORMATS
from workbench.simulation.export.hinges import off_by_hinges
from workbench.simulation.export.kept import kept_of, refitted
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
    frames_of = robot.corrected_frames
    geometry = {name: dict(zip(GEOMETRY, 5e-4 * rng.normal(size=6), strict=True)) for name in frames_of}
    known = set(robot.joint_names)
    effects = tuple(e for e in effects if e.joint is None or e.joint in known)
    return replace(robot, geometry=geometry, effects=effects)


def written_as(robot, to, conditions=None):
    """The robot with the geometry that a format's file has."""
    content = content_of(robot, None, conditions or Conditions())
    chosen = FORMATS[to]
    return refitted(content, kept_of(content, chosen.carries), chosen.has_flange(content))


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
    content = written_as(robot, "urdf")
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


@pytest.mark.parametrize("to", ["urdf", "sdf", "drake"])
def test_meshes_are_what_other_programs_read(tmp_path, to):
    """OBJ with its z up beside the file, as large as the glTF by its own accessor, whose y is up."""
    robot = load_robot("kr500")
    written = {file.name: file for file in export(robot, to, tmp_path).files}
    text = next(file for name, file in written.items() if name in ("kr500.urdf", "kr500.sdf")).read_text()
    assert ".gltf" not in text
    for name in ("base_link", *robot.links):
        assert f"{name}.obj" in text
        lines = written[f"{name}.obj"].read_text().splitlines()
        vertices = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)
        said = json.loads((robot.urdf.parent / f"{name}.gltf").read_text())
        ends = [(a["min"], a["max"]) for a in said["accessors"] if a["type"] == "VEC3" and "min" in a]
        (x, y, z), (X, Y, Z) = np.min([low for low, _ in ends], 0), np.max([high for _, high in ends], 0)
        assert vertices.min(axis=0) == pytest.approx([x, -Z, y], abs=1e-5)
        assert vertices.max(axis=0) == pytest.approx([X, -z, Y], abs=1e-5)
        assert f"mtllib {name}.mtl" in lines
        linear = said["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][0]
        red = next(line for line in written[f"{name}.mtl"].read_text().splitlines() if line.startswith("Kd"))
        assert ((float(red.split()[1]) + 0.055) / 1.055) ** 2.4 == pytest.approx(linear, abs=0.01)


def test_without_the_library_meshes_stay_and_a_note_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr("workbench.robot.meshes._library", lambda: False)
    written = export("kr500", "urdf", tmp_path)
    assert "link_1.gltf" in {file.name for file in written.files}
    assert any("glTF" in line and "pip install" in line for line in written.header)


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


def by_hinges(content):
    """What the header says of bending links, pose by pose [m]: next to nothing, and nothing without them."""
    off = off_by_hinges(content)
    assert (off is not None) == bool(content.robot.bending_stiffness)
    if off is None:
        return np.zeros((len(joints(content)), 3))
    assert 1e-9 < np.linalg.norm(off, axis=1).max() < 1e-7
    return off


@pytest.mark.parametrize("name", ELASTIC)
def test_sdf_rests_where_the_model_does(tmp_path, name):
    robot = model(tmp_path, name, YIELDS)
    written = export(robot, "sdf", tmp_path / "out", conditions=LOAD)
    content = written_as(robot, "sdf", LOAD)
    p, R = at_rest(content)
    plant, context = drakes(written.files[0])
    far, turned, off = [], [], by_hinges(content)
    for i, q in enumerate(joints(content)):
        X = drakes_rest(plant, context, robot, q)
        far.append(np.abs(X.translation() - p[i] - off[i]).max())
        turned.append(np.abs(X.rotation().matrix() - R[i]).max())
    assert max(far) < 1e-9
    assert max(turned) < (1e-7 if robot.bending_stiffness else 1e-9)
    rigid = frames(content.arm, joints(content)).p[-1]
    assert np.abs(rigid - p[:5]).max() > 2e-5


@pytest.mark.parametrize("name", ELASTIC)
def test_mjcf_rests_where_the_model_does(tmp_path, name):
    robot = model(tmp_path, name, YIELDS)
    written = export(robot, "mjcf", tmp_path / "out", conditions=LOAD)
    content = written_as(robot, "mjcf", LOAD)
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


def table(file):
    """Rows of a CSV behind its comments, as dictionaries."""
    lines = [line for line in file.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return [dict(zip(lines[0].split(","), line.split(","), strict=True)) for line in lines[1:]]


def turn(axis, degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    X = np.eye(4)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    X[i, i] = X[j, j] = c
    X[i, j], X[j, i] = -s, s
    return X


def shift(x, y, z):
    X = np.eye(4)
    X[:3, 3] = 1e-3 * np.array([x, y, z])
    return X


def placed(row):
    p = [float(row[f"{axis}_mm"]) for axis in "xyz"]
    angles = [float(row[f"{name}_deg"]) for name in ("yaw", "pitch", "roll")]
    return shift(*p) @ turn("z", angles[0]) @ turn("y", angles[1]) @ turn("x", angles[2])


@pytest.mark.parametrize("name", [*(path.stem for path in list_robots()), "6R", "7R", "PRRR"])
def test_hayati_rows_are_the_arm_and_short(tmp_path, name):
    robot = model(tmp_path, name)
    export(robot, "dh", tmp_path)
    rows, ends = table(tmp_path / "hayati.csv"), table(tmp_path / "frames.csv")
    arm = written_as(robot, "dh").arm
    q = np.random.default_rng(1).uniform(-1, 1, (3, arm.n))
    where = frames(arm, q)
    for i in range(3):
        X = placed(ends[0])
        for row, joint, moved in zip(rows, robot.joints, q[i], strict=True):
            theta, d, a, alpha, beta = (float(value) for value in list(row.values())[1:])
            slides = joint.kind == "prismatic"
            X = X @ turn("z", theta + (0 if slides else np.degrees(moved)))
            X = X @ shift(a, 0, d + (1e3 * moved if slides else 0)) @ turn("x", alpha) @ turn("y", beta)
            assert max(abs(d), abs(a)) < 8000  # 500 m without Hayati's fifth column
        X = X @ placed(ends[1])
        assert np.abs(X[:3, 3] - where.p[-1, i]).max() < 1e-9
        assert np.abs(X[:3, :3] - where.R[-1, i]).max() < 1e-9
    short = [list(row.values())[1:] for row in table(tmp_path / "standard.csv")]
    assert short == [list(row.values())[1:5] for row in rows]
    shifted = [(row["alpha_before_deg"], row["a_before_mm"]) for row in table(tmp_path / "modified.csv")]
    assert shifted == [("0", "0"), *((row["alpha_deg"], row["a_mm"]) for row in rows[:-1])]


def links_of(file):
    """The rows of a kinematics file of Universal Robots, in mm and degrees."""
    links, values = [], {}
    for line in file.read_text(encoding="utf-8").splitlines():
        key, _, value = line.strip().partition(": ")
        if line.startswith("    "):
            values[key] = float(value)
            if key == "yaw":
                lengths = {f"{k}_mm": 1e3 * values[k] for k in "xyz"}
                angles = {f"{k}_deg": np.degrees(values[k]) for k in ("roll", "pitch", "yaw")}
                links.append(lengths | angles)
    return links


def is_the_arm(links, robot, base):
    """Joints by a kinematics file on `base` (4, 4) carry the robot's flange where the robot does."""
    arm = written_as(robot, "ur-kinematics").arm
    q = np.random.default_rng(1).uniform(-2, 2, (3, 6))
    where = frames(arm, q)
    for i in range(3):
        X = base
        for row, moved in zip(links, q[i], strict=True):
            X = X @ placed(row) @ turn("z", np.degrees(moved))
        assert np.abs(X[:3, 3] - where.p[-1, i]).max() < 1e-9
        assert np.abs(X[:3, :3] - where.R[-1, i]).max() < 1e-9


@pytest.mark.parametrize("name", ["ur5", "ur10"])
def test_ur_kinematics_is_the_calibrated_arm(tmp_path, name):
    robot = model(tmp_path, name)
    links = links_of(export(robot, "ur-kinematics", tmp_path).files[0])
    is_the_arm(links, robot, np.eye(4))
    # no link in the file is far from the one that the maker publishes
    assert np.linalg.norm([links[2]["x_mm"], links[2]["y_mm"], links[2]["z_mm"]]) < 700


# x y z [m] roll pitch yaw [rad] of each joint of a UR10e in the link before, as its maker publishes them
UR10E = """
    0 0 0.1807 0 0 0
    0 0 0 1.570796327 0 0
    -0.6127 0 0 0 0 0
    -0.57155 0 0.17415 0 0 0
    0 -0.11985 0 1.570796327 0 0
    0 0.11655 0 1.570796327 3.141592653589793 3.141592653589793
"""


def test_ur_kinematics_of_the_makers_own_description_is_the_makers_own_file(tmp_path):
    """ROS's base_link stands half a turn from the base that the file counts from."""
    joints = [["0", "0", "0", "0", "0", "3.141592653589793"], *map(str.split, UR10E.split("\n")[1:-1])]
    links = ["base_link", "base_link_inertia", *(f"link_{i}" for i in range(1, 7))]
    text = "".join(f'<link name="{link}"/>' for link in links)
    for i, (*xyz, roll, pitch, yaw) in enumerate(joints):
        text += (
            f'<joint name="joint_{i}" type="{"revolute" if i else "fixed"}">'
            f'<parent link="{links[i]}"/><child link="{links[i + 1]}"/><axis xyz="0 0 1"/>'
            f'<origin xyz="{" ".join(xyz)}" rpy="{roll} {pitch} {yaw}"/>'
            '<limit lower="-6" upper="6" effort="300" velocity="2"/></joint>'
        )
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{text}</robot>', encoding="utf-8")
    lines = ["schema = 1", *(f'{key} = "arm"' for key in ("name", "title")), 'urdf = "arm.urdf"']
    lines += ['flange = "link_6"']
    lines += [f'[[joints]]\nname = "joint_{i}"' for i in range(1, 7)]
    (tmp_path / "arm.toml").write_text("\n".join(lines), encoding="utf-8")
    robot = load_robot(tmp_path / "arm.toml")
    written = export(robot, "ur-kinematics", tmp_path / "out")
    links = links_of(written.files[0])
    is_the_arm(links, robot, turn("z", 180.0))
    for row, (x, y, z, *_) in zip(links, joints[1:], strict=True):
        assert [row["x_mm"], row["y_mm"], row["z_mm"]] == pytest.approx(
            [1e3 * float(v) for v in (x, y, z)], abs=1e-6
        )
    assert any("base_link_inertia" in line for line in written.header)


@pytest.mark.parametrize("name", ["kr500", "kr120", "irb120", "rx170"])
def test_opw_is_exact_for_the_nominal_arm_and_says_what_the_calibrated_loses(tmp_path, name):
    nominal = replace(load_robot(name), compensator=None)
    nominal = replace(nominal, joints=tuple(
        replace(joint, data=joint.data.model_copy(update={"stiffness": None})) for joint in nominal.joints
    ))  # fmt: skip
    assert export(nominal, "opw", tmp_path / "nominal").cost.max_mm < 1e-6
    geometry = model(tmp_path, name).geometry
    lost = export(replace(nominal, geometry=geometry), "opw", tmp_path / "calibrated").cost
    assert 0.05 < lost.max_mm < 5.0


@pytest.mark.parametrize(
    ("name", "to"),
    [("ur5", "opw"), ("kr500", "ur-kinematics"), ("cylindrical", "ur-kinematics"), ("kr500", "stl")],
)
def test_what_a_format_cannot_hold_is_refused_and_nothing_is_written(tmp_path, name, to):
    with pytest.raises(InputError):
        export(name, to, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def bare(folder, rename=lambda text: text):
    """An arm whose URDF ends with its last moving link, as many do: that is the flange."""
    toml = write_random_robot(folder, 5, "6R")
    urdf = toml.with_suffix(".urdf")
    text = urdf.read_text()
    urdf.write_text(rename(text[: text.index('<joint name="flange_joint"')] + "</robot>"))
    toml.write_text(rename(toml.read_text()).replace('flange = "flange"', 'flange = "link_6"'))
    return load_robot(toml)


@pytest.mark.parametrize("to", ["urdf", "sdf", "drake", "mjcf"])
def test_the_last_moving_link_may_be_the_flange(tmp_path, to):
    robot = bare(tmp_path)
    files = export(robot, to, tmp_path / "out", conditions=LOAD).files
    (file,) = (
        one for one in files if one.suffix in (".urdf", ".sdf") or (to, one.suffix) == ("mjcf", ".xml")
    )
    content = content_of(robot, None, LOAD)
    q = content.problem.q[0]
    wanted = frames(content.arm, q[None]).p[-1, 0]
    if to == "mjcf":
        m = mujoco.MjModel.from_xml_path(str(file))
        data = mujoco.MjData(m)
        for joint, angle in zip(robot.joint_names, q, strict=True):
            data.joint(joint).qpos = angle
        mujoco.mj_forward(m, data)
        place, mass = data.body(robot.flange).xpos, m.body_mass.sum()
    else:
        plant, context = drakes(file)
        for joint, angle in zip(robot.joint_names, q, strict=True):
            plant.GetJointByName(joint).set_angle(context, angle)
        place = flange_of(robot, plant, context).translation()
        mass = plant.CalcTotalMass(context)
    assert np.abs(place - wanted).max() < 1e-9
    assert mass == pytest.approx(
        content.arm.mass.sum() + (0.0 if to == "urdf" else content.payload[0]), rel=1e-6
    )


@pytest.mark.parametrize("to", ["sdf", "drake"])
def test_names_that_sdf_does_not_tell_apart_are_refused(tmp_path, to):
    robot = bare(tmp_path, lambda text: text.replace("joint_3", "link_3"))
    with pytest.raises(InputError, match=r"a link and a joint are both called link_3; .* rename one"):
        export(robot, to, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_header_weighs_what_is_left_out(tmp_path):
    """An effect that a format does not know costs what the flange moves without it."""
    ratio = EffectRecord(cause="gear_ratio", joint="joint_1", values={"relative": 1e-3})
    robot = replace(load_robot("cylindrical"), effects=(ratio,))
    written = export(robot, "urdf", tmp_path)
    (item,) = (item for item in written.cost.items if "gear_ratio" in item.what)
    content = content_of(robot, None, Conditions())
    q, reach = content.problem.q, np.linalg.norm(frames(content.arm, content.problem.q).p[-1, :, :2], axis=1)
    assert not item.carried
    assert item.max_mm == pytest.approx(1e3 * np.abs(2 * reach * np.sin(5e-4 * q[:, 0])).max(), rel=1e-3)
    assert str(item) in (tmp_path / "cylindrical.urdf").read_text(encoding="utf-8")


def test_the_header_says_how_far_the_flange_is_turned(tmp_path):
    """By Pinocchio on the file: a long tool is off by that as well, beside the flange's millimetres."""
    soft = EffectRecord(cause="joint_compliance", joint="shoulder_lift_joint", values={"compliance": 2.5e-5})
    robot = model(tmp_path, "ur10", (soft,))
    written = export(robot, "urdf", tmp_path, conditions=LOAD)
    content = content_of(robot, None, LOAD)
    other = pinocchio.buildModelFromUrdf(str(written.files[0]))
    data, tool = other.createData(), other.getFrameId(robot.flange)
    turns = []
    for q, R in zip(content.problem.q, content.flange(content.extended.acting)[1], strict=True):
        pinocchio.framesForwardKinematics(other, data, q)
        turns.append(1e3 * np.linalg.norm(pinocchio.log3(data.oMf[tool].rotation @ R.T)))
    cost = written.cost
    assert cost.turn_mean_mrad == pytest.approx(np.mean(turns), rel=1e-6)
    assert cost.turn_max_mrad == pytest.approx(max(turns), rel=1e-6)
    assert cost.turn_max_mrad > 1.0
    assert f"turned against it: {cost.turn_mean_mrad:.3f} mrad on average" in written.files[0].read_text()


def test_springs_that_move_nothing_are_left_out(tmp_path):
    """They would ask for steps of microseconds."""
    stiff = EffectRecord(cause="bearing_tilt", joint="joint_5", values={"compliance": 1e-14})
    written = export(model(tmp_path, "kr500", (*YIELDS, stiff)), "sdf", tmp_path / "out")
    tilts = {item.what: item for item in written.cost.items if "bearing_tilt" in item.what}
    assert tilts["bearing_tilt(joint_2)"].carried
    assert not tilts["bearing_tilt(joint_5)"].carried
    assert tilts["bearing_tilt(joint_5)"].max_mm < 1e-3


def test_a_robot_of_which_nothing_was_identified_is_written_as_it_is(tmp_path):
    robot = load_robot("kr500")
    assert not written_as(robot, "urdf", LOAD).arm.geometry.any()
    assert "geometry, nominal" in str(export(robot, "urdf", tmp_path).cost.items[0])


GEARS = (
    EffectRecord(cause="gear_ratio", joint="joint_1", values={"relative": 2e-4}),
    EffectRecord(cause="gear_eccentricity", joint="joint_3", values={"sin": 1e-4, "cos": 5e-5}),
    EffectRecord(
        cause="gear_kinematic_error", joint="joint_4", order=200.0, values={"sin": 1e-4, "cos": 0.0}
    ),
    EffectRecord(cause="wrist_coupling", joint="joint_6", other="joint_5", values={"coupling": 3e-4}),
    EffectRecord(cause="hose_torque", joint="joint_5", values={"rate": 20.0}),
)
EFFECTS = (
    *YIELDS,
    *GEARS,
    EffectRecord(cause="gravity_compensator", variant="charge", values={"relative": -0.1}),
    EffectRecord(cause="gravity_compensator", variant="preload", values={"preload": 400.0}),
)
GAS = EffectRecord(cause="gravity_compensator", variant="exponent", values={"exponent": 0.15})


@pytest.mark.parametrize(("to", "count", "share"), [("urdf", 0, 0.6), ("sdf", 2, 0.9)])
def test_the_geometry_makes_up_for_what_is_left_out_in_other_poses_too(tmp_path, to, count, share):
    """Poses of another draw; a URDF lacks the springs, an SDF two errors of gears."""
    robot = model(tmp_path, "kr500", (*YIELDS, *GEARS[:count]))
    fitted = written_as(robot, to, LOAD).arm.geometry
    q = random_poses(robot, 60, np.random.default_rng(4))
    there = content_of(robot, planned(robot, q), LOAD)
    whole, kept = there.flange(there.extended.acting)[0], kept_of(there, FORMATS[to].carries)
    before, after = (
        np.linalg.norm(kept.flange(content)[0] - whole, axis=1).mean()
        for content in (there, there.with_geometry(fitted))
    )
    assert after < share * before


def package(folder):
    """The module of an exported package, loaded as a user's would be."""
    name, init = f"of_{folder.name}_{len(sys.modules)}", folder / "extended_robot" / "__init__.py"
    spec = importlib.util.spec_from_file_location(name, init)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def test_the_drake_package_needs_drake_and_numpy_alone():
    known = {"__future__", "collections", "dataclasses", "math", "pathlib", "typing", "numpy", "pydrake"}
    for file in MODULE.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert node.level == 1 or (node.level == 0 and str(node.module).split(".")[0] in known)
            elif isinstance(node, ast.Import):
                assert {alias.name.split(".")[0] for alias in node.names} <= known


@pytest.mark.parametrize("name", ["kr500", "rx170", "longlink", "cylindrical", "irb120"])
def test_the_drake_package_rests_where_the_whole_model_does(tmp_path, name):
    """The last without any spring: errors of gears that no spring stands behind."""
    known = set(load_robot(name).joint_names)
    effects = {"kr500": (*EFFECTS, GAS), "rx170": EFFECTS, "irb120": GEARS}.get(name, YIELDS)
    effects = tuple(e for e in effects if e.other is None or e.other in known)
    robot = model(tmp_path, name, effects)
    written = export(robot, "drake", tmp_path, conditions=LOAD)
    assert not any("gear" in item.what for item in written.cost.items if not item.carried)
    content = content_of(robot, None, LOAD)
    off = by_hinges(content)
    assert written.cost.max_mm == pytest.approx(1e3 * np.linalg.norm(off, axis=1).max(), abs=1e-9)
    whole = content.flange(content.extended.acting)[0]
    module, builder = package(tmp_path), DiagramBuilder()
    added = module.AddExtendedRobot(builder)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    own = added.GetMyMutableContextFromRoot(context)
    far = []
    for q, there in zip(joints(content), whole + off if name == "longlink" else whole, strict=False):
        module.Settle(added, context, q)
        desired = np.concatenate([q, np.zeros_like(q)])
        added.GetInputPort("desired_state").FixValue(own, desired)
        X = added.GetOutputPort("tool_pose").Eval(own)
        far.append(np.abs(X.translation() - there).max())
        assert added.GetOutputPort("state").Eval(own) == pytest.approx(desired, abs=1e-15)
    assert max(far) < 1e-9


def test_the_drake_package_follows_its_command_in_a_users_diagram(tmp_path):
    """At rest it stays; told to move, its drives do."""
    export(replace(load_robot("kr500"), effects=EFFECTS), "drake", tmp_path)
    module, builder = package(tmp_path), DiagramBuilder()
    robot = module.AddExtendedRobot(builder)
    builder.ExportInput(robot.GetInputPort("desired_state"), "desired_state")
    builder.ExportOutput(robot.GetOutputPort("tool_pose"), "tool_pose")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    q = np.array([0.3, -1.0, 1.2, 0.4, 0.7, 0.2])
    module.Settle(robot, context, q)
    diagram.GetInputPort("desired_state").FixValue(context, np.concatenate([q, np.zeros(6)]))
    simulator = Simulator(diagram, context)
    ApplySimulatorConfig(SimulatorConfig(integration_scheme="runge_kutta3", accuracy=1e-4), simulator)
    before = diagram.GetOutputPort("tool_pose").Eval(context).translation().copy()
    simulator.AdvanceTo(0.02)
    assert np.abs(diagram.GetOutputPort("tool_pose").Eval(context).translation() - before).max() < 1e-7
    diagram.GetInputPort("desired_state").FixValue(context, np.concatenate([q + 0.01, np.zeros(6)]))
    simulator.AdvanceTo(0.22)
    state = robot.GetOutputPort("state").Eval(robot.GetMyContextFromRoot(context))
    assert np.abs(state[:6] - q - 0.01).max() < 1e-3


def test_a_urdf_with_drives_beside_its_joints_is_written(tmp_path):
    """ROS descriptions name their joints again in <transmission> and <ros2_control>."""
    robot = bare(tmp_path)
    drive = '<transmission name="t"><joint name="joint_2"><hardwareInterface/></joint></transmission></robot>'
    robot.urdf.write_text(robot.urdf.read_text().replace("</robot>", drive))
    (file,) = export(robot, "urdf", tmp_path / "out", conditions=LOAD).files
    assert "<hardwareInterface" in file.read_text()
    assert "tool and payload, 45 kg, are not in the file" in file.read_text()


def test_the_campaign_of_another_robot_weighs_nothing(tmp_path):
    other = planned(load_robot("kr120"), np.zeros((3, 6)))
    with pytest.raises(InputError, match="is of kr120, which is not the robot of"):
        export("kr500", "urdf", tmp_path / "out", campaign=other)


def test_mjcf_stands_still_at_the_step_that_it_asks_for(tmp_path):
    """Held where it rests, with a wrist spring disturbed: at MuJoCo's own 2 ms it flies apart."""
    robot = model(tmp_path, "6R")
    (file,) = export(robot, "mjcf", tmp_path / "out", conditions=LOAD).files
    m = mujoco.MjModel.from_xml_path(str(file))
    assert m.opt.timestep == 5e-4
    data = mujoco.MjData(m)
    data.qpos[-1] = 1e-5
    for _ in range(400):
        mujoco.mj_forward(m, data)
        data.ctrl[:] = [data.qfrc_bias[m.jnt_dofadr[m.actuator_trnid[k, 0]]] for k in range(m.nu)]
        mujoco.mj_step(m, data)
    assert data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number == 0  # and it would have begun anew
    assert 0 < np.abs(data.qpos).max() < 0.1

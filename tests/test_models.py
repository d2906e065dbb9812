"""The robots that come with the workbench: they load, and move as their tables say."""

import base64
import importlib
import json
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams, MeshcatVisualizer
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import JointIndex
from pydrake.systems.framework import DiagramBuilder

from workbench.robot.description import load_robot
from workbench.robot.find import list_robots

MODELS = Path(__file__).resolve().parents[1] / "models"
sys.path.insert(0, str(MODELS))
make_models = importlib.import_module("make_models")
NAMES = [design.name for design in make_models.DESIGNS]
FIRST = ("kr500", "ur5", "rx170", "cylindrical")  # made again: gas, none, a coil, slides

SIN, COS = 0.258819, 0.965926  # the MA1400's lean of 15 degrees, as its data sheet prints it

# Axes at q = 0 as stated with the measured data: direction at point, mm; then the flange: origin, x, z.
STATED = {
    "ur5": (
        [
            ((0, 0, 1), (0, 0, 0)),
            ((0, -1, 0), (0, 0, 89.159)),
            ((0, -1, 0), (-425, 0, 89.159)),
            ((0, -1, 0), (-817.25, 0, 89.159)),
            ((0, 0, -1), (-817.25, -109.15, 89.159)),
            ((0, -1, 0), (-817.25, -109.15, -5.491)),
        ],
        ((-817.25, -191.45, -5.491), (1, 0, 0), (0, -1, 0)),
    ),
    "ur10": (
        [
            ((0, 0, 1), (0, 0, 0)),
            ((0, -1, 0), (0, 0, 127.3)),
            ((0, -1, 0), (-612, 0, 127.3)),
            ((0, -1, 0), (-1184.3, 0, 127.3)),
            ((0, 0, -1), (-1184.3, -163.941, 127.3)),
            ((0, -1, 0), (-1184.3, -163.941, 11.6)),
        ],
        ((-1184.3, -256.141, 11.6), (1, 0, 0), (0, -1, 0)),
    ),
    "irb120": (
        [
            ((0, 0, 1), (0, 0, 0)),
            ((0, 1, 0), (0, 0, 290)),
            ((0, 1, 0), (0, 0, 560)),
            ((1, 0, 0), (0, 0, 630)),
            ((0, 1, 0), (302, 0, 630)),
            ((1, 0, 0), (302, 0, 630)),
        ],
        ((374, 0, 630), (0, 0, -1), (1, 0, 0)),
    ),
    "iiwa7": (
        [
            ((0, 0, 1), (0, 0, 0)),
            ((0, 1, 0), (0, 0, 340)),
            ((0, 0, 1), (0, 0, 340)),
            ((0, -1, 0), (0, 0, 740)),
            ((0, 0, 1), (0, 0, 740)),
            ((0, 1, 0), (0, 0, 1140)),
            ((0, 0, 1), (0, 0, 1140)),
        ],
        ((0, 0, 1266), (1, 0, 0), (0, 0, 1)),
    ),
    "ma1400-right": (
        [
            ((-SIN, 0, COS), (0, 0, -263)),
            ((COS, 0, SIN), (-366.462, -150, 1104.65)),
            ((-COS, 0, -SIN), (-525.377, -150, 1697.73)),
            ((0, 1, 0), (-577.141, -150, 1890.92)),
            ((-COS, 0, -SIN), (-577.141, -790, 1890.92)),
            ((SIN, 0, -COS), (-577.141, -820, 1890.92)),
        ],
        ((-525.377, -820, 1697.73), (0, -1, 0), (SIN, 0, -COS)),
    ),
    "ma1400-left": (
        [
            ((SIN, 0, COS), (0, 0, -263)),
            ((COS, 0, -SIN), (366.462, -150, 1104.65)),
            ((-COS, 0, SIN), (525.377, -150, 1697.73)),
            ((0, 1, 0), (577.141, -150, 1890.92)),
            ((-COS, 0, SIN), (577.141, -790, 1890.92)),
            ((-SIN, 0, -COS), (577.141, -820, 1890.92)),
        ],
        ((525.377, -820, 1697.73), (0, -1, 0), (-SIN, 0, -COS)),
    ),
}


def plant_of(name):
    """The plant of a robot, parsed strictly: a warning of the parser is an error."""
    plant = MultibodyPlant(0.0)
    parser = Parser(plant)
    parser.SetStrictParsing()
    parser.AddModels(str(load_robot(name).urdf))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base_link"))
    plant.Finalize()
    return plant, plant.CreateDefaultContext()


def pose(plant, context, frame, q):
    plant.SetPositions(context, q)
    return plant.GetFrameByName(frame).CalcPoseInWorld(context).GetAsMatrix4()


def torque(plant, context, q):
    """Gravity's generalized force [N·m]."""
    plant.SetPositions(context, q)
    return plant.CalcGravityGeneralizedForces(context)


def moving_joints(plant):
    joints = [plant.get_joint(JointIndex(i)) for i in range(plant.num_joints())]
    return [joint for joint in joints if joint.num_positions() == 1]


def test_every_robot_of_the_folder_is_made_here():
    assert {path.stem for path in list_robots()} == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_loads(name):
    robot = load_robot(name)
    plant, _ = plant_of(name)
    assert robot.name == name
    assert robot.links == tuple(f"link_{i + 1}" for i in range(len(robot.joints)))
    assert [joint.name() for joint in moving_joints(plant)] == list(robot.joint_names)
    assert all(np.isfinite([joint.lower, joint.upper, joint.velocity]).all() for joint in robot.joints)
    assert all(plant.GetBodyByName(link).default_mass() > 0 for link in robot.links)
    for link in robot.links:
        inertia = plant.GetBodyByName(link).default_spatial_inertia()
        assert inertia.IsPhysicallyValid()


@pytest.mark.parametrize("name", NAMES)
def test_states_where_its_numbers_come_from(name):
    data = tomllib.loads((MODELS / name / f"{name}.toml").read_text())
    assert {"kinematics", "masses", "limits"} <= set(data["source"])
    given = {key for joint in data.get("joints", []) for key in joint} - {"name"}
    assert given <= set(data["source"])


@pytest.mark.parametrize("name", STATED)
def test_axes_and_flange_stand_where_they_are_stated(name):
    axes, (origin, x, z) = STATED[name]
    plant, context = plant_of(name)
    q = np.zeros(plant.num_positions())
    for joint, (direction, point) in zip(moving_joints(plant), axes, strict=True):
        X = pose(plant, context, joint.frame_on_child().name(), q)
        np.testing.assert_allclose(X[:3, :3] @ joint.revolute_axis(), direction, atol=1e-6)
        np.testing.assert_allclose(X[:3, 3] * 1000, point, atol=6e-3)
    X = pose(plant, context, "flange", q)
    np.testing.assert_allclose(X[:3, 3] * 1000, origin, atol=6e-3)
    np.testing.assert_allclose(X[:3, 0], x, atol=1e-6)
    np.testing.assert_allclose(X[:3, 2], z, atol=1e-6)


def tables():
    for name in ("kr500", "ur5", "ur10", "irb120", "iiwa7", "rx170", "longlink"):
        yield name, importlib.import_module(f"generator.robots.{name}").KINEMATICS
    for side, table in importlib.import_module("generator.robots.ma1400").KINEMATICS.items():
        yield f"ma1400-{side}", table


@pytest.mark.parametrize(("name", "table"), list(tables()), ids=lambda value: str(value)[:12])
def test_drake_moves_the_flange_as_the_table_says(name, table):
    plant, context = plant_of(name)
    rng = np.random.default_rng(1)
    for q in rng.uniform(-3, 3, (50, plant.num_positions())):
        np.testing.assert_allclose(pose(plant, context, "flange", q), table.frames(q)[-1], atol=1e-9)


def test_cylindrical_moves_as_its_paper_says():
    plant, context = plant_of("cylindrical")
    q1, q2, q3 = 0.7, 0.2, 0.35
    X = pose(plant, context, "flange", [q1, q2, q3])
    reach = 0.5 + q3
    np.testing.assert_allclose(X[:3, 3], [reach * np.cos(q1), reach * np.sin(q1), 0.5 + q2], atol=1e-12)


def test_kr120_turns_as_the_controller_does():
    plant, context = plant_of("kr120")
    home = np.radians([0, -90, 90, 0, 0, 0])
    np.testing.assert_allclose(pose(plant, context, "flange", home)[:3, 3], [1.565, 0, 1.784], atol=1e-9)
    turned = pose(plant, context, "flange", home + 0.1 * np.eye(6)[0])
    assert turned[1, 3] < 0, "A1 counts clockwise seen from above"


@pytest.mark.parametrize("name", ["kr500", "kr120"])
def test_masses_stand_where_their_own_table_puts_them(name):
    module = importlib.import_module(f"generator.robots.{name}")
    plant, context = plant_of(name)
    home = np.radians([0, -90, 90, 0, 0, 0])
    for i, X in enumerate(module.MASS_FRAMES.frames()[1:]):
        body = plant.GetBodyByName(f"link_{i + 1}")
        plant.SetPositions(context, home)
        com = body.EvalPoseInWorld(context) @ body.CalcCenterOfMassInBodyFrame(context)
        stated = X[:3, :3] @ np.array(module.LINKS[i].com) / 1000 + X[:3, 3]
        np.testing.assert_allclose(com, stated, atol=1e-9)


def pivots_apart(name, q2):
    """Distance of the compensator's pivots [m] and its derivative by q2."""
    plant, context = plant_of(name)
    data = load_robot(name).compensator

    def distance(angle):
        q = np.zeros(6)
        q[1] = angle
        ends = [
            pose(plant, context, link, q) @ [*pivot, 1]
            for link, pivot in ((data.body, data.body_pivot), (data.arm, data.arm_pivot))
        ]
        return np.linalg.norm(ends[0] - ends[1])

    return distance(q2), (distance(q2 + 1e-6) - distance(q2 - 1e-6)) / 2e-6


@pytest.mark.parametrize("name", ["kr500", "kr120"])
def test_gas_compensator_has_the_geometry_of_the_kr210(name):
    for degrees, stated in ((-90, 0.603), (0, 0.834), (35, 0.937)):
        assert pivots_apart(name, np.radians(degrees))[0] == pytest.approx(stated, abs=6e-4)
    assert pivots_apart(name, np.radians(-91.9))[0] == pytest.approx(
        load_robot(name).compensator.reference, abs=2e-4
    )


@pytest.mark.parametrize(("name", "rated"), [("kr500", 500.0), ("kr120", 120.0)])
def test_gas_compensator_lifts_the_leaning_arm(name, rated):
    """Never more than the arm weighs with its rated load; the charge is one measured on another robot."""
    plant, context = plant_of(name)
    data = load_robot(name).compensator
    for degrees in (-40, 0, 20):
        s, slope = pivots_apart(name, np.radians(degrees))
        pressure = data.precharge * data.gas_length / (data.gas_length - (s - data.reference))
        lift = -data.piston_area * (pressure - 101325) * slope
        gravity = torque(plant, context, [0, np.radians(degrees), 0, 0, 0, 0])[1]
        flange = plant.GetFrameByName("flange").CalcPoseInWorld(context).translation()
        shoulder = plant.GetJointByName("joint_2").frame_on_parent().CalcPoseInWorld(context).translation()
        load = 9.80665 * rated * (flange - shoulder)[0]
        assert gravity > 0 > lift
        assert 0.3 < -lift / (gravity + load) < 1
        if rated and degrees == 0:
            assert 0.85 < -lift / gravity < 1.05


def test_spring_of_the_rx170_leaves_a_little_of_the_gravity_torque():
    plant, context = plant_of("rx170")
    data = load_robot("rx170").compensator
    for degrees in (-50, -30, 30, 50):
        s, slope = pivots_apart("rx170", np.radians(degrees))
        gravity = torque(plant, context, [0, np.radians(degrees), 0, 0, 0, 0])[1]
        left = gravity - data.rate * (s - data.free_length) * slope
        assert 140 < abs(left) < 300
        assert left * degrees > 0


@pytest.mark.parametrize("name", NAMES)
def test_every_link_is_drawn(name):
    for link in ("base_link", *load_robot(name).links):
        content = json.loads((MODELS / name / f"{link}.gltf").read_text())
        uri = content["buffers"][0]["uri"]
        blob = base64.b64decode(uri.split(",")[1])
        assert len(blob) == content["buffers"][0]["byteLength"]
        for primitive in content["meshes"][0]["primitives"]:
            views = [content["bufferViews"][content["accessors"][i]["bufferView"]] for i in
                     (primitive["attributes"]["NORMAL"], primitive["indices"])]  # fmt: skip
            normal, index = (blob[v["byteOffset"] : v["byteOffset"] + v["byteLength"]] for v in views)
            lengths = np.linalg.norm(np.frombuffer(normal, "<f4").reshape(-1, 3), axis=1)
            np.testing.assert_allclose(lengths, 1, atol=1e-5)
            assert np.frombuffer(index, "<u2").max() == len(lengths) - 1


def test_shapes_show_in_meshcat():
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    Parser(plant).AddModels(str(load_robot("kr500").urdf))
    plant.Finalize()
    meshcat = Meshcat(MeshcatParams(port=0, show_stats_plot=False))
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    diagram.ForcedPublish(diagram.CreateDefaultContext())
    assert len(meshcat.StaticHtml()) > 2_000_000 + 280_000


@pytest.mark.parametrize(
    "name", [name if name in FIRST else pytest.param(name, marks=pytest.mark.slow) for name in NAMES]
)
def test_made_again_the_files_are_the_same_to_the_byte(tmp_path, name):
    make_models.main([name], tmp_path)
    made = {path.name: path.read_bytes() for path in (tmp_path / name).iterdir()}
    kept = {path.name: path.read_bytes() for path in (MODELS / name).iterdir()}
    assert made.keys() == kept.keys()
    assert [file for file in made if made[file] != kept[file]] == []


@pytest.mark.parametrize("name", NAMES)
def test_the_files_are_small_and_name_nothing_elsewhere(name):
    kept = {path.name: path.read_bytes() for path in (MODELS / name).iterdir()}
    assert sum(len(data) for data in kept.values()) < 300_000
    assert not any(word in kept[f"{name}.urdf"] for word in (b"://", b"<collision", b'filename="/'))

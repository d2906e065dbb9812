"""All Drake plants of a robot have the same links, in the same places, with the same masses."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.framework import DiagramBuilder

from workbench.correction.conditions import Conditions
from workbench.correction.paths import Path
from workbench.report.meshcat_page import draw_robot, meshcat_alone
from workbench.robot.compensator import compensator_law
from workbench.robot.cylinder import NAMES
from workbench.robot.description import load_robot
from workbench.robot.elastic_plant import elastic_twin
from workbench.robot.kinematics import frames
from workbench.robot.loads import Loads
from workbench.robot.picture import picture
from workbench.robot.plants import rigid_arm_plant
from workbench.robot.rigid_plant import arrays, link_poses, rigid_twin
from workbench.robot.schema import EffectRecord
from workbench.simulation.closed_loop.drives import drives
from workbench.simulation.closed_loop.machine import machine
from workbench.simulation.closed_loop.mechanics import mechanics
from workbench.simulation.random_robot import write_random_robot

KINDS = ["6R", "7R", "PRRR", "kr500", "cylindrical", "ma1400-left"]


def some_robot(folder, kind):
    return load_robot(write_random_robot(folder, 5, kind) if kind[-1] == "R" else kind)


def drives_alone(grown, names):
    """A Context in which only these joints have moved, to 0.1, 0.2, ... in their order."""
    context = grown.plant.CreateDefaultContext()
    positions = np.zeros(grown.plant.num_positions())
    for i, name in enumerate(names):
        positions[grown.plant.GetJointByName(name).position_start()] = 0.1 * (i + 1)
    grown.plant.SetPositions(context, positions)
    return context


@pytest.mark.parametrize("kind", KINDS)
def test_all_plants_have_the_links_of_the_urdf(tmp_path, kind):
    robot = some_robot(tmp_path, kind)
    arm, twin = arrays(robot), rigid_twin(robot)
    q = 0.1 * np.arange(1, arm.n + 1)
    twin.set_positions(q)
    flange = twin.plant.GetFrameByName(robot.flange).CalcPoseInWorld(twin.context)
    still = Path(np.array([0.0, 1.0]), q=np.tile(q, (2, 1)))
    true = mechanics(robot, still, still.q, Conditions())
    plants = {
        "rigid": (rigid_arm_plant(arm), robot.joint_names),
        "elastic": (elastic_twin(arm, robot).built, [f"{name}_motor" for name in robot.joint_names]),
        "closed loop": (machine(true, drives(true, q, robot.loop)).built, robot.joint_names),
    }
    for grown, joints in plants.values():
        context = drives_alone(grown, joints)
        for name in (robot.base, *robot.links):
            body, parsed = grown.plant.GetBodyByName(name), twin.plant.GetBodyByName(name)
            X = body.EvalPoseInWorld(context)
            assert X.IsNearlyEqualTo(parsed.EvalPoseInWorld(twin.context), 1e-12)
            inertia = body.default_spatial_inertia()
            assert inertia.get_mass() == pytest.approx(parsed.default_mass(), rel=1e-12)
            M, M_parsed = (i.CopyToFullMatrix6() for i in (inertia, parsed.default_spatial_inertia()))
            assert np.abs(M - M_parsed).max() <= 1e-12 * max(np.abs(M_parsed).max(), 1.0)
        assert grown.slots[-1].CalcPoseInWorld(context).IsNearlyEqualTo(flange, 1e-12)
        others = {body.name() for body in grown.bodies} - {robot.base, *robot.links}
        assert others == {"tool and payload"}
        mass = grown.plant.CalcTotalMass(context)
        assert mass == pytest.approx(twin.plant.CalcTotalMass(twin.context), rel=1e-12)


def test_the_picture_shows_the_rigid_twin():
    robot, q = load_robot("kr500"), np.array([0.3, -1.0, 1.2, 0.4, 0.7, 0.2])
    twin = rigid_twin(robot)
    twin.set_positions(q)
    with meshcat_alone() as meshcat:
        drawn = draw_robot(meshcat, robot, q, "robot")
    places = [
        twin.plant.GetBodyByName(name).EvalPoseInWorld(twin.context).translation()
        for name in (robot.base, *robot.links)
    ]
    np.testing.assert_allclose(drawn, places, atol=1e-12)


@pytest.mark.parametrize("kind", ["6R", "PRRR"])
def test_springs_hold_the_elastic_twin(tmp_path, kind):
    """Where the arm rests by its compliance, Drake's springs and gravity leave no torque."""
    robot = some_robot(tmp_path, kind)
    arm = arrays(robot)
    arm = replace(arm, geometry=1e-3 * np.ones_like(arm.geometry))
    twin = elastic_twin(arm, robot)
    zero = np.zeros((1, 6))
    loads = Loads(np.array([20.0]), np.array([[1.0, 2.0, 3.0]]), zero, np.zeros((1, arm.n)))
    twin.equilibrium(0.4 * np.ones(arm.n), np.zeros((arm.slots, 6)), loads)
    forces = MultibodyForces(twin.plant)
    twin.plant.CalcForceElementsContribution(twin.context, forces)
    weight = twin.plant.CalcGravityGeneralizedForces(twin.context)
    for slot, name in enumerate(robot.joint_names, start=1):
        joint = twin.plant.GetJointByName(twin.joints[slot, arm.axial[slot - 1] % 6])
        place = joint.velocity_start()
        sprung = forces.generalized_forces()[place]
        assert abs(weight[place]) > 1e-3 or name == "joint_1"
        assert sprung == pytest.approx(-weight[place], abs=1e-9 * np.abs(weight).max())


@pytest.mark.parametrize("name", ["kr500", "kr120", "rx170"])
def test_the_compensator_is_drawn_between_its_pivots(name):
    """Cylinder and rod sit on the pivots of the force law, point at each other, and turn with joint 2."""
    robot = load_robot(name)
    arm = arrays(robot)
    law = compensator_law(robot, arm)
    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(builder, 0.0)
    shown = picture(robot, plant)
    diagram = builder.Build()
    context = plant.GetMyMutableContextFromRoot(root := diagram.CreateDefaultContext())
    directions = []
    for second in (robot.joint("joint_2").lower, -0.7, robot.joint("joint_2").upper):
        q = np.full(arm.n, 0.3)
        q[1] = second
        shown.put(context, link_poses(robot, q[None])[0])
        X = [plant.GetBodyByName(body).EvalPoseInWorld(context) for body in NAMES]
        moving, way, s = law.ends(frames(arm, q[None]))
        fixed = moving + way * s[:, None]
        for pose, place, along in ((X[0], fixed[0], -way[0]), (X[1], moving[0], way[0])):
            np.testing.assert_allclose(pose.translation(), place, atol=1e-12)
            np.testing.assert_allclose(pose.rotation().matrix()[:, 2], along, atol=1e-12)
        directions.append(way[0])
    assert np.linalg.norm(directions[0] - directions[-1]) > 0.1
    shapes = scene.model_inspector()
    for body in NAMES:
        frame = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(body).index())
        assert shapes.NumGeometriesForFrame(frame) == 2
    assert root is not None


def test_every_scene_has_the_compensator():
    with meshcat_alone() as meshcat:
        for name, bodies in (("kr500", NAMES), ("rx170", NAMES), ("ur5", ())):
            draw_robot(meshcat, load_robot(name), np.zeros(6), f"/{name}")
            drawn = [body for body in NAMES if meshcat.HasPath(f"/{name}/{name}/{body}")]
            assert drawn == list(bodies)


@pytest.mark.parametrize("name", ["kr500", "rx170"])
def test_the_loops_plant_has_the_springs_dampers_and_rotors_that_are_stated(name):
    """By Drake's own forces and mass matrix: −K e − C ė at each spring, the reflected rotor at each motor."""
    robot = load_robot(name)
    tilts = EffectRecord(cause="bearing_tilt", joint="joint_2", values={"compliance": 2e-8})
    robot = replace(robot, effects=(tilts,))
    still = Path(np.array([0.0, 1.0]), q=np.full((2, 6), 0.3))
    light = replace(mechanics(robot, still, still.q, Conditions()), compensator=None)
    light = replace(light, arm=replace(light.arm, gravity=np.zeros(3)))
    drive = drives(light, still.q[0], robot.loop)
    built = machine(light, drive)
    plant, context, forces = built.plant, built.plant.CreateDefaultContext(), MultibodyForces(built.plant)
    size = plant.num_velocities()
    stiffness = [1 / law.compliance for law in light.axial] + [1 / 2e-8] * 2
    for i, at in enumerate(built.springs):
        q, v = np.zeros(size), np.zeros(size)
        q[at], v[at] = 1e-3, 2e-3
        plant.SetPositionsAndVelocities(context, np.concatenate([q, v]))
        plant.CalcForceElementsContribution(context, forces)
        felt = plant.CalcGeneralizedForces(context, forces)[at]
        damping = drive.damping[i] if i < 6 else 6e-4 * stiffness[i]
        assert felt == pytest.approx(-1e-3 * stiffness[i] - 2e-3 * damping, rel=1e-9)
    plant.SetPositions(context, np.zeros(size))
    bare = machine(light, replace(drive, rotor=0 * drive.rotor))
    more = plant.CalcMassMatrix(context) - bare.plant.CalcMassMatrix(bare.plant.CreateDefaultContext())
    wanted = np.zeros((size, size))
    wanted[built.motors, built.motors] = [j.data.rotor_inertia * j.data.gear_ratio**2 for j in robot.joints]
    assert more == pytest.approx(wanted, abs=1e-9 * wanted.max())

"""Every element of the elastic twin acts: with one halved, Drake rests elsewhere than the batch says."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.tree import MultibodyForces

from workbench.robot.compensator import compensator_law
from workbench.robot.description import load_robot
from workbench.robot.elastic_plant import elastic_twin
from workbench.robot.equilibrium import equilibrium
from workbench.robot.find import list_robots
from workbench.robot.kinematics import RX, RY, RZ
from workbench.robot.loads import Loads
from workbench.robot.rigid_plant import arrays
from workbench.robot.yielding import Yielding

Q = {"cylindrical": [0.3, 0.2, 0.3], "longlink": [0.3, -0.9, 0.8, 0.4, 0.9, -0.5, 0.3]}
ELEMENTS = [
    *((robot, f"spring {j}") for robot in ("kr500", "rx170") for j in range(1, 7)),
    *(("cylindrical", f"spring {j}") for j in (1, 2, 3)),
    ("kr500", "foundation"), ("kr500", "tilt"), ("kr500", "soft gear"), ("longlink", "bending"),
    ("kr500", "gas"), ("kr500", "preload"), ("kr500", "exponent"), ("rx170", "coil"), ("kr500", "hose"),
    ("kr500", "wrench"), ("kr500", "payload"), ("kr500", "link"),
]  # fmt: skip


def soft(wrench):
    """A soft gear: 0.1 mrad more below 500 N·m."""
    motion, slope = np.zeros_like(wrench), np.zeros((*wrench.shape, 6))
    motion[:, RZ] = 1e-4 * np.tanh(wrench[:, RZ] / 500)
    slope[:, RZ, RZ] = 1e-4 / 500 / np.cosh(wrench[:, RZ] / 500) ** 2
    return motion, slope


def case(name, what=""):
    """Robot, arm, what yields, loads, joints of one pose."""
    robot = load_robot(name)
    arm = arrays(robot)
    linear = arm.compliance.copy()
    linear[0, [RX, RY], [RX, RY]] += 3e-9
    if name != "longlink":
        linear[2, [RX, RY], [RX, RY]] += 2e-8
    yielding = Yielding(linear, ((3, (RZ,), soft),) if what == "soft gear" else ())
    loads = Loads(
        np.array([60.0]), np.array([[3.0, 2.0, 12.0]]), np.array([[90.0, -200.0, 120.0, 30.0, -20.0, 50.0]]),
        np.full((1, arm.n), 25.0), compensator_law(robot, arm),
    )  # fmt: skip
    q = np.array([Q.get(name, [0.3, -1.0, 1.2, 0.4, 0.7, 0.2][: arm.n])]).reshape(1, -1)
    return robot, arm, yielding, loads, q if q.shape[1] == arm.n else np.full((1, arm.n), 0.3)


def rests_apart(twin, arm, yielding, loads, q, drakes=None):
    """How far Drake's tool point is from that of the batch arithmetic [m]."""
    still = np.zeros((1, arm.slots, 6))
    where = equilibrium(arm, q, still, loads, yielding.motion)[1]
    twin.equilibrium(q[0], still[0], drakes or loads)
    tool = np.array([[0.1, 0.2, 0.3]])
    on = [arm.n + 1]
    return float(np.linalg.norm(twin.points(tool, on)[0] - where.points(tool, on)[0, 0]))


@pytest.mark.parametrize("name", list_robots())
def test_drake_rests_where_the_batch_does(name):
    robot, arm, yielding, loads, q = case(name)
    twin = elastic_twin(arm, robot, yielding, compensator=loads.compensator)
    assert rests_apart(twin, arm, yielding, loads, q) < 1e-11


@pytest.mark.parametrize(("name", "what"), ELEMENTS)
def test_half_of_an_element_is_seen(name, what, monkeypatch):
    robot, arm, yielding, loads, q = case(name, what)
    drakes, springs, law = loads, yielding, loads.compensator
    kind, _, number = what.partition(" ")
    if kind == "spring":
        slot = int(number)
        linear = yielding.linear.copy()
        linear[slot] *= 2.0  # in the plant alone
        springs = replace(yielding, linear=linear)
    elif what in ("foundation", "tilt"):
        linear = yielding.linear.copy()
        slot = {"foundation": 0, "tilt": 2}[what]
        linear[slot, [RX, RY], [RX, RY]] *= 2.0
        springs = replace(yielding, linear=linear)
    elif what in ("coil", "exponent"):
        law = replace(law, charge=0.5) if what == "coil" else law.of_exponent(1.2)
        drakes = replace(loads, compensator=law)
    elif what in ("gas", "preload"):
        halved = {"charge": 0.5} if what == "gas" else {"preload": 500.0}
        drakes = replace(loads, compensator=replace(law, **halved))
    elif what in ("hose", "wrench", "payload"):
        key = {"hose": "torque", "payload": "mass"}.get(what, what)
        drakes = replace(loads, **{key: getattr(loads, key) / 2})
    twin = elastic_twin(arm, robot, springs, compensator=law)
    exact = elastic_twin(arm, robot, yielding, compensator=loads.compensator)
    assert rests_apart(exact, arm, yielding, loads, q) < 1e-11
    if what in ("soft gear", "bending"):
        for spring in twin.laws.springs:
            whole = spring.wrench
            monkeypatch.setattr(spring, "wrench", lambda motion, whole=whole: whole(motion) / 2)
    elif what == "link":
        lighter = replace(arm, mass=arm.mass.copy(), moment=arm.moment.copy())
        lighter.mass[3] /= 2
        lighter.moment[3] /= 2
        twin.set_masses(lighter)
    object.__setattr__(twin, "yielding", yielding)  # the search keeps to the law; the plant decides
    assert rests_apart(twin, arm, yielding, loads, q, drakes) > 1e-7


@pytest.mark.parametrize("name", ["kr500", "rx170"])
def test_another_gas_or_coil_needs_another_twin(name):
    robot, arm, yielding, loads, _ = case(name)
    law = loads.compensator
    twin = elastic_twin(arm, robot, yielding, compensator=law)
    other = law.of_exponent(1.2) if name == "kr500" else replace(law, charge=0.5)
    with pytest.raises(ValueError, match="built with another"):
        twin.set_loads(replace(loads, compensator=other))


def test_without_a_spring_the_arm_finds_no_rest():
    robot, arm, yielding, loads, q = case("kr500")
    twin = elastic_twin(arm, robot, yielding, compensator=loads.compensator)
    twin.springs[2, RZ].SetStiffness(twin.context, 0.0)
    with pytest.raises(ArithmeticError):
        rests_apart(twin, arm, yielding, loads, q)


@pytest.mark.parametrize(("name", "what"), [("kr500", "soft gear"), ("rx170", "")])
def test_at_rest_drake_accelerates_nothing_that_yields(name, what):
    """Drake's own acceleration of the whole diagram, ports and all, with the drives' torques applied."""
    robot, arm, yielding, loads, q = case(name, what)
    twin = elastic_twin(arm, robot, yielding, compensator=loads.compensator)
    twin.equilibrium(q[0], np.zeros((arm.slots, 6)), loads)
    plant, context = twin.plant, twin.context
    force = twin.diagram.GetInputPort("joint_force").Eval(twin.root).copy()
    motors = [plant.GetJointByName(name).velocity_start() for name in twin.motors]
    force[motors] += twin.drive_torque()
    twin.diagram.GetInputPort("joint_force").FixValue(twin.root, force)
    acceleration = plant.get_generalized_acceleration_output_port().Eval(context)
    left = plant.CalcInverseDynamics(context, acceleration, MultibodyForces(plant))
    pull = np.abs(plant.CalcGravityGeneralizedForces(context)).max()
    assert np.abs(left).max() < 1e-6 * pull

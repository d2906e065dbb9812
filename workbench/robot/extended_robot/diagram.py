"""The robot with its drives and effects as one Diagram, and where it rests."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from .effects import Effects

HERE = Path(__file__).resolve().parents[1]


def AddExtendedRobot(builder: DiagramBuilder, folder: Path = HERE) -> Diagram:
    """Adds the robot, its drives and its effects as one diagram, and returns it.

    Input `desired_state` (2n,): positions, then velocities [rad, m] of the n joints. Outputs `state` (2n,)
    of the drives, `tool_pose` of the flange, and `query_object` for a visualizer. `Settle` brings it to rest.
    """
    inner = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(inner, 0.0)
    effects = np.load(folder / "effects.npz")
    name = str(effects["name"])
    parser = Parser(plant)
    parser.package_map().Add(name, folder)
    parser.AddModels(folder / f"{name}.dmd.yaml")
    plant.mutable_gravity_field().set_gravity_vector(effects["gravity"])
    plant.Finalize()
    plant.set_name("plant")
    drives = inner.AddSystem(Effects(plant, effects))
    inner.Connect(plant.get_state_output_port(), drives.GetInputPort("plant_state"))
    inner.Connect(drives.GetOutputPort("force"), plant.get_applied_generalized_force_input_port())
    inner.Connect(drives.GetOutputPort("body_force"), plant.get_applied_spatial_force_input_port())
    inner.ExportInput(drives.GetInputPort("desired_state"), "desired_state")
    for port in ("state", "tool_pose"):
        inner.ExportOutput(drives.GetOutputPort(port), port)
    inner.ExportOutput(scene.get_query_output_port(), "query_object")
    robot = inner.Build()
    robot.set_name(name)
    builder.AddSystem(robot)
    return robot


def Settle(robot: Diagram, context: Context, q: Any) -> None:
    """Puts the robot to rest, its drives at q (n,), under its loads. context: of the whole diagram."""
    plant: Any = robot.GetSubsystemByName("plant")
    effects: Any = robot.GetSubsystemByName("effects")
    own = plant.GetMyMutableContextFromRoot(context)
    positions = np.zeros(plant.num_positions())
    positions[effects.motors], _ = effects.joints(q, np.zeros(len(q)))
    free = np.setdiff1d(np.arange(plant.num_positions()), effects.motors)
    for _ in range(20):
        left = effects.balance(positions)[free]
        slope = np.empty((len(free), len(free)))
        for i, at in enumerate(free):
            there = positions.copy()
            there[at] += 1e-6
            slope[:, i] = (effects.balance(there)[free] - left) / 1e-6
        step = np.linalg.solve(slope, left) if len(free) else left
        positions[free] -= step
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    plant.SetPositions(own, positions)
    plant.SetVelocities(own, np.zeros(plant.num_velocities()))

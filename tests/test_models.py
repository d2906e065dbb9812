"""The robots that come with the workbench: they load, and move as their tables say."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from workbench.robot import load_robot

MODELS = Path(__file__).resolve().parents[1] / "models"
sys.path.insert(0, str(MODELS))
DESIGNS = {design.name: design for design in importlib.import_module("make_models").DESIGNS}


def plant_of(name):
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(load_robot(name).urdf))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base_link"))
    plant.Finalize()
    return plant, plant.CreateDefaultContext()


def flange_pose(plant, context, q):
    plant.SetPositions(context, q)
    return plant.GetFrameByName("flange").CalcPoseInWorld(context).GetAsMatrix4()


@pytest.mark.parametrize("name", ["kr500", "ur5"])
def test_drake_moves_the_flange_as_the_table_says(name):
    table = importlib.import_module(f"generator.robots.{name}").KINEMATICS
    plant, context = plant_of(name)
    rng = np.random.default_rng(1)
    for q in rng.uniform(-3, 3, (50, plant.num_positions())):
        np.testing.assert_allclose(flange_pose(plant, context, q), table.frames(q)[-1], atol=1e-9)

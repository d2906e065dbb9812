"""Robot accuracy workbench: what a robot's simulation gets wrong, why, and the right path all the same.

The names below are the public API. They are imported at first use, so `import workbench` costs nothing.
Some are modules, where names belong together: `charts.curves`, `path_shapes.circle`, `load_pairs.fit_pairs`.
`Array` is a NumPy array of float64.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .campaign import Campaign as Campaign
    from .campaign import Target as Target
    from .campaign import load_campaign as load_campaign
    from .campaign import write_campaign as write_campaign
    from .campaign.arrays import campaign_from_arrays as campaign_from_arrays
    from .campaign.planned import planned as planned
    from .campaign.planned import random_poses as random_poses
    from .campaign.problem import Problem as Problem
    from .campaign.problem import problem as problem
    from .campaign.problem import problem_of as problem_of
    from .cli.study import run_study as run_study
    from .correction import path_shapes as path_shapes
    from .correction.command import Compensation as Compensation
    from .correction.command import compensate as compensate
    from .correction.conditions import Conditions as Conditions
    from .correction.conditions import conditions_of as conditions_of
    from .correction.conditions import stated_conditions as stated_conditions
    from .correction.file import compensate_file as compensate_file
    from .correction.in_place import compensate_program as compensate_program
    from .correction.paths import Path as Path
    from .correction.paths import load_path as load_path
    from .correction.paths import write_path as write_path
    from .correction.trajectory import nominal_joints as nominal_joints
    from .diagnosis.changes import compare as compare
    from .diagnosis.changes.result import Comparison as Comparison
    from .diagnosis.found import Finding as Finding
    from .diagnosis.found import Revealed as Revealed
    from .diagnosis.result import Diagnosis as Diagnosis
    from .diagnosis.run import Outcome as Outcome
    from .diagnosis.run import diagnose as diagnose
    from .effects import catalogue as catalogue
    from .effects.base import Effect as Effect
    from .effects.place import Where as Where
    from .effects.records import parse_effect as parse_effect
    from .effects.records import record as record
    from .files.faults import Fault as Fault
    from .files.faults import InputError as InputError
    from .identification import denavit_hartenberg as denavit_hartenberg
    from .identification.cells import CellModel as CellModel
    from .identification.cells import cells as cells
    from .identification.cells import fit_cells as fit_cells
    from .identification.cells import load_cells as load_cells
    from .identification.cells import two_steps as two_steps
    from .identification.cells import write_cells as write_cells
    from .identification.deflection import deflection as deflection
    from .identification.deflection import deflection_budget as deflection_budget
    from .identification.deflection import places as places
    from .identification.deflection import with_compliance as with_compliance
    from .identification.fit import Fit as Fit
    from .identification.fit import fit as fit
    from .identification.fit import start_state as start_state
    from .identification.gravity_compensator import gas_spring as gas_spring
    from .identification.gravity_compensator import pressure as pressure
    from .identification.gravity_compensator.charge import identify_charge as identify_charge
    from .identification.gravity_compensator.spring_fit import FittedSpring as FittedSpring
    from .identification.gravity_compensator.spring_fit import fit_any_order as fit_any_order
    from .identification.gravity_compensator.spring_fit import fit_spring as fit_spring
    from .identification.model import Model as Model
    from .identification.model_file import loaded as loaded
    from .identification.model_file import write_fit as write_fit
    from .identification.model_file import write_model as write_model
    from .identification.noise import Covariance as Covariance
    from .identification.own_base import own_base as own_base
    from .identification.prediction import ToolErrors as ToolErrors
    from .identification.prediction import predict as predict
    from .identification.restated import restated as restated
    from .identification.restated import stored as stored
    from .measurement import axis_by_axis as axis_by_axis
    from .measurement import load_pairs as load_pairs
    from .measurement import sweep as sweep
    from .measurement import zeros_and_offsets as zeros_and_offsets
    from .measurement.axis_by_axis import LocalStiffness as LocalStiffness
    from .measurement.circle_points import Axes as Axes
    from .measurement.circle_points import axes_of as axes_of
    from .measurement.circle_points import fit_circle as fit_circle
    from .measurement.circle_points import link_between as link_between
    from .measurement.circle_points import sweeps as sweeps
    from .measurement.circle_points import turning_ratio as turning_ratio
    from .measurement.design import exchange as exchange
    from .measurement.design import follow_up as follow_up
    from .measurement.design import plan as plan
    from .measurement.design import what_decides as what_decides
    from .measurement.group_plan import GroupPlan as GroupPlan
    from .measurement.group_plan import Rig as Rig
    from .measurement.group_plan import group_plan as group_plan
    from .measurement.separation import Separation as Separation
    from .measurement.separation import separate as separate
    from .measurement.zeros_and_offsets import SimulatedArm as SimulatedArm
    from .report import charts as charts
    from .report import numbers as numbers
    from .report.drawing import Figure as Figure
    from .report.outcome import write_outcome as write_outcome
    from .report.scene import shown_of as shown_of
    from .report.story import tell as tell
    from .report.study import Shown as Shown
    from .report.study import Stand as Stand
    from .report.study import Study as Study
    from .report.study import Table as Table
    from .report.terminal import short_verdict as short_verdict
    from .robot.beam import bending_compliance as bending_compliance
    from .robot.description import Robot as Robot
    from .robot.description import load_robot as load_robot
    from .robot.equilibrium import equilibrium as equilibrium
    from .robot.find import list_robots as list_robots
    from .robot.kinematics import Array as Array
    from .robot.kinematics import moved_base as moved_base
    from .robot.loop import Loop as Loop
    from .robot.rotations import pose as pose
    from .robot.rotations import rotation_about as rotation_about
    from .robot.schema import EffectRecord as EffectRecord
    from .robot.yielding import Yielding as Yielding
    from .simulation.closed_loop.file import Verified as Verified
    from .simulation.closed_loop.file import verify_file as verify_file
    from .simulation.closed_loop.proof import verify as verify
    from .simulation.closed_loop.runs import Task as Task
    from .simulation.closed_loop.runs import World as World
    from .simulation.closed_loop.runs import simulate_all as simulate_all
    from .simulation.export import Exported as Exported
    from .simulation.export import export as export
    from .simulation.virtual_campaign import Truth as Truth
    from .simulation.virtual_campaign import random_geometry as random_geometry
    from .simulation.virtual_campaign import simulate as simulate
    from .studies import as_package as as_package
    from .studies.account_tables import account_items as account_items
    from .studies.accounts import Account as Account
    from .studies.accounts import Item as Item
    from .studies.accounts import Judged as Judged
    from .studies.calibration import Calibrated as Calibrated
    from .studies.calibration import calibrated as calibrated
    from .studies.calibration import calibrated_table as calibrated_table
    from .studies.calibration import stated_table as stated_table
    from .studies.claims import Claim as Claim
    from .studies.claims import checked as checked
    from .studies.clearance import clear_numbers as clear_numbers
    from .studies.clearance import clear_poses as clear_poses
    from .studies.clearance import clear_table as clear_table
    from .studies.counterparts import counterpart as counterpart
    from .studies.draws import Draws as Draws
    from .studies.draws import draw_many as draw_many
    from .studies.draws import tornado as tornado
    from .studies.judging import judge as judge
    from .studies.priors import Prior as Prior
    from .studies.redrawn import redrawn as redrawn
    from .studies.study_run import StudyRun as StudyRun
    from .studies.telling import by_joint as by_joint

    __version__: str

_MODULES = {
    "cli.study": "run_study",
    "campaign": "Campaign Target load_campaign write_campaign",
    "campaign.arrays": "campaign_from_arrays",
    "campaign.planned": "planned random_poses",
    "campaign.problem": "Problem problem problem_of",
    "correction": "path_shapes",
    "correction.command": "Compensation compensate",
    "correction.conditions": "Conditions conditions_of stated_conditions",
    "correction.file": "compensate_file",
    "correction.in_place": "compensate_program",
    "correction.trajectory": "nominal_joints",
    "correction.paths": "Path load_path write_path",
    "diagnosis.changes": "compare",
    "diagnosis.changes.result": "Comparison",
    "diagnosis.found": "Finding Revealed",
    "diagnosis.result": "Diagnosis",
    "diagnosis.run": "Outcome diagnose",
    "effects": "catalogue",
    "effects.base": "Effect",
    "effects.place": "Where",
    "effects.records": "parse_effect record",
    "files.faults": "Fault InputError",
    "identification": "denavit_hartenberg",
    "identification.cells": "CellModel cells fit_cells load_cells two_steps write_cells",
    "identification.deflection": "deflection deflection_budget places with_compliance",
    "identification.fit": "Fit fit start_state",
    "identification.gravity_compensator": "gas_spring pressure",
    "identification.gravity_compensator.charge": "identify_charge",
    "identification.gravity_compensator.spring_fit": "FittedSpring fit_any_order fit_spring",
    "identification.model": "Model",
    "identification.model_file": "loaded write_fit write_model",
    "identification.own_base": "own_base",
    "identification.noise": "Covariance",
    "identification.prediction": "ToolErrors predict",
    "identification.restated": "restated stored",
    "measurement": "axis_by_axis load_pairs sweep zeros_and_offsets",
    "measurement.axis_by_axis": "LocalStiffness",
    "measurement.circle_points": "Axes axes_of fit_circle link_between sweeps turning_ratio",
    "measurement.design": "exchange follow_up plan what_decides",
    "measurement.group_plan": "GroupPlan Rig group_plan",
    "measurement.separation": "Separation separate",
    "measurement.zeros_and_offsets": "SimulatedArm",
    "report": "charts numbers",
    "report.drawing": "Figure",
    "report.outcome": "write_outcome",
    "report.scene": "shown_of",
    "report.story": "tell",
    "report.study": "Shown Stand Study Table",
    "report.terminal": "short_verdict",
    "robot.beam": "bending_compliance",
    "robot.description": "Robot load_robot",
    "robot.equilibrium": "equilibrium",
    "robot.find": "list_robots",
    "robot.schema": "EffectRecord",
    "robot.kinematics": "Array moved_base",
    "robot.loop": "Loop",
    "robot.rotations": "pose rotation_about",
    "robot.yielding": "Yielding",
    "simulation.closed_loop.file": "Verified verify_file",
    "simulation.closed_loop.proof": "verify",
    "simulation.closed_loop.runs": "Task World simulate_all",
    "simulation.export": "Exported export",
    "simulation.virtual_campaign": "Truth random_geometry simulate",
    "studies": "as_package",
    "studies.account_tables": "account_items",
    "studies.accounts": "Account Item Judged",
    "studies.calibration": "Calibrated calibrated calibrated_table stated_table",
    "studies.claims": "Claim checked",
    "studies.clearance": "clear_numbers clear_poses clear_table",
    "studies.counterparts": "counterpart",
    "studies.draws": "Draws draw_many tornado",
    "studies.judging": "judge",
    "studies.redrawn": "redrawn",
    "studies.priors": "Prior",
    "studies.study_run": "StudyRun",
    "studies.telling": "by_joint",
}
_HOME = {name: module for module, names in _MODULES.items() for name in names.split()}
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from .files.version import version

        value: Any = version()
    elif name in _HOME:
        home = importlib.import_module(f"workbench.{_HOME[name]}")
        value = getattr(home, name, None) or importlib.import_module(f"{home.__name__}.{name}")
    else:
        raise AttributeError(f"module 'workbench' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME, "__version__"})

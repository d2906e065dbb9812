"""Robot accuracy workbench: what a robot's simulation gets wrong, why, and the right path all the same.

The names below are the public API. They are imported at first use, so `import workbench` costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .campaign import Campaign as Campaign
    from .campaign import Target as Target
    from .campaign import load_campaign as load_campaign
    from .campaign import write_campaign as write_campaign
    from .campaign.planned import planned as planned
    from .campaign.planned import random_poses as random_poses
    from .campaign.problem import Problem as Problem
    from .campaign.problem import problem as problem
    from .cli.study import run_study as run_study
    from .correction import Conditions as Conditions
    from .correction import compensate as compensate
    from .correction import compensate_file as compensate_file
    from .correction import conditions_of as conditions_of
    from .correction import stated_conditions as stated_conditions
    from .correction.paths import load_path as load_path
    from .diagnosis.result import Diagnosis as Diagnosis
    from .diagnosis.run import Outcome as Outcome
    from .diagnosis.run import diagnose as diagnose
    from .effects import catalogue as catalogue
    from .effects.records import parse_effect as parse_effect
    from .files.faults import Fault as Fault
    from .files.faults import InputError as InputError
    from .identification.cells import CellModel as CellModel
    from .identification.cells import fit_cells as fit_cells
    from .identification.fit import fit as fit
    from .identification.fit import start_state as start_state
    from .identification.model import Model as Model
    from .identification.model_file import write_fit as write_fit
    from .identification.model_file import write_model as write_model
    from .identification.noise import Covariance as Covariance
    from .measurement.circle_points import fit_circle as fit_circle
    from .measurement.circle_points import link_between as link_between
    from .measurement.circle_points import turning_ratio as turning_ratio
    from .measurement.design import plan as plan
    from .report.outcome import write_outcome as write_outcome
    from .robot.description import Robot as Robot
    from .robot.description import load_robot as load_robot
    from .robot.find import list_robots as list_robots
    from .simulation.closed_loop.proof import verify as verify
    from .simulation.virtual_campaign import Truth as Truth
    from .simulation.virtual_campaign import random_geometry as random_geometry
    from .simulation.virtual_campaign import simulate as simulate

    __version__: str

_MODULES = {
    "cli.study": "run_study",
    "campaign": "Campaign Target load_campaign write_campaign",
    "identification.cells": "CellModel fit_cells",
    "measurement.circle_points": "fit_circle link_between turning_ratio",
    "simulation.closed_loop.proof": "verify",
    "correction": "Conditions compensate compensate_file conditions_of stated_conditions",
    "measurement.design": "plan",
    "diagnosis.result": "Diagnosis",
    "diagnosis.run": "Outcome diagnose",
    "effects": "catalogue",
    "identification.model_file": "write_fit write_model",
    "files.faults": "Fault InputError",
    "identification.fit": "fit start_state",
    "identification.model": "Model",
    "identification.noise": "Covariance",
    "correction.paths": "load_path",
    "campaign.planned": "planned random_poses",
    "campaign.problem": "Problem problem",
    "effects.records": "parse_effect",
    "report.outcome": "write_outcome",
    "robot.description": "Robot load_robot",
    "robot.find": "list_robots",
    "simulation.virtual_campaign": "Truth random_geometry simulate",
}
_HOME = {name: module for module, names in _MODULES.items() for name in names.split()}
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name == "__version__":
        value: Any = _version()
    elif name in _HOME:
        value = getattr(importlib.import_module(f"workbench.{_HOME[name]}"), name)
    else:
        raise AttributeError(f"module 'workbench' has no attribute {name!r}")
    globals()[name] = value
    return value


def _version() -> str:
    """As installed; in a source tree that is not, as its pyproject.toml says."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("robot-workbench")
    except PackageNotFoundError:
        import tomllib
        from pathlib import Path

        project = Path(__file__).resolve().parents[1] / "pyproject.toml"
        return str(tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"])


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME, "__version__"})

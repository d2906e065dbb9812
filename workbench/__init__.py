"""Robot accuracy workbench: what a robot's simulation gets wrong, why, and the right path all the same.

The names below are the public API. They are imported at first use, so `import workbench` costs nothing.
`diagnose`, `compensate`, `simulate`, `fit` and `problem` are the functions here, whatever was imported
before; what else the modules of the same name hold comes by `from workbench.diagnosis import Where`.
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .campaign import Campaign as Campaign
    from .campaign import Target as Target
    from .campaign import load_campaign as load_campaign
    from .campaign import write_campaign as write_campaign
    from .cells import CellModel as CellModel
    from .cells import fit_cells as fit_cells
    from .closed_loop.verify import verify as verify
    from .compensate import Conditions as Conditions
    from .compensate import compensate as compensate
    from .compensate import compensate_file as compensate_file
    from .compensate import conditions_of as conditions_of
    from .compensate import stated_conditions as stated_conditions
    from .design import plan as plan
    from .diagnose.run import Outcome as Outcome
    from .diagnose.run import diagnose as diagnose
    from .diagnosis import Diagnosis as Diagnosis
    from .effects import catalogue as catalogue
    from .extended import write_fit as write_fit
    from .extended import write_model as write_model
    from .faults import Fault as Fault
    from .faults import InputError as InputError
    from .fit import fit as fit
    from .fit import start_state as start_state
    from .model import Model as Model
    from .noise import Covariance as Covariance
    from .paths import load_path as load_path
    from .poses import planned as planned
    from .poses import random_poses as random_poses
    from .problem import Problem as Problem
    from .problem import problem as problem
    from .protocols.circle_points import fit_circle as fit_circle
    from .protocols.circle_points import link_between as link_between
    from .protocols.circle_points import turning_ratio as turning_ratio
    from .records import parse_effect as parse_effect
    from .report.outcome import write_outcome as write_outcome
    from .robot import Robot as Robot
    from .robot import list_robots as list_robots
    from .robot import load_robot as load_robot
    from .simulate import Truth as Truth
    from .simulate import random_geometry as random_geometry
    from .simulate import simulate as simulate

_MODULES = {
    "campaign": "Campaign Target load_campaign write_campaign",
    "cells": "CellModel fit_cells",
    "protocols.circle_points": "fit_circle link_between turning_ratio",
    "closed_loop.verify": "verify",
    "compensate": "Conditions compensate compensate_file conditions_of stated_conditions",
    "design": "plan",
    "diagnosis": "Diagnosis",
    "diagnose.run": "Outcome diagnose",
    "effects": "catalogue",
    "extended": "write_fit write_model",
    "faults": "Fault InputError",
    "fit": "fit start_state",
    "model": "Model",
    "noise": "Covariance",
    "paths": "load_path",
    "poses": "planned random_poses",
    "problem": "Problem problem",
    "records": "parse_effect",
    "report.outcome": "write_outcome",
    "robot": "Robot list_robots load_robot",
    "simulate": "Truth random_geometry simulate",
}
_HOME = {name: module for module, names in _MODULES.items() for name in names.split()}
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'workbench' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"workbench.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})


class _Package(ModuleType):
    """Importing a module sets it as an attribute of its package; here the functions keep their names."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package

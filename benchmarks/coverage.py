"""Whether the bounds of `predict` hold on poses that a model did not see, measured on the same robot.

Base and targets are fitted to these poses, robot unchanged, as for any robot that is set up anew; the
instrument's noise counts where it is stated.
"""

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench import Campaign, Model, fit, load_robot, predict, problem_of
from workbench import write_fit as write_model
from workbench.correction.extended_arm import extended_arm
from workbench.diagnosis.found import Noise
from workbench.diagnosis.noise.noise_choice import provisional
from workbench.diagnosis.run import Outcome
from workbench.identification.fit import Fit
from workbench.identification.prediction import ToolErrors
from workbench.identification.prediction.tool import turns_of
from workbench.robot.description import Robot


def covered(outcome: Outcome, other: Campaign) -> dict[str, Any]:
    """What a diagnosis' model predicts of other poses, against what was measured there."""
    with tempfile.TemporaryDirectory() as folder:
        write_model(Path(folder) / "model.toml", outcome.fit)
        return _covered(load_robot(Path(folder) / "model.toml"), outcome.diagnosis.noise, other)


def _covered(robot: Robot, noise: Noise, other: Campaign) -> dict[str, Any]:
    campaign = replace(other, robot=robot)
    errors = predict(robot, campaign, instrument=1e-3 * noise.sigma_mm if noise.source != "residual" else 0.0)
    whole = problem_of(campaign)
    names = [point.name for point in robot.uncertainty.points] if robot.uncertainty else []
    chosen = [[target.name for target in other.targets].index(name) for name in names]
    model = Model(whole, (), tuple(extended_arm(whole).acting))
    judge = fit(model, noise=provisional(whole), geometry=False)
    off = np.linalg.norm(judge.residual[:, chosen], axis=2)
    near = np.isfinite(off) & errors.measured[:, None]
    far = np.isfinite(off) & ~errors.measured[:, None]
    held = off <= errors.corrected
    return {
        "points": int(near.sum()),
        "held": round(float(held[near].mean()), 4) if near.any() else None,
        "rms_mm": round(1e3 * float(np.sqrt(np.mean(off[near] ** 2))), 4) if near.any() else None,
        "bound_mm": round(1e3 * float(np.median(errors.corrected[near])), 4) if near.any() else None,
        "outside": int(far.sum()),
        "held_outside": round(float(held[far].mean()), 4) if far.any() else None,
        **_turned(judge, chosen, errors),
    }


def _turned(judge: Fit, chosen: list[int], errors: ToolErrors) -> dict[str, Any]:
    """The same of the tool's turns, where it is measured as a pose: of all points of a pose together."""
    if errors.turns is None:
        return {}
    seen = np.isfinite(judge.residual[:, chosen]).all(axis=2)
    turned = turns_of(judge.line.prediction.points[:, chosen], seen)
    residual = np.nan_to_num(judge.residual[:, chosen]).reshape(len(seen), -1, 1)
    off = np.linalg.norm((turned @ residual)[..., 0], axis=1)
    near = seen.all(axis=1) & errors.measured
    if not near.any():
        return {}
    return {
        "turns_held": round(float((off <= errors.turns.corrected)[near].mean()), 4),
        "turns_rms_mrad": round(1e3 * float(np.sqrt(np.mean(off[near] ** 2))), 4),
        "turns_bound_mrad": round(1e3 * float(np.median(errors.turns.corrected[near])), 4),
    }

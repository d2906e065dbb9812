"""The whole loop on a simulated KR 500: measure, diagnose, extend the model, correct a path, prove it.

Hidden in the robot: a harmonic-drive error in joint 4 (with a second harmonic), a gas compensator that has
lost a tenth of its charge, backlash in joint 5, and an ordinary robot's errors of geometry. The campaign is
what a laser tracker and the drives would see of Drake's loaded robot; nothing else reaches the diagnosis.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench import (
    Array,
    Campaign,
    Outcome,
    Truth,
    Verified,
    compensate_file,
    diagnose,
    load_campaign,
    load_robot,
    loaded,
    moved_base,
    numbers,
    parse_effect,
    path_shapes,
    planned,
    problem_of,
    random_geometry,
    random_poses,
    record,
    rotation_about,
    short_verdict,
    simulate,
    verify_file,
    write_campaign,
    write_fit,
    write_model,
    write_outcome,
    write_path,
)

Progress = Callable[[str], None]

HIDDEN = (
    "gear_kinematic_error:joint=joint_4,order={order},amplitude=2.2e-4,phase=0.6",
    "gear_kinematic_error:joint=joint_4,order={double},amplitude=4.4e-5,phase=1.1",
    "gravity_compensator:variant=charge,relative=-0.10",
    "backlash:joint=joint_5,half_width=6e-5",
)
PAYLOADS = {"heavy": (250.0, (0.0, 0.0, 0.15))}
TOOL = (60.0, (0.0, 0.0, 0.08))


@dataclass(frozen=True)
class Summary:
    """What the demo found and where it lies."""

    outcome: Outcome
    proof: Verified
    folder: Path

    @property
    def text(self) -> str:
        verdict = short_verdict(self.outcome.diagnosis, self.folder)
        return f"{verdict}\n\n{self.proof.text}\n\nopen {self.folder}/index.html"

    def to_json(self) -> dict[str, Any]:
        return {"diagnosis": self.outcome.diagnosis.to_json(), "proof": self.proof.to_json()}


def demo(folder: Path, seed: int, progress: Progress, quick: bool = False) -> Summary:
    """Runs the demo and writes everything under `folder`."""
    progress("measuring a KR 500 in Drake: two loads, three targets, 30 µm noise")
    campaign, truth, frame = measured(seed, 60 if quick else 150)
    path = write_campaign(folder / "campaign", campaign, comments=["simulated in Drake"])
    outcome = diagnose(load_campaign(path), None, progress, seed)
    progress("correcting a circle and running it on the simulated robot in closed loop")
    proof = _prove(folder / "path", outcome, truth, frame, seed, quick, progress)
    slow = proof.found.slow.trials
    before, after = slow["uncorrected"].figures.rms_mm, slow["corrected"].figures.rms_mm
    words = (
        f"In closed loop the simulated robot draws a circle {numbers.mm(before)} mm off as it is, and "
        f"{numbers.mm(after)} mm off with the commands that this model corrects (RMS)."
    )
    proven = replace(outcome.diagnosis, proof=(words, "path/verify.html"))
    outcome = replace(outcome, diagnosis=proven)
    progress("writing the page, the report and the scene")
    write_outcome(outcome, folder)
    return Summary(outcome, proof, folder)


def measured(seed: int, poses: int) -> tuple[Campaign, Truth, tuple[Array, Array]]:
    """The demo's campaign, the truth behind it, and the true instrument frame R (1, 3, 3), t (1, 3)."""
    rng = np.random.default_rng([seed, 500])
    robot = load_robot("kr500")
    q = np.tile(random_poses(robot, poses, rng, share=0.8), (2, 1))
    plan = planned(
        robot,
        q,
        payloads=PAYLOADS,
        payload=[""] * poses + ["heavy"] * poses,
        tool=TOOL,
        direction=rng.choice([-1.0, 1.0], size=q.shape),
        title="KR 500, laser tracker, two loads",
    )
    # the tool plate was measured beforehand: the targets' places are known
    plan = replace(plan, targets=tuple(replace(target, fixed=True) for target in plan.targets))
    problem = problem_of(plan)
    order = 2 * (robot.joints[3].data.gear_ratio or 100.0)
    truth = Truth(
        geometry=random_geometry(problem.arm, rng),
        effects=tuple(parse_effect(text.format(order=order, double=2 * order), problem) for text in HIDDEN),
        sigma=3e-5,
    )
    frame = rotation_about("z", 2.2)[None], np.array([[3.2, -1.4, -0.6]])
    return simulate(plan, truth, seed=seed, instrument=frame, torque_sigma=0.03), truth, frame


def _prove(
    folder: Path,
    outcome: Outcome,
    truth: Truth,
    frame: tuple[Array, Array],
    seed: int,
    quick: bool,
    progress: Progress,
) -> Verified:
    """Corrects a circle by the diagnosed model and runs it on the true robot."""
    folder.mkdir(parents=True, exist_ok=True)
    write_fit(folder / "model.toml", outcome.fit)
    _write_truth(folder / "truth.toml", outcome, truth, frame)
    frame_of_work = path_shapes.work_frame([1.9, 0.3, 1.1])
    run = path_shapes.Run(frame_of_work, speed=0.05, acceleration=0.5, period=0.01)
    shape = path_shapes.circle(0.03 if quick else 0.06, run)
    write_path(folder / "circle.csv", shape)
    compensate_file(folder / "circle.csv", folder / "model.toml", "krl", folder / "circle.src")
    return verify_file(
        folder / "circle.csv",
        folder / "model.toml",
        folder / "truth.toml",
        folder,
        speeds=(0.05,),
        repeats=0 if quick else 3,
        seed=seed,
        workers=2,
        progress=progress,
    )


def _write_truth(path: Path, outcome: Outcome, truth: Truth, frame: tuple[Array, Array]) -> None:
    """The true robot, standing where the tracker found the base to be.

    A tracker sees where the robot is, not where its base's drawing is: what the fit put into the frame
    instead of the first joint is the same robot in other coordinates.
    """
    problem, state = outcome.problem, outcome.fit.state
    assert truth.geometry is not None
    back, (R, t) = state.R[0].T, frame
    geometry = moved_base(problem.arm, truth.geometry, back @ R[0], back @ (t[0] - state.t[0]))
    records = [record(effect, values) for effect, values in truth.effects]
    write_model(path, loaded(problem.robot, problem.campaign), geometry, records)

"""The batch arm on a KR 500 with compensator and 250 kg: 1000 loaded poses, and one Gauss–Newton step.

The step fits 48 numbers (instrument frame, geometry of six joints, six compliances) to 1000 poses; it is
a whole fit over its steps, so loaded poses and all are in it. Times are the best of several runs, also as
multiples of a matrix product of 1000 × 1000 measured in the same run: for a busy or a slower machine.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from timing import shortest

from workbench.campaign import Target
from workbench.campaign.planned import planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.effects.joint_compliance import JointCompliance
from workbench.identification.fit import fit
from workbench.identification.model import Model, State
from workbench.identification.noise import Covariance
from workbench.robot.description import load_robot

LOADED_POSES = 1000
LOADED_MS, STEP_MS = 50.0, 30.0  # targets on an idle core


def loaded_model() -> tuple[Model, State]:
    """A KR 500 with 250 kg and one target, measured with some numbers off, and its nominal state."""
    robot = load_robot("kr500")
    rng = np.random.default_rng(0)
    plan = planned(
        robot,
        random_poses(robot, LOADED_POSES, rng),
        targets=(Target("T1", (0.15, 0.0, 0.05), fixed=True),),
        payloads={"heavy": (250.0, (0.1, 0.0, 0.2))},
        payload=["heavy"] * LOADED_POSES,
    )
    problem = problem_of(plan)
    model = Model(problem, tuple(JointCompliance.each(problem)))
    state = model.start(np.eye(3)[None], np.zeros((1, 3)), problem.stated_targets[None])
    geometry = 3e-4 * rng.normal(size=state.geometry.shape)
    geometry[[0, -1]] = 0.0
    true = replace(state, geometry=geometry, values=tuple(0.2 * rng.normal(size=(6, 1))))
    points = model.predict(true) + 3e-5 * rng.normal(size=(LOADED_POSES, 1, 3))
    measured = replace(problem, campaign=replace(plan, points=points))
    return replace(model, problem=measured), state


def main() -> None:
    model, state = loaded_model()
    noise = Covariance(np.full((LOADED_POSES, 1), 3e-5), np.zeros(6), np.ones(LOADED_POSES))
    result = fit(model, state, noise)
    square = np.random.default_rng(0).normal(size=(1000, 1000))
    product = 1e3 * shortest(lambda: square @ square, 15)
    whole = 1e3 * shortest(lambda: fit(model, state, noise), 8)
    rows = [
        (f"{LOADED_POSES} loaded poses", 1e3 * shortest(lambda: model.loaded(state), 15), LOADED_MS),
        (
            "derivatives by every motion of every frame",
            1e3 * shortest(lambda: model.linearise(state, result.line), 15),
            None,
        ),
        (f"Gauss–Newton step, {len(result.columns.names)} numbers", whole / result.iterations, STEP_MS),
    ]
    print(f"{'matrix product 1000 × 1000':45s} {product:7.1f} ms")
    for what, wall, target in rows:
        goal = "" if target is None else f"   (target {target:.0f} ms)"
        print(f"{what:45s} {wall:7.1f} ms = {wall / product:5.2f} products{goal}")
    rms = float(np.sqrt(np.mean(result.residual**2)))
    print(f"whole fit: {result.iterations} steps, {whole:.0f} ms, residual "
          f"{1e3 * rms:.4f} mm of 0.0300 mm noise")  # fmt: skip


if __name__ == "__main__":
    main()

"""A world handed to Drake: its kinematics, its torques, its loaded equilibrium."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from workbench import Array, Campaign, Problem, Robot, Truth, simulate

from .laws import constant
from .worlds import IN_BASE, Law, Values, World


def sprung(robot: Robot, values: Values) -> Robot:
    """The robot with the springs of a world."""
    joints = [
        replace(joint, data=joint.data.model_copy(update={"stiffness": values[f"k{j}"]}))
        for j, joint in enumerate(robot.joints, start=1)
    ]
    return replace(robot, joints=tuple(joints))


def measured(w: World, problem: Problem, law: Law, seed: int, noise: bool = True) -> Campaign:
    """The plan of a problem as Drake measures it. What yields beside the springs moves as it does under the
    wrenches of the rigid arm; Drake finds where the springs come to rest."""
    values = w.values
    true = replace(problem, arm=problem.arm.with_geometry(w.geometry))
    wrench = true.nominal_load.local
    beside = (law(values, true, wrench) - constant(values, true, wrench)).reshape(len(wrench), -1)
    moves = {int(column): beside[:, column] for column in np.flatnonzero(beside.any(axis=0))}
    scatter = values["scatter"] * np.array(
        [joint.data.repeatability or 0.0 for joint in problem.robot.joints]
    )
    truth = Truth(
        w.geometry,
        motion=lambda _: moves,
        sigma=values["sigma"] if noise else 0.0,
        repeatability=scatter if noise else np.zeros(len(scatter)),
    )
    plan = replace(problem.campaign, robot=sprung(problem.robot, values))
    return simulate(plan, truth, seed=seed, instrument=IN_BASE)


def moved(w: World, problem: Problem, law: Law) -> Array:
    """(M, 3) [m] what the load moves the SMR by in Drake, without noise."""
    points = measured(w, problem, law, 0, noise=False).points[:, 0]
    half = len(points) // 2
    return np.asarray(points[half:] - points[:half])

"""What no machine can be: an arm that its stated loads bend without end, and links far from their drawing."""

from __future__ import annotations

import numpy as np

from ...campaign.problem import Problem
from ...files.faults import Fault, InputError
from ...robot.schema import GEOMETRY
from ..fit import Fit, fit, start_state
from ..model import Model, State

LONGEST = 0.15  # m, or
SHARE = 0.1  # of the reach: more is no error of a length
TURN = 0.35  # rad: more is no error of an angle
FAULTS = 2e-3  # of the reach, per axis: what a calibrated robot's faults may leave; more is another robot


def check_rest(model: Model, state: State) -> None:
    """Raises InputError where the arm as stated does not come to rest under the loads as stated."""
    try:
        model.loaded(state)
    except ArithmeticError:
        robot, loads = model.problem.robot, model.problem.loads
        heaviest = float(np.max(loads.mass))
        what = (
            f"under the stated loads ({heaviest:.4g} kg at the flange at most) {robot.name} comes to no rest"
        )
        mend = "check masses [kg], wrenches [N, N m] and the stiffness in the robot's TOML"
        raise InputError(Fault(str(model.problem.campaign.path), what, mend)) from None


def plausible_geometry(geometry: Fit) -> Fit:
    """The fit; where it is farther from the nominal geometry than any machine is, one that its misfit allows
    to be nearer. Raises InputError where that is too far as well.

    Strong faults that the model does not have bend the geometry without end along what hardly shows in the
    data, as these are believed to the noise. They are not, and by as much as they misfit the priors count.
    """
    said = _farthest(geometry)
    if said is None:
        return geometry
    held = geometry.noise.times(max(1.0, float(np.sqrt(geometry.chi2 / geometry.point_rows))))
    near = fit(geometry.model, start_state(geometry.model.problem), held)
    left = np.sqrt(np.nanmean(near.residual**2))
    if _farthest(near) is not None or left > FAULTS * _reach(geometry.model.problem):
        raise InputError(said)
    return fit(geometry.model, near.state, geometry.noise, max_iterations=1)


def _farthest(geometry: Fit) -> Fault | None:
    """The correction that is most beyond what a machine can be, if one is."""
    problem = geometry.model.problem
    change = (geometry.state.geometry - problem.arm.geometry).reshape(-1)
    limit = np.tile([max(LONGEST, SHARE * _reach(problem))] * 3 + [TURN] * 3, len(geometry.state.geometry))
    worst = int(np.argmax(np.abs(change) / limit))
    if abs(change[worst]) <= limit[worst]:
        return None
    slot, component = divmod(worst, 6)
    size = f"{change[worst] * 1e3:.0f} mm" if component < 3 else f"{np.degrees(change[worst]):.0f}°"
    joint = problem.arm.names[slot - 1]
    what = f"{GEOMETRY[component]} of {joint} would have to be {size} off: no {problem.robot.title} is"
    mend = "check the units, the poses and which robot this is"
    if slot == 1 and component >= 3 and problem.arm.weighed:  # the base, as far as gravity tells
        mend += "; on a ceiling or a wall say which way is down: `gravity` in the robot's TOML"
    return Fault(str(problem.campaign.path), what, mend)


def _reach(problem: Problem) -> float:
    """[m] of the links in one line."""
    return float(np.linalg.norm(problem.arm.p[2:], axis=1).sum())

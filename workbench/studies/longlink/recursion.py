"""The paper's compensation (24) to (26): T_end = 2T − T₇, once and again, on a path."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from workbench import Array, Robot, Table, numbers, places, planned, with_compliance
from workbench import denavit_hartenberg as dh

from .arm import BALL
from .printed import TABLE_2, TABLE_3

ROUNDS = 4
MISSED = 0.2  # of the compliance, in the model that is off
POINTS, RADIUS = 48, 0.3  # of the path, a circle [m]
START = np.radians([10.0, -60.0, 70.0, 20.0, -40.0, 30.0, 0.0])


def compensated(assumed: Robot, share: float) -> dict[str, Array]:
    """By model the root mean square error [mm] (ROUNDS + 1,) of a robot of Table III
    that yields by `share` of what is assumed: uncompensated, after (26) once, twice, ..."""
    bare, true = with_table_3(assumed), yielding(assumed, share)
    models = {
        "compliance known": true,
        f"compliance {numbers.percent(MISSED, 0)} too small": with_compliance(bare, (1 - MISSED) * share),
        "links alone, Table I": with_compliance(bare, 1e-9),
    }
    path = circle()
    return {
        name: np.array([_error(true, q, path) for q in commands(model, path)])
        for name, model in models.items()
    }


def with_table_3(assumed: Robot) -> Robot:
    """The arm with Table III's geometry, its compliance as assumed."""
    return dh.with_rows(assumed, TABLE_2, TABLE_3)


def yielding(assumed: Robot, share: float) -> Robot:
    """The arm of Table III that yields by `share` of what is assumed."""
    return with_compliance(with_table_3(assumed), share)


def recursion_numbers(found: dict[str, Array]) -> dict[str, float]:
    """Errors [mm] where the compliance is known: uncompensated, after (26) once, and twice."""
    known = next(iter(found.values()))
    words = ("none", "once", "twice")
    return {f"known_{key}_mm": float(error) for key, error in zip(words, known, strict=False)}


def circle() -> Array:
    """(P, 3) [m] a circle about the tip's place in the first pose, upright and square to the arm."""
    centre = dh.chain(TABLE_3, START[None])[0, -1, :3, 3]
    t = np.linspace(0, 2 * np.pi, POINTS)
    return np.asarray(centre + RADIUS * np.column_stack([0 * t, np.cos(t) - 1, np.sin(t)]))


def commands(model: Robot, path: Array) -> list[Array]:
    """(P, 7) joints for a path (P, 3) by a model of the arm: uncompensated, after (26) once, twice, ..."""
    asked, out = path.copy(), [_joints(path, np.tile(START, (len(path), 1)))]
    for _ in range(ROUNDS):
        asked = asked + path - _tip(model, out[-1])  # once from asked = T: T + (T − T₇) = 2T − T₇
        out.append(_joints(asked, out[-1]))
    return out


def _error(robot: Robot, q: Array, path: Array) -> float:
    return float(1e3 * np.sqrt(((_tip(robot, q) - path) ** 2).sum(axis=1).mean()))


def _tip(robot: Robot, q: Array) -> Array:
    """(P, 3) [m] where the loaded tip is."""
    return places(planned(robot, q, targets=[BALL]))[:, 0]


def _joints(points: Array, q: Array) -> Array:
    """(P, 7) joints of the rigid arm of Table III whose tip is at the points, nearest to joints q."""
    q = q.copy()
    for _ in range(20):
        where = dh.chain(TABLE_3, q)
        left = points - where[:, -1, :3, 3]
        J = np.cross(where[:, :-1, :3, 2], where[:, -1:, :3, 3] - where[:, :-1, :3, 3])  # (P, 7, 3)
        q += _step(J, left)
        if np.abs(left).max() < 1e-10:
            break
    return q


def _step(J: Array, left: Array) -> Array:
    """(P, 7) smallest motion of the joints that moves the tip by `left` (P, 3); J: (P, 7, 3)."""
    square = np.einsum("pja,pjb->pab", J, J)
    return np.einsum("pja,pa->pj", J, np.linalg.solve(square, left[..., None])[..., 0])


def recursion_table(found: dict[str, Array], driven: Mapping[float, Array]) -> Table:
    """Errors by round and model, and driven in closed loop where the compliance is known."""
    rows = [
        [
            "not compensated" if k == 0 else f"(26), {k} ×",
            *(numbers.mm(float(errors[k])) for errors in found.values()),
            *(numbers.mm(float(errors[k])) if k < len(errors) else "" for errors in driven.values()),
        ]
        for k in range(ROUNDS + 1)
    ]
    note = (
        f"Root mean square error of the tip, mm, over {POINTS} points of a circle of {1e3 * RADIUS:.0f} mm; "
        "the robot is Table III's "
        "and yields; its geometry is known, the deflection is what the model in the head says. Loaded "
        "poses: the workbench's statics. Driven: compliance known, in simulated closed loop, without dry "
        "friction."
    )
    head = ("Round", *found, *(f"driven in {seconds:.0f} s" for seconds in driven))
    return Table("Compensation T_end = 2T − T₇ and its recursion", head, rows, note)

"""The free values of each account of Table I: what they are, how far they may go, and why."""

from __future__ import annotations

from functools import partial

import numpy as np

from workbench import Prior

ARCMIN = float(np.radians(1 / 60))

log = partial(Prior, log=True)


def common(pool: int) -> dict[str, Prior]:
    """What all accounts leave open; pool: how many plans."""
    return {
        "plan": Prior(
            "plan of the pool", 0, pool, why="angles, counts, tool, hook and pulls are not printed"
        ),
        "noise": log("noise per axis and reading", 10, 60, "µm", why="a tracker and a robot at rest"),
        "charge": Prior("charge of the gas over a KR 300's", 0.5, 1.5, why="not public"),
        "reading": Prior("“CI” is 1 σ (below ½) or 95 %", 0, 1, why="the paper does not say"),
        "known": Prior("noise from the residual (below ½) or known", 0, 1, why="not printed"),
    }


BEARINGS = {
    f"bearing_{j}": log(f"tilt of bearing {j}", 2, 60, "nrad/(N·m)", why="moment rigidity of such gears")
    for j in (1, 2, 3)
}
LINKS = {f"bending_{j}": log(f"1/EI of link {j}", 5, 100, "10⁻⁹/(N·m²)", why="cast links") for j in (2, 3)}

OWN: dict[str, tuple[str, dict[str, Prior]]] = {
    "gas": ("authors: gas spring that the arm holds", {}),
    "strong": (
        "authors: gas spring of any strength",
        {
            "strength": log("strength over a KR 300's", 1, 500, why="what eq. (12) is free to find"),
            "length": log("gas length over its stroke", 1.05, 10, why="what eq. (12) is free to find"),
        },
    ),
    "noise": (
        "constant; readings scatter more",
        {
            "scatter": log(
                "scatter per axis and reading", 60, 600, "µm", why="markers put on again, an arm that creeps"
            )
        },
    ),
    "soft": (
        "a soft gear in joint 2",
        {
            "width": log(
                "half width of the soft zone", 0.05, 1.0, "arcmin", why="data sheets allow 1 arcmin"
            ),
            "torque": log("torque at which it carries", 100, 5000, "N·m", why="up to half the rated torque"),
        },
    ),
    "friction": (
        "friction, by the side of approach",
        {
            "friction": log("friction over rated torque", 0.001, 0.1, why="gears of this class"),
            "mixed": Prior("one side per angle (below ½) or any", 0, 1, why="not printed"),
        },
    ),
    "yielding": (
        "bearings, links and floor yield",
        {
            **BEARINGS,
            "foundation": log("tilt of the floor", 0.1, 10, "nrad/(N·m)", why="pedestals and floors"),
            **LINKS,
        },
    ),
    "elsewhere": (
        "the load hangs elsewhere than told",
        {
            "off": log("error of the hook's place, per axis", 1, 100, "mm", why="a hook and a chain"),
            "weight": Prior("error of the load", -0.05, 0.05, why="with hook and chain"),
        },
    ),
    "frames": (
        "markers and frame off",
        {
            "place": log("error of the markers' places, per axis", 0.5, 50, "mm", why="from a drawing"),
            "turn": log("turn of the instrument's frame", 0.01, 2, "°", why="a frame fitted to the base"),
        },
    ),
    "sessions": (
        "creep, one session per angle",
        {"creep": log("creep per axis", 10, 400, "µm", why="floor, tripod and gears under load")},
    ),
    "nameless": (
        "differs by angle, for no named reason",
        {"spread": log("scatter of its logarithm", 0.01, 0.5, why="no account: a yardstick")},
    ),
}
"""[-] account → its words and its own free values, beside the common ones."""

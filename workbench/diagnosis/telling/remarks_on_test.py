"""What to know before the figures of a test campaign are believed: it stands elsewhere, or tests nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...campaign import Campaign
from ...identification.fit import Fit
from ...robot.kinematics import Array
from ...robot.ranges import beyond_range
from ...robot.rotations import nearest_turn

FEWEST = 8  # points, from which a frame fitted to them says something
EXPLAINED = 0.5  # of the error at most is left with the frame fitted anew, where the frame is what is wrong
MOST = 0.5  # of the poses, from which they count as those that were fitted
SAME = 1e-9  # rad, m
SURELY = 3.0  # standard errors


@dataclass(frozen=True)
class Elsewhere:
    """A set-up that stands elsewhere than the fit has it: by how much [m, rad], and the mean errors [m] as it
    is and with its frame fitted anew; beyond: most of its poses lie outside of what was measured."""

    setup: str
    shift: float
    turn: float
    before: float
    left: float
    beyond: bool

    def __str__(self) -> str:
        name = f" in the set-up {self.setup!r}" if self.setup else ""
        return (
            f"In the test campaign the instrument or the robot's base stands {1e3 * self.shift:.3g} mm and "
            f"{np.degrees(self.turn):.2g}° from where the fit has it{name}: with the frame fitted anew "
            f"{1e3 * self.left:.3g} mm (mean) are left of {1e3 * self.before:.3g} mm. If it was moved, give "
            "the test's poses a name of their own in the column setup."
            + " Most of these poses lie beyond what was measured: it may be the model that errs there."
            * self.beyond
        )


def elsewhere(
    campaign: Campaign, predicted: Array, own: list[str], beyond: NDArray[np.bool_]
) -> list[Elsewhere]:
    """Set-ups whose errors are mostly their frame's. predicted: (N, T, 3) [m]; own: set-ups with
    frames of their own; beyond: (N,) `beyond_measured`."""
    found = []
    for k, name in enumerate(campaign.setup_names):
        here = np.isfinite(campaign.points).all(axis=2) & (campaign.poses.setup == k)[:, None]
        if name in own or here.sum() < FEWEST:
            continue
        a, b = predicted[here], campaign.points[here]
        R = nearest_turn(a - a.mean(axis=0), b - b.mean(axis=0))
        anew = b.mean(axis=0) + (a - a.mean(axis=0)) @ R.T
        before, left = (float(np.mean(np.linalg.norm(b - one, axis=1))) for one in (a, anew))
        if left < EXPLAINED * before:
            shift = float(np.linalg.norm((b - a).mean(axis=0)))
            turn = float(np.arccos(np.clip((np.trace(R) - 1) / 2, -1.0, 1.0)))
            out = bool(beyond[campaign.poses.setup == k].mean() > MOST)
            found.append(Elsewhere(name, shift, turn, before, left, out))
    return found


def beyond_measured(campaign: Campaign, fitted: Fit) -> NDArray[np.bool_]:
    """(N,) which poses of a test have a joint outside of what was measured of it."""
    q = fitted.model.problem.q
    return np.asarray(beyond_range(campaign.poses.q, q.min(axis=0), q.max(axis=0)).any(axis=1))


def worse(before: Array, after: Array, beyond: NDArray[np.bool_]) -> list[str]:
    """That the model is farther off than the robot as it was, at the poses of a test or at those beyond what
    was measured. before, after: (N, T) [m], NaN where not seen; beyond: (N,)."""
    seen = np.isfinite(after).any(axis=1)
    was, now = (np.array([np.nanmean(row) for row in one[seen]]) for one in (before, after))
    every, some = np.ones(int(seen.sum()), dtype=bool), beyond[seen]
    if _larger(now - was):
        here, where = every, "At the test campaign's poses"
        if beyond.any():
            where += f", of which {beyond.sum()} lie beyond the joints' measured ranges,"
    elif _larger((now - was)[some]):
        of = f"{beyond.sum()} of the test campaign's {len(beyond)} poses"
        here, where = some, f"At {of}, which lie beyond the joints' measured ranges,"
    else:
        return []
    mm = (1e3 * float(one[here].mean()) for one in (now, was))
    return [
        "{} the model is farther off ({:.3g} mm) than the robot as it was ({:.3g} mm): correct nothing there "
        "before it is measured there.".format(where, *mm)
    ]


def _larger(difference: Array) -> bool:
    """Whether differences (N,) are above zero in the mean, by more than they scatter."""
    n = len(difference)
    return n > 1 and float(difference.mean()) > SURELY * float(difference.std(ddof=1)) / np.sqrt(n)


def nothing_new(campaign: Campaign, fitted: Fit) -> list[str]:
    """That the poses of a test, or even its points, are those that were fitted."""
    c = fitted.model.problem.campaign
    known = {key: n for n, key in enumerate(_keys(c))}
    rows = np.array([known.get(key, -1) for key in _keys(campaign)])
    again = rows >= 0
    if again.mean() < MOST:
        return []
    names = [target.name for target in c.targets]
    both = [(i, names.index(t.name)) for i, t in enumerate(campaign.targets) if t.name in names]
    pairs = [(campaign.points[again, i], c.points[rows[again], j]) for i, j in both]
    seen = [np.isfinite(a) & np.isfinite(b) for a, b in pairs]
    equal = [np.abs(a - b)[s] < SAME for (a, b), s in zip(pairs, seen, strict=True)]
    count = f"{again.sum()} of the test campaign's {len(rows)} poses"
    if equal and np.concatenate(equal).mean() > MOST:
        return [f"{count} are those that were fitted, with the same points: as a test they show nothing."]
    return [
        f"{count} were fitted as well, measured another time: they show how poses repeat, not other poses."
    ]


def _keys(campaign: Campaign) -> list[tuple[bytes, str, bytes]]:
    """What a pose was told: joints, payload and wrench."""
    p = campaign.poses
    q = np.round(p.q / SAME) + 0.0
    return [
        (q[n].tobytes(), campaign.payload_names[p.payload[n]], p.wrench[n].tobytes()) for n in range(len(q))
    ]

"""Sides of approach that nobody wrote down, of poses that follow each other along a path."""

from __future__ import annotations

import numpy as np

from .poses import Array, IntArray

STILL = 1e-5  # rad or m: by less no joint moves on
KEEPS = 0.8  # of the joints' motions go on as the one before; of poses in any order a third do
BEYOND = 1e100  # rad, m: as far as anything squares; who asks judges such numbers pose by pose
CLOSE = 0.3  # times the distance of two poses drawn at random, at which the next pose is


def sides_along(q: Array, setup: IntArray, time: Array | None) -> Array | None:
    """(N, n) sign of each joint's last motion, 0 before its first, where poses (N, n) [rad, m] follow each
    other along a path: close by, and nearly all going on as before. None where they do not. setup: (N,);
    time: (N,) [s], which their order is by where it is known."""
    when = np.arange(len(q)) if time is None or not np.isfinite(time).all() else time
    order = np.lexsort((when, setup))
    q = np.clip(q, -BEYOND, BEYOND)
    spread = q.std(axis=0)
    moving = spread > STILL
    if len(q) < 4 or not moving.any():
        return None
    step = np.diff(q[order], axis=0) * (np.diff(setup[order]) == 0)[:, None]
    going = np.where(np.abs(step) > STILL, np.sign(step), 0.0)
    on = going[1:] * going[:-1]
    turned = (on != 0)[:, moving]
    if not turned.any() or (on[:, moving][turned] > 0).mean() < KEEPS:
        return None
    scaled = q[:, moving] / spread[moving]
    other = np.random.default_rng(0).permutation(len(q))
    near = np.linalg.norm(np.diff(scaled[order], axis=0), axis=1)
    far = np.linalg.norm(np.diff(scaled[other], axis=0), axis=1)
    if np.median(near) > CLOSE * np.median(far):
        return None
    out = np.zeros(q.shape)
    for i in range(1, len(q)):
        before = out[order[i - 1]] if setup[order[i]] == setup[order[i - 1]] else 0.0
        out[order[i]] = np.where(going[i - 1] != 0, going[i - 1], before)
    return out

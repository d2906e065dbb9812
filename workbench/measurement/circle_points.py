"""Circle-point analysis: one joint turns alone, a target runs on a circle about its axis.

From the circle come the joint's axis and, with the encoder's angles, its reduction ratio; from neighbouring
axes come the link's length a and twist α (standard Denavit–Hartenberg). Liu et al., eqs. (27), (28), which
takes three points of a circle; here any number of them is fitted in space, and all comes with its covariance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ..robot.kinematics import Array

PARALLEL = 0.02  # rad; axes nearer to parallel than this have no common normal to speak of


@dataclass(frozen=True)
class Circle:
    """A circle in space. points: (N, 3) [m] that it was fitted to; x: (6,) centre, two tilts of the normal,
    radius [m, rad]; frame: (3, 3) columns u, v, n about which the normal tilts; covariance: (6, 6) of x;
    sigma: noise per axis [m] as the points scatter about the circle."""

    points: Array
    x: Array
    frame: Array
    covariance: Array
    sigma: float

    @property
    def centre(self) -> Array:
        """(3,) [m]: a point on the joint's axis."""
        return self.x[:3]

    @property
    def direction(self) -> Array:
        """(3,) unit vector along the axis, right-handed with the order of the points."""
        return _normal(self.x, self.frame)

    @property
    def radius(self) -> float:
        return float(self.x[5])

    @property
    def turned(self) -> Array:
        """(N,) [rad] angle of each point from the first one, about the axis."""
        return _angles(self.x, self)


@dataclass(frozen=True)
class Link:
    """Between two axes: length a [m] and twist α [rad] with standard deviations. spread: the angle
    between parallel axes that is no twist about the link (about its normal: Hayati's β) [rad]."""

    a: float
    alpha: float
    a_std: float
    alpha_std: float
    spread: float = 0.0


@dataclass(frozen=True)
class Axes:
    """What the circles of an arm's n joints give: the links between its axes (n − 1), the ratios (n, 2) and
    the ball's distance from the last axis [m], these two with standard deviations."""

    links: Sequence[Link]
    ratio: Array
    ball: tuple[float, float]

    def rows(self, nominal: Array) -> Array:
        """(n, 4) Denavit–Hartenberg rows θ α a d with these a and α; behind the last axis: as `nominal`."""
        out = np.array(nominal, dtype=np.float64)
        out[:-1, 1:3] = [(link.alpha, link.a) for link in self.links]
        return out

    @property
    def values(self) -> Array:
        """(3 n − 1, 2) lengths a [mm], twists α [°], ratios less one [ppm] and the ball's distance [mm], each
        with its standard deviation."""
        a = [(1e3 * link.a, 1e3 * link.a_std) for link in self.links]
        alpha = np.degrees([(link.alpha, link.alpha_std) for link in self.links])
        return np.concatenate([a, alpha, 1e6 * (self.ratio - [1, 0]), [1e3 * np.array(self.ball)]])


def fit_circle(points: Array) -> Circle:
    """Circle through points (N, 3) [m] of one joint's sweep in their order: least squares of the distances
    in space. Raises ValueError for fewer than four points, or points on a line."""
    points = np.asarray(points, dtype=np.float64)
    middle = points.mean(axis=0)
    if len(points) < 4:
        raise ValueError("a circle with its uncertainty takes four points or more")
    _, size, axes = np.linalg.svd(points - middle)
    if size[1] < 1e-6 * size[0]:
        raise ValueError("the points lie on a line, not on a circle")
    flat = (points - middle) @ axes[:2].T  # Kåsa's circle in their plane, to start from
    A = np.column_stack([2 * flat, np.ones(len(flat))])
    x, y, rest = np.linalg.lstsq(A, (flat**2).sum(axis=1), rcond=None)[0]
    centre = middle + axes[:2].T @ [x, y]
    arms = points - centre
    n = np.sign(np.cross(arms[:-1], arms[1:]).sum(axis=0) @ axes[2]) * axes[2]
    frame = np.column_stack([axes[0], np.cross(n, axes[0]), n])
    start = np.array([*centre, 0.0, 0.0, np.sqrt(rest + x**2 + y**2)])
    found = least_squares(
        _off, start, args=(points, frame), x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14
    )
    variance, J = 2 * float(found.cost) / (2 * len(points) - 6), np.asarray(found.jac, dtype=np.float64)
    covariance = np.asarray(variance * np.linalg.inv(J.T @ J), dtype=np.float64)
    return Circle(points, np.asarray(found.x), frame, covariance, float(np.sqrt(variance)))


def link_between(first: Circle, second: Circle, along: Array) -> Link:
    """Length and twist of the link from one joint's axis to the next one's.

    along: (3,) rough direction of the link's x axis, in the points' frame: it decides the signs, and the
    whole x axis where the joints are parallel.
    """

    def between(x: Array) -> Array:
        n, m = _normal(x[:6], first.frame), _normal(x[6:], second.frame)
        normal, arm = np.cross(n, m), x[6:9] - x[:3]
        parallel = np.linalg.norm(normal) < PARALLEL
        link = arm - (arm @ n) * n if parallel else normal
        link = np.sign(link @ along) * link / np.linalg.norm(link)
        spread = np.cross(n, link) @ np.cross(n, m) if parallel else 0.0
        return np.array([link @ arm, np.arctan2(normal @ link, n @ m), spread])

    x = np.concatenate([first.x, second.x])
    a, alpha, spread = between(x)
    J = _slope(between, x)
    covariance = np.zeros((12, 12))
    covariance[:6, :6], covariance[6:, 6:] = first.covariance, second.covariance
    a_std, alpha_std, _ = np.sqrt(np.diag(J @ covariance @ J.T))
    return Link(float(a), float(alpha), float(a_std), float(alpha_std), float(spread))


def sweeps(home: Array, spans: Array, stops: int) -> Array:
    """(n · stops, n) joints [rad]: one after the other turns by ± its span about `home`, while others rest.

    home, spans: (n,) [rad]; stops: how many standstills a sweep has.
    """
    way = np.linspace(-1, 1, stops)
    return np.concatenate([home + np.outer(way, span) for span in np.diag(spans)])


def turning_ratio(circle: Circle, commanded: Array) -> tuple[float, float]:
    """How far the joint turns per commanded turn, and its standard deviation: the slope of the angles on the
    circle over the commanded ones (N,) [rad]."""
    off = commanded - commanded.mean()

    def slope(x: Array) -> Array:
        return np.atleast_1d(off @ _angles(x, circle) / (off @ off))

    J = _slope(slope, circle.x)
    along = circle.sigma**2 / circle.radius**2 / (off @ off)  # noise along the circle, which is not in x
    return float(slope(circle.x)[0]), float(np.sqrt((J @ circle.covariance @ J.T)[0, 0] + along))


def distance_from(circle: Circle, points: Array, commanded: Array) -> tuple[float, float]:
    """Distance [m] of a second target from the axis and its standard deviation, from its places (N, 3) at
    the commanded angles (N,) [rad]: for a target so near to the axis that its circle drowns in the noise."""
    n = circle.direction
    u = circle.frame[:, 0] - (circle.frame[:, 0] @ n) * n
    flat = points @ np.column_stack([u, np.cross(n, u)]) / np.linalg.norm(u)
    c, s, one, no = np.cos(commanded), np.sin(commanded), np.ones(len(commanded)), np.zeros(len(commanded))
    A = np.vstack([np.column_stack([one, no, c, -s]), np.column_stack([no, one, s, c])])
    fitted = np.linalg.lstsq(A, flat.T.ravel())[0]
    spread = circle.sigma * np.sqrt(np.linalg.inv(A.T @ A)[2, 2])
    return float(np.hypot(fitted[2], fitted[3])), float(spread)


def axes_of(points: Array, commanded: Array, along: Array) -> Axes:
    """Axes, links and ratios of an arm whose joints were turned one at a time (`sweeps`).

    points: (n, N, T, 3) [m] of each joint's sweep: the ball on the last axis, then a mark off all axes, which
    runs on the circles; commanded: (n, N) [rad] angle of the joint that turns; along: (n − 1, 3) rough x axes
    of the links.
    """
    circles = [fit_circle(swept[:, 1]) for swept in points]
    links = [link_between(circles[i], circles[i + 1], along[i]) for i in range(len(circles) - 1)]
    ratio = [turning_ratio(circle, angle) for circle, angle in zip(circles, commanded, strict=True)]
    return Axes(links, np.array(ratio), distance_from(circles[-1], points[-1, :, 0], commanded[-1]))


def _normal(x: Array, frame: Array) -> Array:
    n = frame @ [x[3], x[4], 1.0]
    return np.asarray(n / np.linalg.norm(n))


def _off(x: Array, points: Array, frame: Array) -> Array:
    """(2 N,) distances from the circle: in its plane and across."""
    n, arms = _normal(x, frame), points - x[:3]
    across = arms @ n
    return np.concatenate([np.linalg.norm(arms - across[:, None] * n, axis=1) - x[5], across])


def _angles(x: Array, circle: Circle) -> Array:
    n, arms = _normal(x, circle.frame), circle.points - x[:3]
    first = arms[0] - (arms[0] @ n) * n
    return np.unwrap(np.arctan2(arms @ np.cross(n, first), arms @ first))


def _slope(function: Callable[[Array], Array], x: Array) -> Array:
    """(m, k) derivative by central differences."""
    step = 1e-6 * np.eye(len(x))
    return np.stack([(function(x + h) - function(x - h)) / 2e-6 for h in step], axis=1)

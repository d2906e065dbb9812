"""Denavit–Hartenberg tables: standard, modified, and Hayati's, which has no long links between parallel axes.

A row takes frame i − 1, whose z is joint i's axis, to frame i, whose z is the next one's:

    Rz(θ + q) Tz(d + q) Tx(a) Rx(α) Ry(β)          q turns or slides, by the joint's kind

With β = 0 that is the standard row (Denavit and Hartenberg); where two axes are nearly parallel d is zero and
β takes what is left of the turn (Hayati 1983). The modified row (Craig) has a and α of the row before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...robot.kinematics import Arm, Array, frames
from ...robot.rotations import pose, screw
from .content import Content
from .text import commented, number
from .urdf import Files, rpy

PARALLEL = np.radians(5.0)  # axes closer than this have no use for their common normal
SAME = 1e-9  # rad, m: parallel, or crossing


@dataclass(frozen=True, eq=False)
class Table:
    """rows: (n, 5) θ d a α β [rad, m]. base: (4, 4) of frame 0 in the base's; tool: of the flange in n."""

    rows: Array
    base: Array
    tool: Array
    prismatic: Array

    def flange(self, q: Array) -> Array:
        """(N, 4, 4) pose of the flange for joints q (N, n)."""
        X = np.broadcast_to(self.base, (len(q), 4, 4))
        for (theta, d, a, alpha, beta), slides, moved in zip(self.rows, self.prismatic, q.T, strict=True):
            turn, shift = (0.0 * moved, moved) if slides else (moved, 0.0 * moved)
            link = screw("z", theta, d) @ screw("x", alpha, a) @ screw("y", beta, 0.0)
            along = screw("z", turn, 0.0)
            along[:, 2, 3] = shift
            X = X @ along @ link
        return np.asarray(X @ self.tool)

    @property
    def without_beta(self) -> Table:
        """The table without its fifth column: what standard and modified rows can say."""
        rows = self.rows.copy()
        rows[:, 4] = 0.0
        return Table(rows, self.base, self.tool, self.prismatic)


def table_of(arm: Arm) -> Table:
    """Hayati's table of an arm; exact, and the standard one where no axes are nearly parallel."""
    here = frames(arm, np.zeros((1, arm.n)))
    X = pose(here.p[:, 0], here.R[:, 0])  # base, links 1 .. n, flange; z along the joints' axes
    base = _first(X[1])
    frame, rows = base, []
    for i in range(1, arm.n + 1):
        last = i == arm.n
        row = _row(np.linalg.inv(frame) @ X[i + 1], last)
        rows.append(row)
        theta, d, a, alpha, beta = row
        frame = frame @ screw("z", theta, d) @ screw("x", alpha, a) @ screw("y", beta, 0.0)
    return Table(np.array(rows), base, np.linalg.inv(frame) @ X[-1], np.asarray(arm.prismatic))


def _first(X: Array) -> Array:
    """Frame 0: on axis 1 at the height of the base's origin, x as the base's."""
    z, p = X[:3, 2], X[:3, 3]
    p = p - z * (p[2] / z[2] if abs(z[2]) > 0.5 else p @ z)
    x = np.eye(3)[0] if abs(z[0]) < 0.9 else np.eye(3)[1]
    x = x - z * (z @ x)
    x /= np.linalg.norm(x)
    return pose(p, np.stack([x, np.cross(z, x), z], axis=1))


def _row(X: Array, last: bool) -> Array:
    """The row (5,) to the next axis, which is the z of X (4, 4) in the frame before."""
    z, p = X[:3, 2], X[:3, 3]
    normal = np.cross([0.0, 0.0, 1.0], z)
    size = float(np.linalg.norm(normal))
    if size < np.sin(PARALLEL):
        d = p[2] if last else 0.0
        p = p + z * (d - p[2]) / z[2]
        a = float(np.hypot(p[0], p[1]))
        theta = float(np.arctan2(p[1], p[0])) if a > SAME else 0.0
    else:
        x = normal / size
        # p + t z = d e_z + a x, along e_z, x and their cross product
        y = np.cross([0.0, 0.0, 1.0], x)
        t = -(p @ y) / (z @ y)
        d, a = float(p[2] + t * z[2]), float(p @ x)
        theta = float(np.arctan2(x[1], x[0]))
    if abs(theta) > np.pi / 2 + SAME:
        theta, a = theta - np.copysign(np.pi, theta), -a
    c, s = np.cos(theta), np.sin(theta)
    x, y = c * z[0] + s * z[1], c * z[1] - s * z[0]
    beta = float(np.arcsin(np.clip(x, -1, 1))) if size < np.sin(PARALLEL) else 0.0
    return np.array([theta, d, a, float(np.arctan2(-y, z[2])), beta])


def write(content: Content, header: list[str]) -> Files:
    """standard.csv, modified.csv, hayati.csv, and frames.csv with base and flange."""
    table = table_of(content.arm)
    names = content.robot.joint_names
    rows = table.rows
    before = np.vstack([np.zeros(5), rows[:-1]])
    standard = _csv(["joint", "theta_deg", "d_mm", "a_mm", "alpha_deg"], names, rows[:, [0, 1, 2, 3]])
    hayati = _csv(["joint", "theta_deg", "d_mm", "a_mm", "alpha_deg", "beta_deg"], names, rows)
    modified = np.column_stack([before[:, 3], before[:, 2], rows[:, 0], rows[:, 1]])
    places = np.array([[*X[:3, 3], *rpy(X[:3, :3])] for X in (table.base, table.tool)])
    columns = ["frame", "x_mm", "y_mm", "z_mm", "roll_deg", "pitch_deg", "yaw_deg"]
    head = commented(header)
    return {
        "hayati.csv": head + hayati,
        "standard.csv": head + standard,
        "modified.csv": head
        + _csv(["joint", "alpha_before_deg", "a_before_mm", "theta_deg", "d_mm"], names, modified),
        "frames.csv": head + _csv(columns, ("base to frame 0", f"frame {len(names)} to flange"), places),
    }


def notes(content: Content) -> list[str]:
    """How to read the tables, and what standard and modified rows lose."""
    table, q = table_of(content.arm), content.problem.q
    far = 1e3 * np.linalg.norm((table.without_beta.flange(q) - table.flange(q))[:, :3, 3], axis=1)
    return [
        "hayati: Rz(theta + q) Tz(d) Tx(a) Rx(alpha) Ry(beta), exact; standard: the same without beta;",
        "modified: Tx(a_before) Rx(alpha_before) Rz(theta + q) Tz(d), then the last a and alpha of standard;",
        "frames: base to frame 0, last frame to flange; Rz(yaw) Ry(pitch) Rx(roll); a sliding q adds to d",
        f"standard and modified lose beta: {far.mean():.3f} mm on average, {far.max():.3f} mm at most",
    ]


def _csv(columns: list[str], names: tuple[str, ...], values: Array) -> str:
    """A table; columns that end in _deg and _mm come in rad and m."""
    factor = [np.degrees(1.0) if column.endswith("_deg") else 1e3 for column in columns[1:]]
    lines = [",".join(columns)]
    for name, row in zip(names, values, strict=True):
        lines.append(",".join([name, *(number(round(v * f, 10)) for v, f in zip(row, factor, strict=True))]))
    return "\n".join(lines) + "\n"

"""Work W1: a geometric calibration, judged on other poses by the Cramér–Rao bound.

KR 500-like arm in standard DH. 200 random poses to fit, 200 others to judge; every DH parameter is off by
N(0, 0.5 mm) or N(0, 0.02°), once with and once without a twist error between the parallel axes 2 and 3.
Instrument frame and the three targets are unknown; noise 0.03 mm per axis. The true points come from
Drake, which reads a URDF with the true numbers. The bound counts the parameters that are really off; the
fit is not told which: it has six corrections per joint, and no mask.

Wall time is registration and fit together, beside SciPy's least_squares on the same model and data.
"""

from __future__ import annotations

import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from workbench.campaign import Target
from workbench.campaign.planned import planned
from workbench.campaign.problem import Problem, problem_of
from workbench.identification.fit import Fit, fit, start_state
from workbench.identification.model import Model, State, move_frame
from workbench.identification.noise import Covariance
from workbench.identification.parameters import Columns, columns
from workbench.robot.description import Robot, load_robot
from workbench.robot.kinematics import Array
from workbench.robot.rigid_plant import rigid_twin

DH_A = np.array([0.5, 1.3, -0.055, 0.0, 0.0, 0.0])
DH_ALPHA = np.radians([-90.0, 0.0, 90.0, -90.0, 90.0, 0.0])
DH_D = np.array([1.045, 0.0, 0.0, -1.025, 0.0, -0.29])
SPREAD_Q = np.radians([120.0, 40.0, 60.0, 150.0, 100.0, 150.0])
MIDDLE_Q = np.radians([0.0, -60.0, 60.0, 0.0, 60.0, 0.0])
LENGTH, ANGLE, SIGMA = 5e-4, np.radians(0.02), 3e-5
FIT, JUDGE = 200, 200
SCIPY_RUNS = 3


@dataclass(frozen=True)
class Table:
    """Standard DH, Rz(θ) Tz(d) Tx(a) Rx(α), six rows; β: a turn about y after each row."""

    theta: Array
    d: Array
    a: Array
    alpha: Array
    beta: Array


NOMINAL = Table(np.zeros(6), DH_D, DH_A, DH_ALPHA, np.zeros(6))


def drawn(rng: np.random.Generator, twist: bool) -> Table:
    """The true arm."""
    error = rng.normal(size=(4, 6))
    beta = np.array([0, ANGLE * rng.normal(), 0, 0, 0, 0]) if twist else np.zeros(6)
    theta, alpha = ANGLE * error[0], DH_ALPHA + ANGLE * error[3]
    return Table(theta, DH_D + LENGTH * error[1], DH_A + LENGTH * error[2], alpha, beta)


def write_robot(folder: Path, table: Table) -> Path:
    """URDF and TOML of a DH table."""
    parts = ['<robot name="w1"><link name="link_0"/>']
    for i in range(7):
        p, R = np.zeros(3), Rotation.identity()
        if i > 0:
            p = np.array([table.a[i - 1], 0.0, table.d[i - 1]])
            R = Rotation.from_euler("XY", [table.alpha[i - 1], table.beta[i - 1]])
        if i < 6:
            R = R * Rotation.from_euler("z", table.theta[i])
        name, kind = (f"joint_{i + 1}", "continuous") if i < 6 else ("mount", "fixed")
        child = f"link_{i + 1}" if i < 6 else "flange"
        xyz, rpy = (" ".join(f"{x:.17g}" for x in v) for v in (p, R.as_euler("xyz")))
        parts.append(
            f'<link name="{child}"/><joint name="{name}" type="{kind}"><parent link="link_{i}"/>'
            f'<child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/></joint>'
        )
    (folder / "w1.urdf").write_text("".join(parts) + "</robot>", encoding="utf-8")
    path = folder / "w1.toml"
    path.write_text('schema = 1\nname = "w1"\nurdf = "w1.urdf"\nflange = "flange"\n', encoding="utf-8")
    return path


def drake_points(robot: Robot, q: Array, targets: Array) -> Array:
    """(N, 3, 3) the targets in the base frame, by Drake."""
    twin = rigid_twin(robot)
    flange, world = twin.plant.GetFrameByName(robot.flange), twin.plant.world_frame()
    out = np.empty((len(q), len(targets), 3))
    for i in range(len(q)):
        twin.set_positions(q[i])
        out[i] = twin.plant.CalcPointsPositions(twin.context, flange, targets.T, world).T
    return out


def measure(nominal: Robot, folder: Path, seed: int, twist: bool) -> tuple[Problem, Problem]:
    """The campaign to fit, with noise, and the one to judge by, without."""
    rng = np.random.default_rng([seed, int(twist)])
    true = load_robot(write_robot(folder, drawn(rng, twist)))
    q = MIDDLE_Q + SPREAD_Q * rng.uniform(-1, 1, (FIT + JUDGE, 6))
    targets = np.array([[0.12, 0, 0.1], [-0.06, 0.1, 0.12], [-0.06, -0.1, 0.15]]) + rng.normal(
        0, 0.01, (3, 3)
    )
    R = Rotation.random(random_state=np.random.RandomState(seed)).as_matrix()
    points = drake_points(true, q, targets) @ R.T + rng.uniform(-4, 4, 3)
    points[:FIT] += SIGMA * rng.normal(size=(FIT, 3, 3))
    parts = []
    for here in (slice(0, FIT), slice(FIT, None)):
        plan = planned(nominal, q[here], targets=tuple(Target(name) for name in ("T1", "T2", "T3")))
        shots = np.ones((len(plan.poses.q), 3), dtype=np.int64)
        parts.append(replace(plan, points=points[here], shots=shots))
    first = problem_of(parts[0])
    return first, Problem(nominal, first.arm, parts[1])


def calibrate(problem: Problem) -> Fit:
    """The whole of what is timed."""
    noise = Covariance(np.full((FIT, 3), SIGMA), np.zeros(6), np.ones(FIT))
    return fit(Model(problem), start_state(problem), noise)


def over_bound(result: Fit, judge: Problem, twist: bool) -> float:
    """Root mean square error on the poses to judge by, over its Cramér–Rao bound."""
    error = Model(judge).predict(result.state) - judge.campaign.points
    off = ("tx", "tz", "rx", "rz")  # of Tx(a) Rx(α), Tz(d), Rz(θ) in the frame of the next joint
    names = result.columns.names
    mine = [not n.startswith("geometry") or n.endswith(off) or (twist and n == "geometry/joint_3/ry")
            for n in names]  # fmt: skip
    scale = result.columns.prior[mine]
    J = result.J.reshape(-1, len(names))[:, mine] * scale
    other = fit(Model(judge), result.state, replace(result.noise, weight=np.ones(JUDGE)), max_iterations=1)
    # both turn the instrument's frame about the middle of their own points
    J_judge = other.J.reshape(JUDGE, 3, 3, -1)
    J_judge[..., 3:6] += np.cross(np.eye(3), other.line.centre[0] - result.line.centre[0]).T / SIGMA
    J_judge = J_judge.reshape(-1, len(names))[:, mine] * scale
    _, s, Vt = np.linalg.svd(J, full_matrices=False)
    kept = s > 1e-9 * s[0]
    bound = SIGMA * np.linalg.norm(J_judge @ (Vt[kept].T / s[kept])) / np.sqrt(error.size)
    return float(np.sqrt(np.mean(error**2)) / bound)


def moved(problem: Problem, cols: Columns, start: State, step: Array) -> State:
    """The state at fitted numbers `step` from the start."""
    state = move_frame(start, 0, start.t[0], step[:6])
    targets, geometry = start.targets.copy(), start.geometry.copy()
    for k, i, part in cols.targets:
        targets[k, i] += step[part]
    geometry.reshape(-1)[cols.geometry] += step[cols.geometry_slice]
    return replace(state, targets=targets, geometry=geometry)


def plain_scipy(problem: Problem) -> Array:
    """Least squares with finite differences from the same start; returns the fit's residuals."""
    start, cols, model = start_state(problem), columns(problem, ()), Model(problem)

    def misfit(x: Array) -> Array:
        return (model.predict(moved(problem, cols, start, x)) - problem.campaign.points).ravel() / SIGMA

    return np.asarray(least_squares(misfit, np.zeros(len(cols.names)), method="trf", x_scale="jac").fun)


def series(nominal: Robot, folder: Path, seeds: int, twist: bool) -> None:
    """Fits and judges one campaign per seed, and prints what came out."""
    ratios, walls, others = np.empty(seeds), np.empty(seeds), []
    for seed in range(seeds):
        problem, judge = measure(nominal, folder, seed, twist)
        begin = time.perf_counter()
        result = calibrate(problem)
        walls[seed] = 1e3 * (time.perf_counter() - begin)
        ratios[seed] = over_bound(result, judge, twist)
        if seed < SCIPY_RUNS:
            begin = time.perf_counter()
            plain_scipy(problem)
            others.append(1e3 * (time.perf_counter() - begin))
    rms, spread = np.sqrt(np.mean(ratios**2)), np.std(ratios) / np.sqrt(seeds)
    wall, other = np.median(walls[:SCIPY_RUNS]), np.median(others)
    print("with a twist error on the parallel axes" if twist else "DH errors only", f"({seeds} seeds)")
    # the bound is one on mean squares
    print(f"  held-out error over bound: rms {rms:.3f} ± {spread:.3f}, mean {ratios.mean():.3f}, "
          f"seed 0 {ratios[0]:.2f}, worst {ratios.max():.2f}")  # fmt: skip
    print(f"  a fit: {np.median(walls):.1f} ms (best {walls.min():.1f}); plain SciPy {other:.0f} ms, "
          f"{other / wall:.0f} times that of the same data")  # fmt: skip


def main() -> None:
    seeds = 10 if "--quick" in sys.argv[1:] else 200
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        true_folder = folder / "true"
        true_folder.mkdir()
        nominal = load_robot(write_robot(folder, NOMINAL))
        for twist in (False, True):
            series(nominal, true_folder, seeds, twist)


if __name__ == "__main__":
    main()

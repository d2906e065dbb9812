"""What the printed tables of the long-link arm explain: their difference, what bends, what leaves 1.78 mm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from workbench.campaign.planned import planned
from workbench.identification.deflection import deflection, deflection_budget, with_compliance
from workbench.identification.denavit_hartenberg import chain, with_rows
from workbench.measurement.zeros_and_offsets import SimulatedArm, identified, misses, with_ball
from workbench.robot.description import Robot
from workbench.robot.kinematics import Array
from workbench.studies.longlink.figures import Items, budget_figure, entries_table, left_figure, tables_figure
from workbench.studies.telling import each

FAULTS = {"compliance": (0.01, 1.0), "ratio": (1e-4, 1e-2), "twist": (1e-5, 1e-2), "noise": (1e-4, 5e-3)}
RANGES = {"45": (45, -9.0), "60": (60, -9.0), "90": (90, -9.0), "floor": (90, -0.9)}  # ± °, lowest z [m]
Told = tuple[dict[str, float], Items]


def two_tables(arm: SimulatedArm, before: float, judged: int, seed: int, count: int) -> Told:
    """What the practical table changes against the nominal one at the tip, in random poses.

    before: printed mean [mm] over so many `judged` points.
    """
    numbers = {"draws": float(count)}
    for name, (limit, lowest) in RANGES.items():
        q = arm.poses(count, seed, limit)
        where = chain(arm.nominal, q)[:, :, :3, 3]
        size = np.linalg.norm(1e3 * (chain(arm.practical, q)[:, -1, :3, 3] - where[:, -1]), axis=1)
        size = size[where[:, 3:, 2].min(axis=1) > lowest]
        scatter = float(size.std() / np.sqrt(judged))
        low, high = np.quantile(size, (0.05, 0.95))
        numbers |= {f"mean_{name}_mm": size.mean(), f"low_{name}_mm": low, f"high_{name}_mm": high}
        numbers |= {f"scatter_{name}_mm": scatter, f"away_{name}": (before - size.mean()) / scatter}

    q = arm.poses(count, seed)
    nominal = chain(arm.nominal, q)[:, -1, :3, 3]

    def moved(table: Array) -> Array:
        return np.asarray(1e3 * (chain(table, q)[:, -1, :3, 3] - nominal))

    whole, sizes, shares = moved(arm.practical), {}, {}
    for row, column in np.ndindex(arm.nominal.shape):
        table = arm.nominal.copy()
        table[row, column] = arm.practical[row, column]
        name, alone = f"{'θαad'[column]}{'₁₂₃₄₅₆₇'[row]}", moved(table)
        sizes[name] = float(np.linalg.norm(alone, axis=1).mean())
        shares[name] = float((alone * whole).sum() / (whole**2).sum())
        if name == "α₁":
            numbers["without_alpha_1_mm"] = float(np.linalg.norm(whole - alone, axis=1).mean())
    lengths = sum(share for name, share in shares.items() if name[0] in "ad")
    numbers |= {"share_alpha_1": shares["α₁"], "share_lengths": lengths}
    numbers["z_largest"] = z_largest(whole, judged)
    size = np.linalg.norm(whole, axis=1)
    return numbers, {"tables": tables_figure(size, before), "entries": entries_table(sizes, shares)}


def z_largest(error: Array, judged: int) -> float:
    """How often the mean |z| of so many errors (N, 3) is the largest of the three."""
    means = np.abs(error[: len(error) // judged * judged].reshape(-1, judged, 3)).mean(axis=1)
    return float(np.mean(means.argmax(axis=1) == 2))


def what_bends(arm: SimulatedArm, robot: Robot, bending: Array, seed: int, count: int) -> Told:
    """Motion of the tip by joint, bearing and link: printed bending stiffness (n,) [N·m²], assumed joints."""
    plan = planned(robot, arm.poses(count, seed), targets=arm.targets[:1], payloads=arm.payloads)
    own, loaded = (deflection_budget(replace(plan, payload=np.full_like(plan.payload, k))) for k in (0, 1))
    size, size_loaded = ({kind: mean_mm(part) for kind, part in b.parts.items()} for b in (own, loaded))
    length = arm.nominal[:, 2:].max(axis=1)
    printed = 1e3 * own.moment.max(axis=0) * length**2 / 3 / bending  # eq. (21)
    numbers = {
        **each("eq21_um", 1e3 * printed),
        **each("link_own_um", 1e3 * size["link"]),
        **each("link_loaded_um", 1e3 * size_loaded["link"]),
        **each("torsion_mm", size["torsion"]),
        **each("overturning_mm", size["overturning"]),
        "bending_own_mm": float(mean_mm(own.parts["link"].sum(axis=1))),
        "bending_loaded_mm": float(mean_mm(loaded.parts["link"].sum(axis=1))),
        "bending_eq21_mm": float(printed.max()),
        "sag_mm": float(mean_mm(own.whole)),
    }
    return numbers, {"budget": budget_figure(size_loaded, float(mean_mm(loaded.whole)))}


def mean_mm(moved: Array) -> Array:
    """Mean length [mm] of motions (N, ..., 3) [m] over the poses."""
    return np.asarray(1e3 * np.linalg.norm(moved, axis=-1).mean(axis=0))


def what_leaves(
    arm: SimulatedArm, assumed: Robot, after: float, counts: tuple[int, int], seed: int, draws: int
) -> Told:
    """The size of each fault that leaves the printed mean `after` [mm] when d and θ alone are fitted.

    assumed: the robot with the compliance of its TOML; counts: of points that are fitted, and that judge.
    """

    def tried(fault: str, size: float) -> Array:
        """(draws, 2) [mm] before and after."""
        return np.array([one_fault(arm, assumed, {fault: size}, counts, [seed, k]) for k in range(draws)])

    def beyond(size: float, fault: str) -> float:
        return float(tried(fault, size)[:, 1].mean() - after)

    numbers = {"draws_12": float(draws)}
    for fault, (low, high) in FAULTS.items():
        left = brentq(beyond, low, high, args=(fault,), rtol=0.01, xtol=low / 10)
        means = tried(fault, left)
        numbers |= {f"{fault}_leaves": left, f"{fault}_before_mm": means[:, 0].mean()}
        numbers |= {f"{fault}_scatter_mm": means[:, 1].std()}
    share = numbers["compliance_leaves"]
    full = tried("compliance", 1.0).mean(axis=0)
    yielding = tip_error(arm, with_compliance(assumed, share), arm.poses(1200, [seed, 4]))
    steps = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
    left_by_step = [tried("compliance", step)[:, 1].mean() for step in steps]
    numbers |= {
        "share": share,
        "stiffer": 1 / share,
        "stiffness_2_kNm": 1e-3 * (assumed.joints[1].data.stiffness or np.inf) / share,
        "full_before_mm": full[0],
        "full_after_mm": full[1],
        "z_largest_yielding": z_largest(yielding, counts[1]),
        "twist_leaves_deg": float(np.degrees(numbers["twist_leaves"])),
        "noise_leaves_mm": 1e3 * numbers["noise_leaves"],
        "right_leaves_mm": float(left_by_step[0]),
    }
    return numbers, {"left": left_figure(steps, left_by_step, share, after)}


def tip_error(arm: SimulatedArm, robot: Robot, q: Array) -> Array:
    """(N, 3) [m] the practical table with its deflection minus the nominal one without, at the tip."""
    built = with_rows(robot, arm.nominal, arm.practical)
    sag = deflection(planned(built, q, targets=arm.targets[:1]))[:, 0]
    return np.asarray(chain(arm.practical, q)[:, -1, :3, 3] - chain(arm.nominal, q)[:, -1, :3, 3] + sag)


def one_fault(
    arm: SimulatedArm,
    assumed: Robot,
    fault: Mapping[str, float],
    counts: tuple[int, int],
    seed: Sequence[int],
) -> tuple[float, float]:
    """Mean error [mm] on points that judge, before and after d and θ are fitted to others, with a fault."""
    rng, n, (fitted, judging) = np.random.default_rng([*seed, 1]), len(arm.nominal), counts
    q = arm.poses(fitted + judging, seed)
    true, rigid = with_compliance(assumed, fault.get("compliance", 0.0)), with_compliance(assumed, 0.0)
    ratio, sigma = fault.get("ratio", 0.0) * rng.normal(size=n), fault.get("noise", arm.sigma)
    made = arm.measured(true, q[:fitted], [*seed, 2], ratio=ratio, sigma=sigma)
    judged = arm.measured(true, q[fitted:], [*seed, 3], ratio=ratio, sigma=sigma)
    known = np.column_stack([arm.nominal[:, 0], arm.practical[:, 1:3], arm.nominal[:, 3]])
    known[:, 1] += fault.get("twist", 0.0) * rng.normal(size=n)
    before = identified(made, rigid, [])
    after = identified(with_ball(made, arm.practical[-1, 2]), with_rows(rigid, arm.nominal, known))
    return float(misses(before, judged).mean()), float(misses(after, judged).mean())

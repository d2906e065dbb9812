"""The page, the table and the scene of `workbench predict`: the error to be expected at the tool."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ..correction.command import anew_mm
from ..files.tables import table_text
from ..identification.prediction import ToolErrors, ToolTurns, required_uncertainty
from ..robot.description import Robot
from ..robot.kinematics import Array
from .drawing import AFTER, BEFORE, MIDDLE, Figure, drawing, plain_log
from .expected_scene import expected_scene
from .folder import json_bytes, write_together
from .markup import render
from .numbers import mm
from .workspace_map import workspace_map

HEAD = (
    "pose_id", "target", "x_mm", "y_mm", "z_mm", "dx_mm", "dy_mm", "dz_mm",
    "error_mm", "nominal_bound_mm", "corrected_bound_mm", "outside", "beyond_limits",
)  # fmt: skip
TURNED = (
    "turn_error_mrad",
    "turn_nominal_bound_mrad",
    "turn_corrected_bound_mrad",
)  # where poses were measured
MISSED, LEFT = "What an uncorrected program misses", "What is left after correction (95 % bound)"
LISTED = 6  # poses beyond limits, by name
REASONS = 10  # why poses lie outside of what was measured
IN_BASE = (
    "Errors are those of the tool's points in the robot's base, as the targets on it say where that is; how "
    "well they do is in the bounds."
)
ANEW = (
    "Errors are those of the tool's points with base and tool set up as well as the campaign allows: taken "
    "anew, for the uncorrected robot as for the corrected one."
)
BOUND = (
    "A bound holds for one standstill with 95 %: uncertainty of the fitted numbers, what is left unknown, "
    "and the joints' repeatability, tempered so that 95 % of the errors at poses held out lie inside."
)


@dataclass(frozen=True)
class Expected:
    """What `predict` says. tolerance: [m], None where none was given; inputs: "<folder>/<file>" → SHA-256."""

    robot: Robot
    errors: ToolErrors
    tolerance: float | None = None
    inputs: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def inside(self) -> ToolErrors | None:
        """What is expected at the poses within what was measured; None where there are none."""
        return self.errors.some(self.errors.measured) if self.errors.measured.any() else None

    @property
    def headline(self) -> str:
        """The errors, in a sentence."""
        e, count = self.inside, len(self.errors.outside)
        if e is None:
            return f"None of {count} poses lies within what was measured: nothing can be said of them"
        median, most = (mm(1e3 * float(bound)) for bound in np.quantile(e.worst, [0.5, 0.95]))
        return (
            f"An uncorrected program misses by {mm(1e3 * float(e.length.mean()))} mm (mean of "
            f"{len(e.outside)} poses); after correction the tool stays within {median} mm at half of them, "
            f"within {most} mm at 95 %"
        )

    @property
    def frame(self) -> str:
        """In what frame the errors are."""
        if not self.errors.in_base:
            return ANEW
        if self.inside is None:
            return IN_BASE
        e = self.inside
        left = mm(float(anew_mm(e.places.reshape(-1, 3), e.error.reshape(-1, 3)).mean()))
        return f"{IN_BASE} Uncorrected, {left} mm are left once the base or the work object is taken anew."

    @property
    def turned(self) -> str:
        """The errors of the tool's turn, in a sentence; "" of a model that was not measured as poses."""
        e = self.inside
        if e is None or e.turns is None:
            return ""
        median, most = 1e3 * np.quantile(e.turns.corrected, [0.5, 0.95])
        return (
            f"Uncorrected, the tool is turned off by {1e3 * float(e.turns.angle.mean()):.2g} mrad (mean); "
            f"after correction it keeps its orientation within {median:.2g} mrad at half of the poses, "
            f"within {most:.2g} mrad at 95 %."
        )

    @property
    def scope(self) -> str:
        """Of which poses that is; "" where of all."""
        count, within = len(self.errors.outside), int(self.errors.measured.sum())
        if within in (0, count):
            return ""
        lie = "lies" if within == 1 else "lie"
        return f"{within} of {count} poses {lie} within what was measured; the figures are of these alone."

    @property
    def kept(self) -> str:
        """How many poses keep to the tolerance; "" where none was given."""
        if self.tolerance is None or self.inside is None:
            return ""
        before, after = self.inside.share_inside(self.tolerance)
        return (
            f"Inside {1e3 * self.tolerance:.3g} mm with 95 %: at {100 * after:.0f} % of these poses, "
            f"uncorrected at {100 * before:.0f} %."
        )

    @property
    def beyond_limits(self) -> list[str]:
        """Which poses have joints beyond their limits, in words."""
        found: dict[str, list[str]] = {}
        for name, said in zip(self.errors.campaign.poses.ids, self.errors.beyond_limits, strict=True):
            if said:
                found.setdefault(said, []).append(name)
        return [
            f"beyond the limits of {joints}: poses {', '.join(ids[:LISTED])}"
            + (f" and {len(ids) - LISTED} more" if len(ids) > LISTED else "")
            for joints, ids in found.items()
        ]

    @property
    def of_tool(self) -> str:
        """Whose tool that is, of a model of several campaigns; "" of one."""
        data = required_uncertainty(self.robot)
        names = ", ".join(point.name for point in data.points)
        return f"The points are those of the tool of {data.campaign}: {names}." if data.campaign else ""

    @property
    def notes(self) -> list[str]:
        return [*filter(None, [self.of_tool]), *self.errors.notes, *self.beyond_limits]

    @property
    def outside(self) -> list[str]:
        """Which poses lie outside of what was measured, in words."""
        beyond = [said for said in self.errors.outside if said]
        if not beyond:
            return ["All poses lie inside of what was measured."]
        out, why = len(beyond), Counter(one for said in beyond for one in said.split("; "))
        many = ", one pose by several" if sum(why.values()) > out else ""
        lines = [
            f"{out} of {len(self.errors.outside)} poses {'lies' if out == 1 else 'lie'} outside of what was "
            f"measured, by these joints, by what they carry or how warm it is{many}: what the table has of "
            "them is extrapolated"
        ]
        lines += [f"{said}: {count} pose{'s' * (count > 1)}" for said, count in why.most_common(REASONS)]
        return lines + ([f"and {len(why) - REASONS} more"] if len(why) > REASONS else [])

    @property
    def text(self) -> str:
        return "\n".join(
            [
                *filter(None, (self.scope, f"{self.headline}.", self.turned, self.kept, self.frame)),
                *self.outside,
                *filter(None, [self.of_tool]),
                *self.errors.notes,
            ]
        )

    def to_json(self) -> dict[str, Any]:
        e = self.errors
        names = [target.name for target in e.campaign.targets]
        out: dict[str, Any] = {
            "schema": 1,
            "robot": self.robot.name,
            "n_poses": len(e.outside),
            "targets": names,
            "nominal": _figures(e.length, e.nominal.max(axis=1)),
            "corrected": _figures(None, e.worst),
            "in_base": e.in_base,
            "outside": sum(bool(said) for said in e.outside),
            "inside": self._inside_json(),
            "notes": self.notes,
        }
        if self.tolerance is not None:
            before, after = e.share_inside(self.tolerance)
            out["tolerance"] = {
                "tolerance_mm": 1e3 * self.tolerance,
                "nominal_share": before,
                "corrected_share": after,
            }
        rows = zip(
            e.campaign.poses.ids,
            e.length.max(axis=1),
            e.nominal.max(axis=1),
            e.worst,
            e.outside,
            e.beyond_limits,
            strict=True,
        )
        out["poses"] = [
            {
                "pose_id": name,
                "error_mm": 1e3 * float(error),
                "nominal_bound_mm": 1e3 * float(nominal),
                "corrected_bound_mm": 1e3 * float(bound),
                "outside": said,
                "beyond_limits": beyond,
            }
            for name, error, nominal, bound, said, beyond in rows
        ]
        if e.turns is not None:
            for pose, *row in zip(out["poses"], *_mrad(e.turns), strict=True):
                pose |= dict(zip(TURNED, map(float, row), strict=True))
        out["inputs"] = dict(self.inputs)
        return out

    def _inside_json(self) -> dict[str, Any] | None:
        """The same figures of the poses within what was measured alone."""
        e = self.inside
        if e is None:
            return None
        nominal, corrected = _figures(e.length, e.nominal.max(axis=1)), _figures(None, e.worst)
        out: dict[str, Any] = {"n_poses": len(e.outside), "nominal": nominal, "corrected": corrected}
        if self.tolerance is not None:
            before, after = e.share_inside(self.tolerance)
            out |= {"nominal_share": before, "corrected_share": after}
        return out


def _mrad(turns: ToolTurns) -> tuple[Array, Array, Array]:
    """(N,) [mrad] each, as `TURNED` has them."""
    return 1e3 * turns.angle, 1e3 * turns.nominal, 1e3 * turns.corrected


def _figures(error: Array | None, bound: Array) -> dict[str, float]:
    mean = {} if error is None else {"error_mean_mm": 1e3 * float(error.mean())}
    half, most = (1e3 * float(v) for v in np.quantile(bound, [0.5, 0.95]))
    return {**mean, "bound_median_mm": half, "bound_95_mm": most, "bound_max_mm": 1e3 * float(bound.max())}


def write_expected(expected: Expected, folder: Path) -> None:
    """Writes `index.html`, `scene.html`, `errors.csv` and `predict.json`, after all of them are made."""
    e, robot = expected.errors, expected.robot
    title = f"{robot.title}: error at the tool"
    page = render(
        "predict.html",
        title=title,
        headline=expected.headline,
        more=[said for said in (expected.scope, expected.turned, expected.kept) if said],
        words=(expected.frame, BOUND),
        outside=expected.outside,
        notes=expected.notes,
        figures=[] if expected.inside is None else [_shares(expected, expected.inside), *_maps(expected)],
        inputs=expected.inputs.items(),
        version=version("robot-workbench"),
    )
    values = {MISSED: e.length.mean(axis=1), LEFT: e.worst}
    measured = required_uncertainty(robot).measured
    made = {
        "index.html": page.encode(),
        "scene.html": expected_scene(robot, e, values, measured, title).encode(),
        "errors.csv": table_text((*HEAD, *(TURNED if e.turns else ())), _rows(e)).encode(),
        "predict.json": json_bytes(expected.to_json()),
    }
    write_together(folder, made)


def _rows(e: ToolErrors) -> list[Sequence[str]]:
    """The table, a row for each pose and target."""
    numbers = np.concatenate(
        [e.places, e.error, e.length[..., None], e.nominal[..., None], e.corrected[..., None]], axis=2
    )
    turns = np.transpose(_mrad(e.turns)) if e.turns else np.zeros((len(e.outside), 0))
    return [
        [
            name,
            target.name,
            *(f"{1e3 * value:.4f}" for value in numbers[i, t]),
            e.outside[i],
            beyond,
            *(f"{value:.4f}" for value in turns[i]),
        ]
        for i, (name, beyond) in enumerate(zip(e.campaign.poses.ids, e.beyond_limits, strict=True))
        for t, target in enumerate(e.campaign.targets)
    ]


def _shares(expected: Expected, e: ToolErrors) -> Figure:
    """Share of the poses within what was measured, e, over the bound."""
    share = np.arange(1, len(e.worst) + 1) / len(e.worst) * 100
    with drawing("shares", 2.8) as (axes, svg):
        for bound, colour, label in (
            (e.worst, AFTER, "corrected"),
            (e.nominal.max(axis=1), BEFORE, "uncorrected"),
        ):
            axes.plot(1e3 * np.sort(bound), share, color=colour, label=label)
        if expected.tolerance is not None:
            label = f"tolerance, {1e3 * expected.tolerance:g} mm"
            axes.axvline(1e3 * expected.tolerance, color=MIDDLE, ls="--", lw=1.2, label=label)
        axes.set_xscale("log")
        plain_log(axes.xaxis)
        axes.set_xlabel("95 % bound of the error, mm")
        axes.set_ylabel("poses inside, %")
        axes.legend()
    return Figure("shares", "At how many poses the tool stays inside", expected.headline, svg[0])


def _maps(expected: Expected) -> list[Figure]:
    """What an uncorrected program misses, and what is left after correction, over the workspace."""
    e, measured = expected.errors, required_uncertainty(expected.robot).measured
    places, outside = e.places.mean(axis=1), ~e.measured
    return [
        workspace_map(
            "missed",
            f"{MISSED} (mean of the tool's points)",
            places,
            e.length.mean(axis=1),
            outside,
            measured,
        ),
        workspace_map("left", LEFT, places, e.worst, outside, measured),
    ]

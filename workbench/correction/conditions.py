"""What the arm carries and feels along a path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..campaign import Campaign
from ..campaign.planned import planned
from ..files.faults import Fault, InputError
from ..robot.description import Robot
from ..robot.kinematics import Array
from ..robot.schema import LoadData
from .paths import Path

NO_LOAD = LoadData(mass_kg=0.0)
SAME = 0.02  # of a load and of its moment: what people write down differently
FAR_MM = 100.0  # from the flange, where a load is as a rule


@dataclass(frozen=True, eq=False)
class Conditions:
    """Loads and state of the arm along a path of N samples; SI units, lengths in the flange frame.

    payload: its name, as the model knows it ("": none); mass and centre of mass as stated there.
    wrench: (6,) or (N, 6) [N, N·m] on the robot at the flange origin, base frame (a cutting force, say).
    temperature: [degC], one or (N,); None: the arm is at 20 °C. clock: the time `t_s` of the campaign at
    the path's start [s], for what drifts or warms up; None: neither has moved.
    """

    payload: str = ""
    payload_mass: float = 0.0
    payload_com: Sequence[float] = (0.0, 0.0, 0.0)
    tool_mass: float = 0.0
    tool_com: Sequence[float] = (0.0, 0.0, 0.0)
    wrench: Array | Sequence[float] | None = None
    temperature: Array | float | None = None
    clock: float | None = None


def conditions_of(campaign: Campaign, payload: str = "") -> Conditions:
    """The tool and the named payload ("": none) as a campaign states them.

    Raises `InputError` with the names that there are, when it has no such payload.
    """
    if payload not in campaign.payload_names:
        known = ", ".join(campaign.payload_names[1:]) or "none"
        raise InputError(Fault(f"payload {payload!r}", "is not in the campaign", f"known: {known}"))
    k = campaign.payload_names.index(payload)
    return Conditions(
        payload,
        float(campaign.load_mass[k]),
        campaign.load_com[k].tolist(),
        campaign.tool_mass,
        campaign.tool_com.tolist(),
    )


def stated_conditions(robot: Robot, payload: str = "") -> Conditions:
    """The tool and the named payload ("": none) as the robot's own TOML states them (a model.toml); without a
    name, where tools are payloads, the one that is mounted.

    Raises `InputError` with the names that there are, when it has no such payload.
    """
    payload = payload or robot.mounted
    if payload and payload not in robot.payloads:
        known = ", ".join(robot.payloads) or "none"
        mend = f"known: {known}; or name the campaign that states it"
        raise InputError(Fault(f"payload {payload!r}", f"is not in {robot.path or robot.name}", mend))
    load, tool = robot.payloads.get(payload, NO_LOAD), robot.tool or NO_LOAD
    return Conditions(payload, load.mass_kg, _metres(load), tool.mass_kg, _metres(tool))


def carried(conditions: Conditions) -> LoadData | None:
    """Tool and payload together, as a controller is told; None where they weigh nothing."""
    mass = conditions.payload_mass + conditions.tool_mass
    if not mass > 0:
        return None
    moment = conditions.payload_mass * np.array(conditions.payload_com)
    moment += conditions.tool_mass * np.array(conditions.tool_com)
    x, y, z = (1e3 * moment / mass).tolist()
    return LoadData(mass_kg=mass, com_mm=(x, y, z))


def alike(one: LoadData, other: LoadData | None) -> bool:
    """Whether two loads at the flange are the same for what an arm yields."""
    other = other or NO_LOAD
    off = one.mass_kg * np.array(one.com_mm) - other.mass_kg * np.array(other.com_mm)
    heavier = max(one.mass_kg, other.mass_kg)
    far = FAR_MM + float(np.linalg.norm(one.com_mm))
    return abs(one.mass_kg - other.mass_kg) <= SAME * heavier and bool(
        np.linalg.norm(off) <= SAME * heavier * far
    )


def _metres(load: LoadData) -> list[float]:
    return [1e-3 * value for value in load.com_mm]


def path_campaign(robot: Robot, path: Path, q: Array, conditions: Conditions) -> Campaign:
    """The path as poses that nobody measures. q: (N, n) joints. Raises `InputError`."""
    faults: list[Fault] = []
    if path.wrench is not None and conditions.wrench is not None:
        faults.append(Fault(path.place(0), "the path has a wrench of its own", "give it once"))
    wrench = path.wrench if path.wrench is not None else conditions.wrench
    temperature = path.temperature if path.temperature is not None else conditions.temperature
    wrench = _along("wrench", np.zeros(6) if wrench is None else wrench, (len(q), 6), faults)
    if temperature is not None:
        temperature = _along("temperature", temperature, (len(q),), faults)
    mass, com = _payload(conditions, faults)
    tool = _along("tool: centre of mass", conditions.tool_com, (3,), faults)
    for what, value in (("payload: mass", mass), ("tool: mass", conditions.tool_mass)):
        if not (np.isfinite(value) and value >= 0):
            faults.append(Fault(what, f"is {value} kg", "give zero or more"))
    if faults:
        raise InputError(faults)
    return planned(
        robot,
        q,
        targets=(),
        payloads={conditions.payload: (mass, com.tolist())} if conditions.payload else None,
        payload=[conditions.payload] * len(q) if conditions.payload else None,
        tool=(conditions.tool_mass, tool.tolist()),
        wrench=wrench,
        time=None if conditions.clock is None else conditions.clock + path.time - path.time[0],
        temperature=temperature,
        title=path.title,
    )


def _along(
    what: str, value: Array | Sequence[float] | float, shape: tuple[int, ...], faults: list[Fault]
) -> Array:
    """The value at every sample; a fault where it does not fit."""
    try:
        out = np.broadcast_to(np.asarray(value, dtype=np.float64), shape).copy()
    except ValueError:
        faults.append(Fault(what, f"has shape {np.shape(value)}", f"one for all, or {shape}"))
        return np.zeros(shape)
    if not np.isfinite(out).all():
        faults.append(Fault(what, "holds NaN or infinity", "give numbers"))
    return out


def _payload(conditions: Conditions, faults: list[Fault]) -> tuple[float, Array]:
    """Mass and centre of mass."""
    if not conditions.payload:
        if conditions.payload_mass:
            faults.append(Fault("payload", "has a mass and no name", "name it"))
        return 0.0, np.zeros(3)
    return conditions.payload_mass, _along("payload: centre of mass", conditions.payload_com, (3,), faults)

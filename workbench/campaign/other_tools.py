"""Campaigns with other tools: what each states to be always mounted is among its payloads then."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..robot.description import Robot
from ..robot.schema import stated_load
from .data import Array, Campaign

Load = tuple[float, Sequence[float] | Array]  # mass [kg], centre of mass (3,) [m, flange frame]


def same_tool(one: Campaign, other: Campaign) -> bool:
    """Whether two campaigns state one tool: none, or the same mass at the same place."""
    same_place = one.tool_mass == 0.0 or np.allclose(other.tool_com, one.tool_com, rtol=0, atol=1e-9)
    return bool(np.isclose(other.tool_mass, one.tool_mass, rtol=1e-9) and same_place)


def with_tools_as_loads(campaigns: Sequence[Campaign]) -> tuple[list[Campaign], tuple[str, ...]]:
    """The campaigns, and a word on it where their tools are not one: then each is a payload of its own, alone
    and together with what else is carried, which weighs the same on the arm."""
    first = campaigns[0]
    if all(same_tool(first, other) for other in campaigns[1:]):
        return list(campaigns), ()
    each = ", ".join(f"{c.tool_mass:g}" for c in campaigns)
    said = f"The campaigns do not state one tool ({each} kg): each counts as a payload of its own."
    return [_as_load(c) if c.tool_mass > 0 else c for c in campaigns], (said,)


def tool_as_in(loads: Mapping[str, Load], c: Campaign) -> Campaign:
    """A campaign with its tool as one of some payloads, as those of campaigns with other tools are: of the
    same mass at the same place, by that name; as it is where it is none of them. loads: of what states no
    tool."""
    if c.tool_mass == 0.0:
        return c
    own = _as_load(c)
    names = [_called(loads, own, name) for name in own.payload_names]
    if names[1] is None:
        return c
    kept = zip(names, own.payload_names, strict=True)
    payload_names = tuple(name or other for name, other in kept)
    return replace(own, payload_names=payload_names, mounted=payload_names[1])


def tool_as_modelled(robot: Robot, c: Campaign) -> Campaign:
    """The same by the payloads of a model of campaigns with other tools."""
    if robot.tool is not None:
        return c
    return tool_as_in({name: stated_load(load) for name, load in robot.payloads.items()}, c)


def _called(loads: Mapping[str, Load], c: Campaign, name: str) -> str | None:
    """What some payloads call one of a campaign that has its mass, its place, and its name up to a label."""
    alike = (one for one in loads if one == name or one.startswith(f"{name} ("))
    return next((one for one in alike if c.has_load(name, *loads[one])), None)


def _as_load(c: Campaign) -> Campaign:
    mass = c.load_mass + c.tool_mass
    moment = c.load_mass[:, None] * c.load_com + c.tool_mass * c.tool_com
    return replace(
        c,
        payload_names=("", c.tool_name, *c.payload_names[1:]),
        load_mass=np.concatenate([[0.0], mass]),
        load_com=np.vstack([np.zeros(3), moment / mass[:, None]]),
        tool_mass=0.0,
        tool_com=np.zeros(3),
        poses=replace(c.poses, payload=c.poses.payload + 1),
        mounted=c.tool_name,
    )

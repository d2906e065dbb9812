"""Campaigns with other tools: what each states to be always mounted is among its payloads then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .data import Campaign


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


def tool_as_in(fitted: Campaign, c: Campaign) -> Campaign:
    """A campaign with its tool as the payload that it is in one of several with other tools, of the same mass
    at the same place; as it is where it is none there."""
    if c.tool_mass == 0.0 or same_tool(fitted, c):
        return c
    own = _as_load(c)
    if not _called(fitted, own, 1):
        return c
    names = (_called(fitted, own, i) or name for i, name in enumerate(own.payload_names))
    return replace(own, payload_names=tuple(names))


def _called(fitted: Campaign, c: Campaign, i: int) -> str | None:
    """What a fitted campaign calls payload i of another, of one that has its name, mass and place."""
    own = c.payload_names[i]
    return next(
        (
            name
            for k, name in enumerate(fitted.payload_names)
            if k
            and (name == own or name.startswith(f"{own} ("))
            and np.isclose(fitted.load_mass[k], c.load_mass[i], rtol=1e-9)
            and np.allclose(fitted.load_com[k], c.load_com[i], rtol=0, atol=1e-9)
        ),
        None,
    )


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
    )

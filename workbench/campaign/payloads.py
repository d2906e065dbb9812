"""Loads at the flange, as commands say them, and campaigns with further ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..files.faults import Fault, InputError
from ..robot.description import Robot
from ..robot.schema import stated_load
from .data import Campaign

Load = tuple[float, tuple[float, float, float]]  # kg, and the centre of mass [m] in the flange's frame


def payload(text: str, robot: Robot) -> tuple[str, Load]:
    """Name and load of NAME=KG:x,y,z (mm); the name alone for a payload that the robot's own TOML states."""
    name, equals, rest = text.partition("=")
    if name in robot.payloads and not equals:
        return name, stated_load(robot.payloads[name])
    if not equals or not name:
        raise InputError(Fault("--payload", f"{text!r} is no NAME=KG", "like heavy=250:150,0,0"))
    return name, load(rest, "--payload")


def named_loads(texts: Sequence[str], robot: Robot) -> dict[str, Load]:
    """Loads by their names, each as `payload` reads it. Raises InputError for a name that is there twice."""
    loads: dict[str, Load] = {}
    for text in texts:
        name, one = payload(text, robot)
        if name in loads:
            raise InputError(Fault("--payload", f"{name!r} is given twice", "give each load its own name"))
        loads[name] = one
    return loads


def load(text: str, place: str) -> Load:
    """A load of KG:x,y,z (mm); place: the option, for the fault."""
    mass, _, com = text.partition(":")
    try:
        x, y, z = (float(v) * 1e-3 for v in com.split(",")) if com else (0.0, 0.0, 0.0)
        kg = float(mass)
        if not (0 <= kg < math.inf and all(map(math.isfinite, (x, y, z)))):
            raise ValueError
    except ValueError:
        raise InputError(Fault(place, f"{text!r} is no KG:x,y,z (mm)", "like 250:150,0,0")) from None
    return kg, (x, y, z)


def with_payloads(campaign: Campaign, payloads: Mapping[str, tuple[float, Sequence[float]]]) -> Campaign:
    """The campaign with further payloads: name → mass [kg] and centre of mass [m, flange frame], that no pose
    carries yet; where tools are payloads, beside the tool that is mounted. Raises InputError where it has
    another of that name."""
    tool, at = campaign.payloads.get(campaign.mounted, (0.0, np.zeros(3)))
    for name, (mass, com) in payloads.items():
        if tool and mass:
            mass, com = mass + tool, ((mass * np.array(com) + tool * at) / (mass + tool)).tolist()
        if name in campaign.payload_names:
            i = campaign.payload_names.index(name)
            if campaign.load_mass[i] != mass or tuple(campaign.load_com[i]) != tuple(com):
                what = f"the campaign has another payload {name!r}, of {campaign.load_mass[i]:g} kg"
                raise InputError(Fault(f"--payload {name}", what, "give it another name"))
            continue
        campaign = replace(
            campaign,
            payload_names=(*campaign.payload_names, name),
            load_mass=np.append(campaign.load_mass, mass),
            load_com=np.vstack([campaign.load_com, com]),
        )
    return campaign

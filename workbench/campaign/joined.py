"""Make one campaign of several of the same robot: each keeps its set-ups, and its noise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import reduce
from typing import TypeVar

import numpy as np

from ..files.faults import Fault, InputError
from ..robot.description import Robot
from .data import Array, Campaign, IntArray, Target
from .known import KnownData
from .other_tools import with_tools_as_loads
from .poses import join_poses


@dataclass(frozen=True)
class _Load:
    name: str
    mass: float
    com: tuple[float, ...]


Thing = TypeVar("Thing", Target, _Load)


def join(campaigns: Sequence[Campaign]) -> Campaign:
    """One campaign of several, poses in the order given.

    Set-ups get the campaign's label in front, poses too where names repeat. Targets (and payloads)
    of the same name are one where they agree, and get the label behind where they don't. Tools that
    differ are payloads. Raises `InputError` when the campaigns cannot be one.
    """
    if len(campaigns) == 1:
        return campaigns[0]
    faults = _differences(campaigns)
    if faults:
        raise InputError(faults)
    campaigns, tools = with_tools_as_loads(campaigns)
    labels = labels_of(campaigns)
    targets, columns = _targets(campaigns, labels)
    loads, load_of = _payloads(campaigns, labels)
    setup_names = tuple(
        f"{label}/{name}" if name else label
        for campaign, label in zip(campaigns, labels, strict=True)
        for name in campaign.setup_names
    )
    offsets = np.cumsum([0, *(len(campaign.setup_names) for campaign in campaigns[:-1])])
    sigma, noise_sigma, stated = _noise(campaigns, columns, len(targets))
    first = campaigns[0]
    return Campaign(
        title=_title(campaigns, labels),
        path=first.path,
        robot=first.robot,
        poses=replace(
            join_poses([campaign.poses for campaign in campaigns]),
            ids=_pose_ids(campaigns, labels),
            payload=np.concatenate(
                [load_of[i][campaign.poses.payload] for i, campaign in enumerate(campaigns)]
            ),
            setup=np.concatenate([campaign.poses.setup + offsets[i] for i, campaign in enumerate(campaigns)]),
        ),
        payload_names=tuple(load.name for load in loads),
        load_mass=np.array([load.mass for load in loads]),
        load_com=np.array([load.com for load in loads]),
        tool_mass=first.tool_mass,
        tool_com=first.tool_com,
        setup_names=setup_names,
        targets=targets,
        points=_spread([campaign.points for campaign in campaigns], columns, len(targets), np.nan),
        shots=_spread([c.shots.astype(np.float64) for c in campaigns], columns, len(targets), 0.0).astype(
            np.int64
        ),
        sigma=sigma,
        shot_scatter=(sum(c.shot_scatter[0] for c in campaigns), sum(c.shot_scatter[1] for c in campaigns)),
        noise_sigma=noise_sigma,
        six_dof=first.six_dof,
        warnings=(*(line for campaign in campaigns for line in campaign.warnings), *tools),
        files=_files(campaigns, labels),
        cell=first.cell,
        known=reduce(KnownData.and_more, (campaign.known for campaign in campaigns)),
        beside=tuple(path for c in campaigns for path in (c.path, *c.beside))[1:],
        told=tuple(dict.fromkeys(fact for campaign in campaigns for fact in campaign.told)),
        labels=tuple(labels),
        silent=tuple(label for label, told in zip(labels, stated, strict=True) if not told and any(stated)),
        mounted=loads[_mounted(campaigns, load_of)].name,
    )


def _differences(campaigns: Sequence[Campaign]) -> list[Fault]:
    """Why the campaigns cannot be one."""
    first, faults = campaigns[0], []
    paths = [campaign.path.resolve() for campaign in campaigns]
    for index, other in enumerate(campaigns[1:], 1):
        place = str(other.path)
        if paths[index] in paths[:index]:
            faults.append(Fault(place, "the same campaign twice", "name each once"))
        if (another := _another_robot(first.robot, other.robot)) is not None:
            what = f"robot {other.robot.name!r}, but {another} in {first.path}"
            version = other.robot.name == first.robot.name
            mend = (
                "let both name one TOML" if version else "campaigns of different robots are diagnosed apart"
            )
            faults.append(Fault(place, what, mend))
        if other.six_dof != first.six_dof:
            what = f"[noise] pose is {str(other.six_dof).lower()}, not as in {first.path}"
            faults.append(Fault(place, what, "make them agree, or diagnose them apart"))
    return faults


def _another_robot(one: Robot, other: Robot) -> str | None:
    """How a robot is called that is not the other one: of the same name by its files and what they say
    otherwise. None: it is the same."""
    said = set(_said_otherwise(one, other))
    alike = one.urdf.resolve() == other.urdf.resolve() or one.urdf.read_bytes() == other.urdf.read_bytes()
    if not alike and not _same_arm(one, other):
        said.add(f"another URDF ({other.urdf}, {one.urdf})")
    if not said:
        return None
    if one.name != other.name:
        return repr(one.name)
    return f"another version of it ({other.path} is not as {one.path}: {', '.join(sorted(said))})"


def _same_arm(one: Robot, other: Robot) -> bool:
    """Whether two URDFs make the same arm, however written: what goes with a plan is written anew."""
    from ..robot.rigid_plant import arrays

    a, b = arrays(one), arrays(other)
    return all(np.array_equal(getattr(a, field.name), getattr(b, field.name)) for field in fields(a))


def _said_otherwise(one: Robot, other: Robot) -> Iterator[str]:
    """What two robots' files say otherwise, in the words of the robot's TOML."""
    for name in (f.name for f in fields(Robot) if f.name not in ("path", "urdf", "joints")):
        if getattr(one, name) != getattr(other, name):
            yield name
    if one.joint_names != other.joint_names:
        yield "joints"
        return
    for a, b in zip(one.joints, other.joints, strict=True):
        now, then = b.data.model_dump(), a.data.model_dump()
        yield from (f"{a.name} {name}" for name, value in then.items() if value != now[name])
        if a != replace(b, data=a.data):
            yield f"{a.name} limits"


def labels_of(campaigns: Sequence[Campaign]) -> list[str]:
    """(K) a short name for each campaign: its folder, with as many folders above as make it the only one."""
    folders = [campaign.path.resolve().parent for campaign in campaigns]
    alone = len(set(folders)) == len(folders)
    paths = folders if alone else [campaign.path.resolve().with_suffix("") for campaign in campaigns]
    for depth in range(1 if alone else 2, max(len(path.parts) for path in paths)):
        labels = ["/".join(path.parts[-depth:]) for path in paths]
        if len(set(labels)) == len(labels):
            return labels
    return [str(path) for path in paths]


def _title(campaigns: Sequence[Campaign], labels: Sequence[str]) -> str:
    """Of all; where titles are alike, a title says nothing: labels do."""
    titles = [campaign.title for campaign in campaigns]
    return " + ".join(titles if len(set(titles)) == len(titles) else labels)


def _pose_ids(campaigns: Sequence[Campaign], labels: Sequence[str]) -> tuple[str, ...]:
    counts = Counter(name for campaign in campaigns for name in campaign.poses.ids)
    unique = max(counts.values()) == 1
    return tuple(
        name if unique else f"{label}/{name}"
        for campaign, label in zip(campaigns, labels, strict=True)
        for name in campaign.poses.ids
    )


def _targets(
    campaigns: Sequence[Campaign], labels: Sequence[str]
) -> tuple[tuple[Target, ...], list[IntArray]]:
    """All targets, and for each campaign the new index of each of its own."""

    def key(target: Target) -> Hashable:
        place = None if target.xyz is None else tuple(round(value, 9) for value in target.xyz)
        return place, target.on, target.fixed

    merged, indices = _merge([campaign.targets for campaign in campaigns], labels, key)
    return tuple(merged), indices


def _payloads(campaigns: Sequence[Campaign], labels: Sequence[str]) -> tuple[list[_Load], list[IntArray]]:
    """All payloads, and for each campaign the new index of each of its own."""
    groups = [
        [
            _Load(name, float(mass), tuple(com.tolist()))
            for name, mass, com in zip(
                campaign.payload_names, campaign.load_mass, campaign.load_com, strict=True
            )
        ]
        for campaign in campaigns
    ]
    return _merge(groups, labels, lambda load: tuple(round(value, 9) for value in (load.mass, *load.com)))


def _mounted(campaigns: Sequence[Campaign], load_of: Sequence[IntArray]) -> int:
    """Number of the payload that is the tool mounted now, 0 where none is: the last campaign's own, or of one
    that states none that of an earlier which its poses carry."""
    own = [
        int(load_of[i][campaign.payload_names.index(campaign.mounted)]) if campaign.mounted else 0
        for i, campaign in enumerate(campaigns)
    ]
    carried = load_of[-1][campaigns[-1].poses.payload]
    return own[-1] or next((k for k in reversed(own) if k and k in carried), 0)


def _merge(
    groups: Sequence[Sequence[Thing]], labels: Sequence[str], key: Callable[[Thing], Hashable]
) -> tuple[list[Thing], list[IntArray]]:
    """One thing per name and key, renamed where a name has several keys; and the new indices per group."""
    kinds: dict[str, set[Hashable]] = {}
    for group in groups:
        for thing in group:
            kinds.setdefault(thing.name, set()).add(key(thing))
    called: dict[tuple[str, Hashable], str] = {}  # by what it is called in its own campaign
    merged: dict[str, int] = {}
    things: list[Thing] = []
    indices = []
    for group, label in zip(groups, labels, strict=True):
        for thing in group:
            alone = len(kinds[thing.name]) == 1
            name = called.get((thing.name, key(thing)), thing.name if alone else f"{thing.name} ({label})")
            while name in merged and key(things[merged[name]]) != key(thing):
                name += f" ({label})"
            called[thing.name, key(thing)] = name
            if name not in merged:
                merged[name] = len(things)
                things.append(replace(thing, name=name))
        own = [merged[called[thing.name, key(thing)]] for thing in group]
        indices.append(np.array(own, dtype=np.int64))
    return things, indices


def _spread(arrays: Sequence[Array], columns: Sequence[IntArray], n_targets: int, empty: float) -> Array:
    """(N, T, ...) of all poses and targets from each campaign's (N_c, T_c, ...)."""
    parts = []
    for array, column in zip(arrays, columns, strict=True):
        part = np.full((len(array), n_targets, *array.shape[2:]), empty)
        part[:, column] = array
        parts.append(part)
    return np.concatenate(parts)


def _noise(
    campaigns: Sequence[Campaign], columns: Sequence[IntArray], n_targets: int
) -> tuple[Array | None, float | None, list[bool]]:
    """Sigma per point, sigma of one shot, and which campaigns state a noise: that of the others, as far as
    there are any, is a guess by what these state."""
    first = campaigns[0]
    stated = [campaign.sigma is not None or campaign.noise_sigma is not None for campaign in campaigns]
    if all(campaign.sigma is None and campaign.noise_sigma == first.noise_sigma for campaign in campaigns):
        return None, first.noise_sigma, stated
    one_shot = np.concatenate(
        [
            (_sigma(campaign) * np.sqrt(campaign.shots)[..., None])[campaign.seen].ravel()
            for campaign, told in zip(campaigns, stated, strict=True)
            if told
        ]
    )
    usual = float(np.sqrt(np.mean(one_shot**2)))
    sigmas = [
        _sigma(campaign if told else replace(campaign, noise_sigma=usual))
        for campaign, told in zip(campaigns, stated, strict=True)
    ]
    return _spread(sigmas, columns, n_targets, np.nan), usual, stated


def _sigma(campaign: Campaign) -> Array:
    """(N, T, 3) one sigma of each mean, from the points or from the noise stated for all."""
    if campaign.sigma is not None:
        return campaign.sigma
    shots = np.where(campaign.seen, campaign.shots, np.nan)
    return np.repeat((campaign.noise_sigma or np.nan) / np.sqrt(shots)[..., None], 3, axis=2)


def _files(campaigns: Sequence[Campaign], labels: Sequence[str]) -> dict[str, str]:
    files: dict[str, str] = {}
    for campaign, label in zip(campaigns, labels, strict=True):
        for name, digest in campaign.files.items():
            clash = files.get(name, digest) != digest
            files[f"{label}: {name}" if clash else name] = digest
    return files

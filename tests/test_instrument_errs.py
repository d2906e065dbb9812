"""A sound robot under an instrument that errs: the error is the instrument's, and no cause of the robot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_cases import SIGMA, measured

from workbench.campaign import Campaign
from workbench.campaign.problem import problem_of
from workbench.diagnosis.run import diagnose
from workbench.effects.base import UNKNOWN
from workbench.effects.unnamed.instrument import Head, Reflectors, Views, may_be_head
from workbench.robot.kinematics import Array

STANDS = np.array([3.5, 1.5, 0.3])  # m: the robot, from the head
Error = Callable[[Array, Array, Array], tuple[Array, Array, Array]]


def seen_by_tracker(campaign: Campaign, error: Error) -> Campaign:
    """The campaign seen from a head in the origin. error: of range [m], azimuth and elevation [rad], from
    these, each (N, T)."""
    x = campaign.points + STANDS
    r, azimuth = np.linalg.norm(x, axis=2), np.arctan2(x[..., 1], x[..., 0])
    zenith = np.arccos(x[..., 2] / r)
    dr, da, de = error(r, azimuth, np.pi / 2 - zenith)
    r, azimuth, zenith = r + dr, azimuth + da, zenith - de
    places = [np.sin(zenith) * np.cos(azimuth), np.sin(zenith) * np.sin(azimuth), np.cos(zenith)]
    return replace(campaign, points=r[..., None] * np.stack(places, axis=-1))


def runs_out(r: Array, azimuth: Array, elevation: Array) -> tuple[Array, Array, Array]:
    """An elevation encoder off its centre, twice per turn, by a hundred times the usual."""
    return 0 * r, 0 * r, 2e-4 * np.sin(2 * elevation + 0.4)


def short(r: Array, azimuth: Array, elevation: Array) -> tuple[Array, Array, Array]:
    """A range that was set at the wrong nest."""
    return 0 * r + 2e-3, 0 * r, 0 * r


def smaller_ball(r: Array, azimuth: Array, elevation: Array) -> tuple[Array, Array, Array]:
    """One reflector of three of another radius than the others."""
    first = np.eye(r.shape[1])[0] * np.ones_like(r)
    return 6e-4 * first, 0 * r, 0 * r


@pytest.fixture(scope="module")
def sound() -> Campaign:
    return measured("6R", loads=())


def test_the_published_errors_of_a_trackers_geometry_are_the_heads(sound):
    """Muralikrishnan et al. 2009, written down here once more: with z the zenith angle."""
    problem = problem_of(seen_by_tracker(sound, lambda r, a, e: (0 * r, 0 * r, 0 * r)))
    (head,) = Head.sites(problem)
    x = problem.campaign.points
    basis = head.seen(problem, x).reshape(x.size, -1)
    r = np.linalg.norm(x, axis=2)
    z, a = np.arccos(x[..., 2] / r), np.arctan2(x[..., 1], x[..., 0])
    none = np.zeros_like(r)
    published = {
        "beam offset": (none, 1 / (r * np.sin(z)), none),
        "transit offset": (np.sin(z), none, -np.cos(z) / r),
        "vertical index": (none, none, none + 1),
        "beam tilt": (none, 1 / np.sin(z), none),
        "transit tilt": (none, 1 / np.tan(z), none),
        "azimuth encoder": (none, np.cos(a + 0.3), none),
        "azimuth encoder, twice": (none, np.cos(2 * a - 1), none),
        "elevation encoder": (none, none, np.cos(z + 1)),
        "elevation encoder, twice": (none, none, np.cos(2 * z + 2)),
        "bird bath": (none + 1, none, none),
        "bent beam": (none, none, r),
    }
    ray = x / r[..., None]
    across = np.stack([-np.sin(a), np.cos(a), none], axis=-1)
    rise = np.cross(ray, across)
    for name, (dr, da, de) in published.items():
        moved = dr[..., None] * ray + (r * np.sin(z) * da)[..., None] * across + (r * de)[..., None] * rise
        left = moved.ravel() - basis @ np.linalg.lstsq(basis, moved.ravel())[0]
        assert np.abs(left).max() < 1e-9 * np.abs(moved).max(), name


@pytest.mark.parametrize("error", [runs_out, short, smaller_ball])
def test_what_the_instrument_does_is_not_the_robots(sound, error):
    found = diagnose(seen_by_tracker(sound, error)).diagnosis
    (only,) = found.causes
    assert only.cause == UNKNOWN
    assert only.like.startswith("the instrument's own error")
    assert "the instrument's own error" in found.headline
    assert "setup" in only.separate_by
    noise = np.sqrt(3) * SIGMA * 1e3
    assert found.stages[1].heldout_rms_mm > 2 * noise
    assert found.stages[-1].heldout_rms_mm < 1.3 * noise


def test_a_reflector_whose_range_is_off_is_no_noise(sound):
    """Distances between targets change with it, by much more than the noise."""
    found = diagnose(seen_by_tracker(sound, smaller_ball)).diagnosis
    assert found.noise.source == "stated"


def test_a_gear_is_found_beside_what_the_instrument_does():
    hidden = "gear_eccentricity:joint=joint_1,variant=2,amplitude=3e-4,phase=0.5"
    found = diagnose(seen_by_tracker(measured("6R", (hidden,), poses=40, loads=()), short)).diagnosis
    first, *more = found.causes
    assert (first.cause, first.where.joint, first.status) == ("gear_eccentricity", "joint_1", "named")
    assert [(one.cause, one.like) for one in more] == [
        (UNKNOWN, "the instrument's own error, not the robot's")
    ]


def test_points_about_the_robots_own_base_have_no_head_in_their_origin(sound):
    problem = problem_of(sound)
    near = replace(problem, campaign=replace(sound, points=sound.points - sound.points[0, 0]))
    assert not may_be_head(near.campaign.points.reshape(-1, 3))
    assert not any(kind.sites(near) for kind in (Head, Reflectors, Views))


def test_points_of_a_probe_share_its_errors(sound):
    """Three points of one 6-D measurement are no three reflectors."""
    seen = seen_by_tracker(sound, lambda r, a, e: (0 * r, 0 * r, 0 * r))
    for kind in (Reflectors, Views):
        (each,) = kind.sites(problem_of(seen))
        probe = problem_of(replace(seen, six_dof=True))
        (one,) = kind.sites(probe)
        assert len(one.params) == len(each.params) // 3
        moved = one.seen(probe, seen.points) @ np.ones(len(one.params))
        rays = seen.points / np.linalg.norm(seen.points, axis=2)[..., None]
        assert np.allclose(np.cross(moved, rays), 0, atol=1e-9)  # along its ray, all of them alike
        assert np.allclose(moved, moved[:, :1], rtol=0.05, atol=0.05 * np.abs(moved).max())
    assert "the reflector or probe" in one.variable
    assert "each reflector" in each.variable


def test_reflectors_of_another_campaign_show_nothing_of_these(sound):
    """A campaign that is planned has more targets, or fewer: each keeps its own columns."""
    seen = seen_by_tracker(sound, lambda r, a, e: (0 * r, 0 * r, 0 * r))
    problem, first, others = problem_of(seen), seen.targets[:1], seen.targets[1:]
    new = replace(seen.targets[0], name="new")
    for kind in (Reflectors, Views):
        (each,) = kind.sites(problem)
        of_all = each.seen(problem, seen.points)
        fewer = replace(seen, targets=others, points=seen.points[:, 1:], shots=seen.shots[:, 1:])
        assert np.allclose(each.seen(problem_of(fewer), fewer.points), of_all[:, 1:], atol=0.3)
        more = replace(
            seen,
            targets=(*first, new, *others),
            points=np.insert(seen.points, 1, seen.points[:, 0], axis=1),
            shots=np.insert(seen.shots, 1, seen.shots[:, 0], axis=1),
        )
        shown = each.seen(problem_of(more), more.points)
        assert np.allclose(shown[:, [0, 2, 3]], of_all, atol=0.3)  # the hand's turn is by their middle
        assert not shown[:, 1].any()

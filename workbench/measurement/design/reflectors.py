"""Reflectors on the arm or its base that settle what those on the flange leave open."""

from __future__ import annotations

from ...effects import shown_on
from .offers import Offers, Poses, roughly_settled
from .ties import Tie

MOST = 3  # links that get one, at most
FEWER = 1.5  # times fewer poses with them than without, or with more of them: worth putting them on


def settled_by_reflectors(
    offers: Offers, tie: Tie, heard: Tie, without: Poses | None
) -> tuple[list[str], Poses] | None:
    """Links, or "base", on which a reflector more settles a tie, and the poses that do: one link where that
    is nearly as good as several. None where all on which the cause or its rivals sit do not, in clearly fewer
    poses than `without` them, where these have one already, or where the instrument sees one body alone.
    heard: the tie as far as it is worth a word."""
    problem, fit = offers.prior.problem, offers.prior.fit
    arm, had = problem.arm, {target.on for target in offers.records.targets}
    places = dict.fromkeys(shown_on(effect, arm) for effect in (tie.effect, *heard.rivals))
    further = [link for link in places if link is not None and link not in had]
    links = [link for link in further if arm.slot_of_link(link) < arm.n][:MOST]  # the last carries the flange
    if not links or problem.campaign.six_dof:
        return None
    found: list[tuple[list[str], Poses]] = []
    for some in [links] if len(links) == 1 else [links, *([link] for link in links)]:
        poses = roughly_settled(offers.with_reflectors(some), tie, fit)
        if poses is not None and (without is None or FEWER * poses.count <= without.count):
            found.append((some, poses))
        elif some is links:
            return None  # nor do fewer
    return min(found, key=lambda one: FEWER * one[1].count if len(one[0]) > 1 else one[1].count)

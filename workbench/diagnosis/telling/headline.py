"""The verdict in words: its headline, and remarks on what is left and on the noise."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...effects import called
from ...effects.base import UNKNOWN, Effect
from ...effects.place import Where
from ..found import FaultFound, Finding, GivenFact, Noise, Rival, Stage
from ..prepared import Prepared
from ..priors import PRIORS
from ..result import Verdict
from ..search.worth import FAINT
from ..weighing.remainder import GLOBAL_LEVEL, Remainder

MOST_SAID = 3  # causes that a headline says
MOST_OPEN = 2  # of those that are not decided, each with a rival; one less beside what was found
MOST_SPREAD = 2.0  # times the noise: a fit that predicts no better has too many numbers for its poses
# faults that a headline says
STEPS = ("moved_instrument", "changed_setup", "moved_zero", "changed_load", "changed_scale")
MORE = 1.1  # times the held-out error: what a model without what does not last has to leave to be told
OVERSTATED = 2.0  # times what the fit leaves, from which a stated noise is doubted beside its number
SMALL_MM = 0.01  # below it a headline has micrometres
LITTLE = "which brings less than a tenth of the noise"
SMALL_REST = 0.1  # of what the causes brought: a smaller rest without a name does not decide the verdict


@dataclass(frozen=True)
class Errors:
    """What a verdict weighs, in mm RMS of poses held out. stages: of the diagnosis; base: that before any
    cause, of geometry or of that and of what was given; with_names: with all causes that have names; ceiling:
    what all smooth terms tried reach; visible: size of an error beyond geometry that these data would have
    shown, wandering: the same of one that wanders in time, 0 where none could; noise: length of a point's
    noise; lasting: of the model without what goes with time, order or the instrument, 0 where it has nothing
    such."""

    stages: Sequence[Stage]
    base: Stage
    with_names: float
    ceiling: float
    visible: float
    noise: float
    lasting: float = 0.0
    wandering: float = 0.0

    @property
    def brought(self) -> float:
        """What the causes brought."""
        return self.base.heldout_rms_mm - self.with_names

    @property
    def much_left(self) -> bool:
        """Whether more than a share of what the causes brought is left for a smooth model."""
        return self.with_names - self.ceiling > SMALL_REST * max(self.brought, 0.0)

    @property
    def too_few(self) -> bool:
        """Whether the poses are too few to say that nothing is missing: geometry fitted to them predicts
        others badly."""
        return self.base.heldout_rms_mm > MOST_SPREAD * self.noise

    @property
    def with_given(self) -> bool:
        """Whether something was given."""
        return self.base is not self.stages[1]


def verdict_of(findings: Sequence[Finding], nameless: Sequence[Finding], errors: Errors) -> Verdict:
    """The one word for all findings: unknown where what has no name is worth more than a share of what the
    causes brought."""
    if nameless and (not findings or errors.much_left):
        return "unknown"
    if not findings:
        return "nothing_missing"
    return "named" if all(f.status == "named" for f in findings) else "ambiguous"


def headline(
    verdict: Verdict,
    findings: Sequence[Finding],
    errors: Errors,
    given: Sequence[GivenFact] = (),
    repeatability_mm: float | None = None,
    in_what: str = "",
    besides: bool = False,
) -> str:
    """The verdict in one line; the numbers follow after the first full stop. repeatability_mm: of the robot,
    where that is all that is left; in_what: as `shows_in` says it; besides: `steps` says something too."""
    said = _found(findings, given, FAINT * errors.noise / np.sqrt(3))
    nothing = verdict == "nothing_missing"
    after = (errors.base if nothing else errors.stages[-1]).heldout_rms_mm
    gain = _gain(errors, after)
    if nothing and errors.too_few:
        times = f"{_times(after / errors.noise)} times the {_mm(errors.noise)} mm that noise makes of a point"
        return f"Too few poses to say: at others the fitted robot is off by {times}. {gain}."
    if nothing:
        missing = (
            f"{said}; beyond that nothing is missing" if said else f"Nothing {'else ' * besides}is missing"
        )
        best = errors.stages[-1].heldout_rms_mm
        with_all = f", {_mm(best)} mm with what the model has unsettled (notes)" if best < after else ""
        return f"{missing}{in_what}{_explained(errors, repeatability_mm)}. {gain}{with_all}."
    few = after > MOST_SPREAD * errors.noise
    if few and errors.base.heldout_rms_mm > errors.stages[0].heldout_rms_mm:
        said = f"Too few poses to be sure{f' ({said[0].lower()}{said[1:]})' if said else ''}"
    best = max(errors.base.heldout_rms_mm - errors.ceiling, 0.0)
    brought = _of(errors.brought, best)
    gain += f"; the causes bring {brought} that all smooth terms tried bring."
    if verdict != "unknown":
        return f"{said}. {gain}"
    left = _left(findings)
    first, then = (said, left) if errors.brought > best / 2 else (left, said)  # what is most of it leads
    return f"{first}{f'; {then[0].lower()}{then[1:]}' if then else ''}. {gain}"


def _found(findings: Sequence[Finding], given: Sequence[GivenFact], least_mm: float) -> str:
    """Causes that were found, that are gone, that are open, and given ones that the data confirm. What is
    open and brings less than the least is not said by name where something else is."""
    causes = sorted((f for f in findings if f.cause != UNKNOWN), key=lambda f: -f.gain_mm)
    sure = by_cause([f for f in causes if f.status == "named" and not f.taken_back])
    parts = [f"Found: {_some(sure)}"] if sure else []
    gone = by_cause([f for f in causes if f.status == "named" and f.taken_back])
    if gone:
        parts.append(f"{'no' if sure else 'No'} longer as the model has it: {_some(gone)}")
    undecided = [f for f in causes if f.status != "named"]
    worth = [f for f in undecided if f.gain_mm >= least_mm]
    more = worth or ([] if parts else undecided)
    open_ = list(dict.fromkeys(_either(f) for f in more))  # two may be each other's
    if open_:
        faint = "" if worth else f", {LITTLE}"
        said = _some(open_, MOST_OPEN - bool(parts), between=", and ", last=", and ")
        parts.append(f"{'not decided' if parts else 'Not decided'}: {said}{faint}")
    elif undecided:
        parts.append(f"what is not decided {LITTLE.removeprefix('which ')}")
    confirmed = [fact.differs for fact in given if fact.differs]
    if confirmed:
        parts.append(f"{'given' if parts else 'Given'} and confirmed: {_some(confirmed)}")
    return "; ".join(parts)


def _of(part: float, whole: float) -> str:
    """A length of another [mm]; in µm where these are small."""
    if whole < SMALL_MM:
        return f"{1e3 * part:.1f} of the {1e3 * whole:.1f} µm"
    return f"{part:.3f} of the {whole:.3f} mm"


def _gain(errors: Errors, after: float) -> str:
    """The error before and after."""
    lasts = f" ({_mm(errors.lasting)} mm without what only this campaign has)"
    elsewhere = lasts if errors.lasting > MORE * after else ""
    nominal, geometry = (stage.heldout_rms_mm for stage in errors.stages[:2])
    gain = f"Held-out error {_mm(nominal)} → {_mm(after)} mm RMS{elsewhere}"
    if after != geometry:
        gain += f", {_mm(geometry)} mm with geometry alone"
    if not errors.with_given:
        return gain
    return f"{gain}, {_mm(errors.base.heldout_rms_mm)} mm with geometry and what was given"


def _explained(errors: Errors, repeatability_mm: float | None) -> str:
    """Behind "nothing is missing": what explains the data, and what would have shown."""
    explain = "geometry and what was given explain" if errors.with_given else "geometry explains"
    power = f"an error of {_mm(errors.visible)} mm RMS beyond it would have shown"
    if errors.wandering:
        power += f" ({_mm(errors.wandering)} mm where it wanders in time)"
    if repeatability_mm is None:
        return f": {explain} these data, and {power}"
    but = f"though the robot seems to repeat to {repeatability_mm:.3f} mm only"
    return f", {but}: {explain} the rest, and {power}"


def _left(findings: Sequence[Finding]) -> str:
    """What is left that has no name; what it may be, if that is likelier than what a name leaves open."""
    rivals = [rival for f in findings if f.cause == UNKNOWN for rival in f.rivals]
    like = next((f.like for f in findings if f.like), "")
    likeliest = max(rivals, key=lambda rival: rival.probability, default=None)
    if likeliest is not None and likeliest.probability > 1 - PRIORS.named:
        words = words_of(likeliest.cause, likeliest.where, likeliest.called)
        more = "more of the " if words in [words_of(f.cause, f.where, f.called) for f in findings] else ""
        if like:
            return f"Something is left that looks like {like}, or may be {more}{words}"
        return f"Something is left that may be {more}{words}, or has no name"
    if any(f.of_campaigns for f in findings):
        return "The robot is not the same in all campaigns"
    return f"Something is left that {f'looks like {like}' if like else 'no known cause explains'}"


def shows_in(prepared: Prepared, left: Remainder, noise_mm: float) -> str:
    """Behind "nothing is missing": in what noise, where nobody can be sure of that."""
    if left.overstated:
        return f" that shows in the stated noise, {_times(1 / left.inflation)} times what the data scatter by"
    if not prepared.noise_known:
        return f" that shows in a scatter of {noise_mm:.3f} mm, taken for noise as none is stated or repeated"
    return ""


def steps(faults: Sequence[FaultFound]) -> str:
    """What moved among the campaign's set-up, as a sentence behind a headline; nothing where nothing did.
    What steps several times is said once."""
    moved = dict[str, list[str]]()
    for fault in faults:
        if fault.kind in STEPS:
            what, by, how = fault.what.replace("this pose", f"pose {fault.pose_id}").partition(" by ")
            moved.setdefault(what + by, []).append(how)
    said = "; ".join(what + listed(how) for what, how in moved.items())
    return f" In these data {said}." if said else ""


def in_order(faults: Sequence[FaultFound], pose_ids: Sequence[str]) -> tuple[FaultFound, ...]:
    """The same faults, with what steps in the order of the poses: each was found where it showed most."""
    at = {name: n for n, name in enumerate(pose_ids)}
    stepping = [fault for fault in faults if fault.kind in STEPS]
    ordered = iter(sorted(stepping, key=lambda fault: at.get(fault.pose_id or "", -1)))
    return tuple(next(ordered) if fault.kind in STEPS else fault for fault in faults)


def with_left(noise: Noise, left: Remainder) -> Noise:
    """The noise with what the fit leaves, where far more was stated."""
    far = left.overstated and left.inflation < 1 / OVERSTATED
    return replace(noise, left_mm=noise.sigma_mm * left.inflation) if far else noise


def _times(ratio: float) -> str:
    return f"{ratio:.1f}" if ratio < 10 else f"{ratio:.0f}"


def _mm(length: float) -> str:
    """A length [mm] as page and terminal have it: micrometres below a millimetre, 0.01 mm above."""
    return f"{length:.{3 if length < 1 else 2}f}"


def words_of(cause: str, where: Where, name: str = "") -> str:
    """A cause and where it sits, as people say them. name: what the field calls it there, where its cause
    does not say it."""
    name = "something without a name" if cause == UNKNOWN else name or called(cause)
    return f"{name} in {where}" if str(where) else name


def by_cause(found: Iterable[Finding | Effect]) -> list[str]:
    """Causes as people say them, each with all places where it sits."""
    places = dict[str, dict[str, None]]()
    for one in found:
        places.setdefault(one.called or called(one.cause), {})[str(one.where)] = None
    return [f"{name} in {listed(list(where))}" if all(where) else name for name, where in places.items()]


def _either(finding: Finding) -> str:
    """A cause that is not decided, or its likeliest rival, the likelier first."""
    either: list[Finding | Rival] = sorted([finding, *finding.rivals[:1]], key=lambda one: -one.probability)
    words = [words_of(one.cause, one.where, one.called) for one in either]
    if len(set(words)) < len(words):  # one gear, at one of two orders
        words = [f"{word} at order {one.where.order:.4g}" for word, one in zip(words, either, strict=True)]
    return " or ".join(words)


def _some(words: Sequence[str], most: int = MOST_SAID, between: str = ", ", last: str = " and ") -> str:
    if len(words) <= most + 1:
        return between.join(words)
    return f"{between.join(words[:most])}{last}{len(words) - most} more"


def listed(names: Sequence[str]) -> str:
    """a, b and c."""
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]


def remarks(
    prepared: Prepared,
    left: Remainder,
    beyond: Remainder,
    structured: bool,
    repeatability_mm: float | None,
) -> list[str]:
    """What a reader should know of the noise besides. beyond: what is left beyond what real causes are off
    their forms; repeatability_mm: of the robot, where that looks like it."""
    notes = []
    if repeatability_mm is not None:
        sheet = prepared.problem.robot.pose_repeatability_mm
        said = "of which nothing is known" if sheet is None else f"its data sheet says {sheet:g} mm"
        unsaid = prepared.problem.campaign.poses.side is None
        play = " Play looks the same where the sides of approach are not recorded." if unsaid else ""
        notes.append(
            "Beyond the stated noise the poses scatter, by nothing that was recorded, as those of a robot do "
            f"that repeats to {repeatability_mm:.3f} mm from all sides (ISO 9283 RP; {said}). It was taken "
            f"for that: repeat ten poses five times to know it.{play}"
        )
    elif left.scatter and not beyond.scatter and not structured:
        notes.append(
            f"The residual is {left.inflation:.2f} times the noise: no more than causes of this size leave "
            "on a real machine, where none has quite the form that it is fitted in."
        )
    elif prepared.noise_known and not structured and left.p < GLOBAL_LEVEL:
        notes.append(
            f"The residual is {left.inflation - 1:.0%} larger than the noise says, without any structure: "
            "check the stated noise, or repeat ten poses five times."
        )
    if left.overstated:
        sigma = prepared.noise.sigma_mm
        notes.append(
            f"The stated noise of {sigma:.3g} mm per axis is {_times(1 / left.inflation)} times what the fit "
            f"leaves ({sigma * left.inflation:.3g} mm): nothing smaller is looked for. State the "
            "instrument's own, or take sigma_mm out of [noise]."
        )
    if not prepared.noise_known:
        notes.append(prepared.noise.sentence)
    return notes

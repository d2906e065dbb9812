"""The verdict in words: its headline, and remarks on what is left and on the noise."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...effects import called
from ...effects.base import UNKNOWN, Effect
from ...effects.place import Where
from ..prepared import Prepared
from ..result import FaultFound, Finding, GivenFact, Rival, Stage, Verdict
from ..weighing.remainder import GLOBAL_LEVEL, Remainder

MOST_SAID = 3  # causes that a headline says
MOST_SPREAD = 2.0  # times the noise: a fit that predicts no better has too many numbers for its poses
# faults that a headline says
STEPS = ("moved_instrument", "changed_setup", "moved_zero", "changed_load", "changed_scale")
MORE = 1.1  # times the held-out error: what a model without what does not last has to leave to be told
SMALL_REST = 0.1  # of what the causes brought: a smaller rest without a name does not decide the verdict


def much_left(brought_mm: float, rest_mm: float) -> bool:
    """Whether more than a share of what the causes brought is left for a smooth model (as `verdict_of`)."""
    return rest_mm > SMALL_REST * max(brought_mm, 0.0)


def verdict_of(
    findings: Sequence[Finding], nameless: Sequence[Finding], brought_mm: float, rest_mm: float
) -> Verdict:
    """The one word for all findings: unknown where what has no name is worth more than a share of what the
    causes brought. brought_mm, rest_mm: held-out gain of the causes, and of all smooth terms beyond them."""
    if nameless and (not findings or much_left(brought_mm, rest_mm)):
        return "unknown"
    if not findings:
        return "nothing_missing"
    return "named" if all(f.status == "named" for f in findings) else "ambiguous"


def headline(
    verdict: Verdict,
    findings: Sequence[Finding],
    stages: Sequence[Stage],
    brought_mm: float,
    ceiling_mm: float,
    visible_mm: float,
    noise_mm: float,
    base: Stage,
    given: Sequence[GivenFact] = (),
    repeatability_mm: float | None = None,
    in_what: str = "",
    lasting_mm: float = 0.0,
) -> str:
    """The verdict in one line; the numbers follow after the first full stop. visible_mm: size of an error
    beyond geometry that these data would have shown; noise_mm: RMS length of a point's noise; base: the stage
    before any cause, of geometry or of that and of what was given; repeatability_mm: of the robot, where that
    is all that is left; in_what: as `shows_in` says it; lasting_mm: RMS on poses held out, of
    the model without what goes with time, order or the instrument."""
    causes = sorted((f for f in findings if f.cause != UNKNOWN), key=lambda f: -f.gain_mm)
    sure = by_cause([f for f in causes if f.status == "named" and not f.taken_back])
    parts = [f"Found: {_some(sure)}"] if sure else []
    gone = by_cause([f for f in causes if f.status == "named" and f.taken_back])
    if gone:
        parts.append(f"{'no' if sure else 'No'} longer as the model has it: {_some(gone)}")
    open_ = list(dict.fromkeys(_either(f) for f in causes if f.status != "named"))  # two may be each other's
    if open_:
        parts.append(f"{'not decided' if parts else 'Not decided'}: {_some(open_, ', and ')}")
    confirmed = [fact.differs for fact in given if fact.differs]
    if confirmed:
        parts.append(f"{'given' if parts else 'Given'} and confirmed: {_some(confirmed)}")
    said = "; ".join(parts)
    after = (base if verdict == "nothing_missing" else stages[-1]).heldout_rms_mm
    elsewhere = (
        f" ({lasting_mm:.3f} mm without what only this campaign has)" if lasting_mm > MORE * after else ""
    )
    gain = (
        f"Held-out error {stages[0].heldout_rms_mm:.3f} → {after:.3f} mm RMS{elsewhere}, "
        f"{stages[1].heldout_rms_mm:.3f} mm with geometry alone"
    )
    with_given = base is not stages[1]
    if with_given:
        gain += f", {base.heldout_rms_mm:.3f} mm with geometry and what was given"
    few = after > MOST_SPREAD * noise_mm
    if verdict == "nothing_missing" and few:
        times = f"{after / noise_mm:.1f} times the noise of {noise_mm:.3f} mm"
        return f"Too few poses to say: at others the fitted robot is off by {times}. {gain}."
    if verdict == "nothing_missing":
        explain = "geometry and what was given explain" if with_given else "geometry explains"
        power = f"an error of {visible_mm:.3f} mm RMS beyond it would have shown"
        nothing = f"{said}; beyond that nothing is missing" if said else "Nothing is missing"
        nothing += in_what
        if repeatability_mm is None:
            return f"{nothing}: {explain} these data, and {power}. {gain}."
        but = f"though the robot seems to repeat to {repeatability_mm:.3f} mm only"
        return f"{nothing}, {but}: {explain} the rest, and {power}. {gain}."
    if few and base.heldout_rms_mm > stages[0].heldout_rms_mm:
        said = f"Too few poses to be sure{f' ({said[0].lower()}{said[1:]})' if said else ''}"
    best = max(base.heldout_rms_mm - ceiling_mm, 0.0)
    gain += f"; the causes bring {brought_mm:.3f} of the {best:.3f} mm that all smooth terms tried bring."
    if verdict == "unknown":
        left = "Something is left that no known cause explains"
        if any(f.cause == UNKNOWN and f.rivals for f in findings):
            left = "Something is left whose cause is not decided"
        elif any(f.of_campaigns for f in findings):
            left = "The robot is not the same in all campaigns"
        elif like := next((f.like for f in findings if f.like), ""):
            left = f"Something is left that looks like {like}"
        first, then = (said, left) if brought_mm > best / 2 else (left, said)  # what is most of it leads
        return f"{first}{f'; {then[0].lower()}{then[1:]}' if then else ''}. {gain}"
    return f"{said}. {gain}"


def shows_in(prepared: Prepared, left: Remainder, noise_mm: float) -> str:
    """Behind "nothing is missing": in what noise, where nobody can be sure of that."""
    if left.overstated:
        return f" that shows in the stated noise, {_times(1 / left.inflation)} times what the data scatter by"
    if not prepared.noise_known:
        return f" that shows in a scatter of {noise_mm:.3f} mm, taken for noise as none is stated or repeated"
    return ""


def steps(faults: Sequence[FaultFound]) -> str:
    """What moved among the campaign's set-up, as a sentence behind a headline; nothing where nothing did."""
    moved = [f.what.replace("this pose", f"pose {f.pose_id}") for f in faults if f.kind in STEPS]
    return f" In these data {listed(moved)}." if moved else ""


def _times(ratio: float) -> str:
    return f"{ratio:.1f}" if ratio < 10 else f"{ratio:.0f}"


def words_of(cause: str, where: Where) -> str:
    """A cause and where it sits, as people say them."""
    name = "something without a name" if cause == UNKNOWN else called(cause)
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
    words = [words_of(one.cause, one.where) for one in either]
    if len(set(words)) < len(words):  # one gear, at one of two orders
        words = [f"{word} at order {one.where.order:.4g}" for word, one in zip(words, either, strict=True)]
    return " or ".join(words)


def _some(words: Sequence[str], between: str = ", ") -> str:
    if len(words) <= MOST_SAID + 1:
        return between.join(words)
    return f"{between.join(words[:MOST_SAID])} and {len(words) - MOST_SAID} more"


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

"""`verify.html`: the proof on one page, in the look of the report."""

from __future__ import annotations

from html import escape

from ...report.numbers import mm
from ...report.parts import bullets, document, figure, table, tiles
from .pictures import pictures, speed_text
from .verification import NAMES, Series, Verification

LINKS = {"scene.html": "3-D scene", "verify.json": "Numbers"}


def page(found: Verification) -> str:
    """The whole page as text."""
    *along, heights, lines = pictures(found)
    body = [_head(found), "<main>"]
    body.append('<section id="along"><h2>Error along the path</h2>')
    for series, drawn in zip(found.series, along, strict=True):
        body += [figure(drawn), _numbers(series)]
    body.append("</section>")
    body += [_roughness(found, figure(heights)), _scene(), _repeats(found), _left(found, figure(lines))]
    body += [_assumed(found), "</main>"]
    return document(f"{found.robot.title}: {headline(found)}", "\n".join(body))


def headline(found: Verification) -> str:
    """What came out, in one sentence."""
    trials = found.slow.trials
    before, after = trials["uncorrected"].figures.rms_mm, trials["corrected"].figures.rms_mm
    if after < before:
        ratio = before / after
        return f"The corrected path is {ratio:.{0 if ratio >= 10 else 1}f} times as accurate"
    return "The correction does not make this path better"


def _head(found: Verification) -> str:
    links = "".join(f'<a href="{file}">{name}</a>' for file, name in LINKS.items())
    said = [
        f'<p class="lead">The true robot ran the path in closed loop: controller, drives, gears, springs and '
        f"loads in one dynamic model, {len(found.path)} samples. Commands were corrected by what the model "
        "knows.</p>"
    ]
    ratio = found.slow.ratio_to_perfect
    if ratio is not None:
        said.append(
            f'<p class="lead">A model without any error would reach '
            f"{mm(found.slow.trials['perfect'].figures.rms_mm)} mm; this one comes to "
            f"{ratio:.2f} times that.</p>"
        )
    return (
        f'<header><div><div class="origin"><span>{escape(found.robot.title)} · {escape(found.path.title)}'
        f'</span><nav aria-label="Files">{links}</nav></div><h1>{escape(headline(found))}</h1>'
        f"{''.join(said)}{tiles([_tile(series) for series in found.series])}</div></header>"
    )


def _tile(series: Series) -> dict[str, str]:
    before, after = (series.trials[name].figures for name in ("uncorrected", "corrected"))
    return {
        "label": f"RMS error at {speed_text(series.speed)}",
        "before": mm(before.rms_mm),
        "after": mm(after.rms_mm),
        "unit": "mm",
        "note": f"largest {mm(before.max_mm)} → {mm(after.max_mm)} mm",
    }


def _numbers(series: Series) -> str:
    rows = []
    for name, trial in series.trials.items():
        f = trial.figures
        values = (f.mean_mm, f.rms_mm, f.p95_mm, f.max_mm, f.across_max_mm)
        rows.append([NAMES[name], *(mm(value) for value in values)])
    head = ("Command", "Mean, mm", "RMS, mm", "95 %, mm", "Largest, mm", "Largest across, mm")
    caption = (
        f"At {speed_text(series.speed)}, {series.time[-1]:.3g} s. Distance of the tool from where it should "
        "be at that instant; across: from the path, whenever it passes."
    )
    return table(caption, head, rows, numbers=(1, 2, 3, 4, 5))


def _roughness(found: Verification, drawn: str) -> str:
    rows = [
        [speed_text(series.speed), NAMES[name], mm(trial.figures.ra_mm), mm(trial.figures.rz_mm)]
        for series in found.series
        for name, trial in series.trials.items()
    ]
    n = ", ".join(f"{x:.2f}" for x in found.normal + 0.0)
    caption = (
        f"Error along the normal ({n}) of the path's plane: R_a its mean size, R_z highest peak minus "
        "deepest valley."
    )
    listed = table(caption, ("Speed", "Command", "R_a, mm", "R_z, mm"), rows, numbers=(2, 3))
    return f'<section id="roughness"><h2>As a surface</h2>{drawn}{listed}</section>'


def _scene() -> str:
    return (
        '<section id="scene"><h2>In space</h2><p class="quiet">The robot runs the path; tool paths with '
        'their errors enlarged. <a href="scene.html">Open it alone</a>.</p><iframe src="scene.html" '
        'loading="lazy" title="3-D scene of the robot on its path"></iframe></section>'
    )


def _repeats(found: Verification) -> str:
    rows = [
        [
            NAMES[r.name],
            str(r.count),
            speed_text(r.speed),
            mm(r.at_mm),
            "not known" if r.rt_mm is None else mm(r.rt_mm),
        ]
        for r in found.repeats
    ]
    caption = (
        "ISO 9283 path accuracy AT (largest distance of the runs' mean from the path) and repeatability RT "
        "(largest mean plus three standard deviations about that mean)."
    )
    head = ("Command", "Runs", "Speed", "AT, mm", "RT, mm")
    listed = table(caption, head, rows, numbers=(1, 2, 3, 4))
    return f'<section id="repeats"><h2>Repeated runs</h2>{listed}</section>'


def _left(found: Verification, drawn: str) -> str:
    rows = [
        [
            speed_text(series.speed),
            f"{line.frequency_hz:.3g}",
            f"{1e3 * line.amplitude_mm:.2g}",
            line.cause or "none known",
        ]
        for series in found.series
        for line in series.trials["corrected"].lines
    ]
    head = ("Speed", "Frequency, Hz", "Amplitude, µm", "Runs with the gear of")
    listed = table("The highest lines in the corrected path's error.", head, rows, numbers=(1, 2))
    return f'<section id="left"><h2>What is left</h2>{drawn}{listed if rows else ""}</section>'


def _assumed(found: Verification) -> str:
    slow = found.slow.trials["corrected"]
    facts = [
        ["Half the step moves the tool by", f"{found.step_change_um:.2g} µm at most"],
        ["The model itself expects, at rest", f"{mm(found.expected_mm)} mm RMS"],
        ["Integration", "third-order Runge–Kutta, fixed step of 1 ms, continuous plant"],
        ["Servo error, largest", f"{1e6 * abs(slow.motor).max():.3g} µrad (or µm)"],
    ]
    notes = f"<h4>Assumed or left out</h4>{bullets(found.notes)}" if found.notes else ""
    return (
        '<section id="assumed"><h2>How it was computed</h2>'
        f"{table('', ('', ''), facts, heads=False)}{notes}</section>"
    )

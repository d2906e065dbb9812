"""The page: one self-contained HTML file, verdict first. It needs no network and no script."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from .content import Content, Material
from .drawing import Figure
from .parts import bullets, document, figure, table, tiles

LINKS = {"report.pdf": "PDF", "scene.html": "3-D scene", "result.json": "Numbers", "model.toml": "Model"}


def page(material: Material) -> str:
    """The whole page as text."""
    said, shown = material.said, material.figures
    title = f"{said['robot']}: {said['verdict']['headline']}"
    body = [_head(said), "<main>", _stages(said, shown), _causes(material), _scene(), _limits(said)]
    body += [_data(said, shown), "</main>", _foot(said)]
    return document(title, "\n".join(body))


def _head(said: Content) -> str:
    verdict = said["verdict"]
    links = "".join(f'<a href="{file}">{name}</a>' for file, name in LINKS.items())
    proof = ""
    if said["proof"]:
        words, link = said["proof"]
        proof = f'<p class="proof"><a href="{escape(link)}">{escape(words)}</a></p>'
    more = f'<p class="lead">{escape(verdict["more"])}</p>' if verdict["more"] else ""
    test = f'<p class="lead">{escape(said["test"])}</p>' if said["test"] else ""
    return (
        f'<header><div><div class="origin"><span>{escape(said["robot"])} · {escape(said["campaign"])}</span>'
        f'<nav aria-label="Files">{links}</nav></div>'
        f'<span class="chip {verdict["kind"]}">{escape(verdict["label"])}</span>'
        f'<h1>{escape(verdict["headline"])}</h1>{more}<p class="lead">{escape(said["summary"])}</p>{proof}'
        f"{tiles(said['tiles'])}"
        '<p class="quiet">From the nominal model to the model with everything below in it; 3-D errors on '
        f"poses that were not fitted.</p>{test}</div></header>"
    )


def _stages(said: Content, shown: Mapping[str, Figure]) -> str:
    rows = []
    for number, stage in enumerate(said["stages"]):
        note = f'<span class="stage-note">{escape(stage["note"])}</span>' if stage["note"] else ""
        values = (stage["parameters"], *stage["numbers"])
        numbers = "".join(f'<td class="number">{value}</td>' for value in values)
        final = ' class="final"' if number == len(said["stages"]) - 1 else ""
        rows.append(f'<tr{final}><th scope="row">{escape(stage["name"])}{note}</th>{numbers}</tr>')
    head = ("Parameters", "Mean, mm", "RMS, mm", "Largest, mm", "RMS fitted, mm")
    columns = "".join(f'<th scope="col" class="number">{name}</th>' for name in head)
    return (
        f'<section id="stages"><h2>What each step brings</h2>{figure(shown.get("stages"))}'
        '<div class="scroll"><table><caption>3-D errors on held-out poses. Each stage keeps what the stages '
        f'above it have.</caption><thead><tr><th scope="col">Stage</th>{columns}</tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div><p>{escape(said['remainder'])}</p></section>"
    )


def _causes(material: Material) -> str:
    if not material.said["causes"]:
        return (
            '<section id="causes"><h2>Causes</h2><p>None is needed. What could not be tested, and how small '
            "an effect this campaign would have shown, stands below.</p></section>"
        )
    cards = "".join(_card(cause, material) for cause in material.said["causes"])
    return f'<section id="causes"><h2>Causes</h2>{cards}</section>'


def _card(cause: Content, material: Material) -> str:
    where = f' <span class="where">{escape(cause["where"])}</span>' if cause["where"] else ""
    gain = f"brings <b>{cause['gain']}</b>, " if cause["gain"] else ""
    said = [f"<p>{escape(cause[key])}</p>" for key in ("structure", "sentence") if cause[key]]
    if cause["parameters"]:
        rows = [[p["name"], p["value"], p["interval"], p["meaning"]] for p in cause["parameters"]]
        said.append(table("", ("Parameter", "Value", "95 % interval", "Meaning"), rows, values=(1, 2)))
    if cause["equation"]:
        line = cause["equation"]
        label = f'<svg role="img" aria-label="{escape(line)}" '
        drawn = material.equations.get(line, "").replace("<svg ", label, 1)
        said.append(f'<div class="equation">{drawn or f"<code>{escape(line)}</code>"}</div>')
    said.append(_rivals(cause))
    said.append(figure(material.figures.get(cause["figure"])))
    return (
        f'<article class="card"><header><h3>{escape(cause["title"])}{where}</h3>'
        f'<span class="chip {cause["status"]}">{escape(cause["status_label"])}</span>'
        f'<span class="gain">{gain}{escape(cause["p"])}</span></header>{"".join(said)}</article>'
    )


def _rivals(cause: Content) -> str:
    if not cause["rivals"] and not cause["separate_by"]:
        return ""
    rivals = "; ".join(escape(rival) for rival in cause["rivals"])
    first = f"<p><b>Fits as well:</b> {rivals}</p>" if rivals else ""
    decide = f"<p><b>Would decide:</b> {escape(cause['separate_by'])}</p>" if cause["separate_by"] else ""
    return f'<div class="rivals">{first}{decide}</div>'


def _scene() -> str:
    return (
        '<section id="scene"><h2>In space</h2><p class="quiet">Measured points and errors, enlarged and '
        'coloured by size, before and after. Drag to turn, scroll to zoom; <a href="scene.html">open it '
        'alone</a>.</p><iframe src="scene.html" loading="lazy" title="3-D scene of the robot, the measured '
        'points and their errors"></iframe></section>'
    )


def _limits(said: Content) -> str:
    parts = ['<section id="limits"><h2>What this campaign cannot say</h2>']
    if said["not_testable"]:
        parts.append("<h4>Not tested</h4>" + table("", ("Cause", "Where", "Why"), said["not_testable"]))
    else:
        parts.append("<p>Every cause of the catalogue could be tested.</p>")
    if said["detectable"]:
        caption = "Smaller effects than these would have stayed unseen (80 % power)."
        rows = said["detectable"]
        parts.append("<h4>Smallest size that would show</h4>")
        parts.append(table(caption, ("Cause", "Smallest size, by place"), rows))
    if said["unidentifiable"]:
        parts.append("<h4>What geometry could not tell apart</h4>")
        parts.append(bullets(said["unidentifiable"]))
    return "".join(parts) + "</section>"


def _data(said: Content, shown: Mapping[str, Figure]) -> str:
    parts = ['<section id="data"><h2>The data</h2>']
    parts += [figure(shown.get("histogram")), figure(shown.get("campaign"))]
    if said["faults"]:
        parts.append("<h4>Faults in the data</h4>")
        parts.append(table("", ("Fault", "Where", "What", "Done"), said["faults"]))
    else:
        parts.append("<p>No faults were found in the data.</p>")
    if said["notes"]:
        parts.append("<h4>Notes</h4>" + bullets(said["notes"]))
    parts.append("<h4>Dataset</h4>" + table("", ("", ""), said["facts"], heads=False))
    if said["geometry"]:
        head = ("Frame", "Parameter", "Value", "95 % interval")
        listed = table(f"Intervals: {said['support']}.", head, said["geometry"], numbers=(2, 3))
        title = f"Calibrated geometry, {len(said['geometry'])} parameters"
        parts.append(f"<details><summary>{title}</summary>{listed}</details>")
    return "".join(parts) + "</section>"


def _foot(said: Content) -> str:
    files = "".join(
        f'<tr><th scope="row">{escape(name)}</th><td class="hash">{escape(digest)}</td></tr>'
        for name, digest in said["inputs"]
    )
    inputs = f"<table><caption>Input files, SHA-256</caption><tbody>{files}</tbody></table>" if files else ""
    made = f"Robot workbench {said['version']}"
    return f'<footer><div><div class="scroll">{inputs}</div><p>{escape(made)}</p></div></footer>'

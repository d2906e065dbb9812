"""Texts from files are only texts: nothing of them acts in page, scene or PDF, no page asks the network."""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import diagnosis_example as example
import numpy as np
import pytest
from html_check import Checker, parse

from workbench.correction.paths import Path as ToolPath
from workbench.diagnosis.found import Rival
from workbench.diagnosis.result import Diagnosis
from workbench.effects.place import Parameter
from workbench.report.content import gather
from workbench.report.drawing import Figure
from workbench.report.legible import legible
from workbench.report.meshcat_page import with_panel
from workbench.report.page import page
from workbench.report.pdf import pdf, typeset
from workbench.report.scene import Shown, scene
from workbench.report.study import Box, Section, Study, Table, Tile
from workbench.report.study_page import index, said_of
from workbench.report.study_page import page as study_page
from workbench.robot.description import load_robot
from workbench.simulation.closed_loop.cascade import Gains
from workbench.simulation.closed_loop.measures import Line, figures
from workbench.simulation.closed_loop.modes import Modes
from workbench.simulation.closed_loop.page import page as proof_page
from workbench.simulation.closed_loop.repeatability import Repeatability
from workbench.simulation.closed_loop.verification import Repeats, Series, Trial, Verification
from workbench.studies.blind.blind_page import page as blind_page

PLAIN = "a plain text #("  # no Typst mathematics, as the other one
HOSTILE = (
    "</title></style></script><script>alert(1)</script><img src=x onerror=alert(1)> \" onload=\"alert(1) ' "
    "{{7*7}} {% raw %} ${7*7} # $x$ _y_ *z* \\n @ref `c` // [k] {m} ~ = - + 1.é #eval(\"1\") &lt; --> ]]> "
    "\x00\x07\x1b[31m\x7f\x85\u202e\ufffe"
)  # fmt: skip
READ = legible(HOSTILE)
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="9pt" height="9pt"><g></g></svg>'


def diagnosis_of(text: str) -> Diagnosis:
    """A diagnosis whose every text is this one."""
    full = example.diagnosis(20, 2)
    finding = full.causes[0]
    assert finding.evidence is not None
    return replace(
        full,
        robot_title=text,
        campaign=text,
        headline=text,
        causes=tuple(
            replace(
                finding,
                title=text,
                sentence=text,
                structure=text,
                separate_by=text,
                equation=text,
                where=replace(finding.where, joint=text),
                rivals=(Rival(text, finding.where, 0.3),),
                parameters=(Parameter(text, 1.0, 0.1, text, text),),
                evidence=replace(finding.evidence, x_name=text, y_name=text),
            )
            for finding in full.causes[:1]
        ),
        not_testable=tuple(replace(item, cause=text, why=text) for item in full.not_testable[:1]),
        detectable=tuple(
            replace(item, cause=text, where=replace(item.where, joint=text)) for item in full.detectable[:1]
        ),
        faults=tuple(
            replace(fault, kind=text, pose_id=text, target=text, what=text) for fault in full.faults
        ),
        stages=tuple(replace(stage, note=text) for stage in full.stages),
        notes=(text,),
        unidentifiable=(text,),
        facts={text: text},
        inputs={text: text},
        proof=(text, "path/verify.html"),
        version=text,
    )


def study_of(text: str) -> Study:
    drawn = Figure("drawn", text, text, SVG)
    table = Table(text, (text, text), [[text, text]], text)
    return Study(
        name="case",
        robot=replace(load_robot("kr500"), title=text),
        title=text,
        source=text,
        headline=text,
        summary=text,
        tiles=[Tile(text, text, text, text, text)],
        sections=[Section(text, [text, table, drawn])],
        box=Box(text, text, text),
        assumed=[(text, text, text)],
        numbers={},
        shown=Shown(np.zeros(6), np.zeros((0, 3)), {}),
        picture=drawn,
        files={"model.toml": text},
    )


def proof_of(text: str) -> Verification:
    t = np.linspace(0.0, 1.0, 50)
    error = 1e-4 * np.stack([np.sin(t), np.cos(t), t], axis=1)
    lines = (Line(3.0, 0.01, text),)
    trials = {
        name: Trial(k * error, k * error, np.tile(np.eye(4), (50, 7, 1, 1)), np.zeros((50, 6)),
                    figures(k * error, k * error, k * error[:, 2], t), lines)
        for name, k in (("uncorrected", 9.0), ("corrected", 1.0))
    }  # fmt: skip
    some, two = np.ones(6), np.ones((6, 2))
    gains = Gains(some, some, some, two, two)
    return Verification(
        robot=replace(load_robot("kr500"), title=text),
        path=ToolPath(t, q=np.zeros((50, 6)), title=text),
        X=np.tile(np.eye(4), (50, 1, 1)),
        normal=np.array([0.0, 0.0, 1.0]),
        series=(Series(0.05, t, trials, 5e-4, 0.01, refined=True, gains=gains),),
        repeats=(Repeats("corrected", 2, 0.05, 0.1, None),),
        expected_mm=0.01,
        same=False,
        repeatability=Repeatability(0.08, 0.02),
        modes=Modes((9.0, 12.0), (11.0, 14.0), (text,), (12.0, 15.0), (10.0, 13.0)),
        sweep=None,
        notes=(text,),
    )


def blind_of(text: str) -> str:
    case = SimpleNamespace(
        key=text, robot=text, records=1, targets=1, noise=text, sigma_mm=0.01, loads=2, form_left=None,
        truths=[{"label": text, "strength": 1.0}], found=[{"label": text, "status": text, "rivals": [text]}],
        faults=[text], verdict=text,
    )  # fmt: skip
    return blind_page(text, text, [Figure("drawn", text, text, SVG)], [vars(case)])


def in_meshcat(panel: str, data: dict[str, Any]) -> Callable[[str], str]:
    """A scene's page without Drake: Meshcat's frame with a panel."""
    frame = "<!DOCTYPE html>\n<html>\n<head><title>Drake MeshCat</title></head>\n<body>\n</body>\n</html>\n"

    def made(text: str) -> str:
        named = json.loads(json.dumps(data).replace("TEXT", json.dumps(text)[1:-1]))
        return with_panel(frame, panel, named, text)

    return made


PAGES: dict[str, Callable[[str], str]] = {
    "diagnosis": lambda text: page(gather(diagnosis_of(text))),
    "study": lambda text: study_page(study_of(text), said_of(study_of(text))),
    "list of studies": lambda text: index([study_of(text)]),
    "proof": lambda text: proof_page(proof_of(text)),
    "blind study": blind_of,
}
SCENES = {
    "scene": in_meshcat("scene_overlay.html", {"stages": [{"name": "TEXT"}], "ghost": "TEXT", "speed": ""}),
    "path": in_meshcat("path_overlay.html", {"commands": [{"name": "TEXT"}], "speed": "TEXT", "ghost": ""}),
}


@pytest.fixture(scope="module", params=[*PAGES, *SCENES])
def pair(request: pytest.FixtureRequest) -> tuple[str, Checker, Checker]:
    """A page with plain texts and with hostile ones."""
    make = {**PAGES, **SCENES}[request.param]
    return request.param, parse(make(PLAIN)), parse(make(HOSTILE))


def test_hostile_texts_make_no_tag_and_no_attribute(pair: tuple[str, Checker, Checker]) -> None:
    name, plain, hostile = pair
    assert hostile.tags == plain.tags
    assert "".join(hostile.text).count(READ) >= (1 if name in SCENES else 3)
    assert len(hostile.scripts) == (1 if name in SCENES else 0)
    assert not [a for _, attributes in hostile.tags for a in attributes if a.startswith("on")]
    if name in SCENES:
        data = json.loads(re.search(r"const data = (\{.*\});", hostile.scripts[0])[1])  # type: ignore[index]
        assert READ in (data["ghost"], data["speed"])


def test_no_page_may_ask_the_network(pair: tuple[str, Checker, Checker]) -> None:
    name, _, hostile = pair
    policy = hostile.policy
    assert policy["default-src"] == policy["base-uri"] == policy["form-action"] == ["'none'"]
    allowed = {source for sources in policy.values() for source in sources}
    assert allowed <= {"'none'", "'self'", "'unsafe-inline'", "file:", "data:", "blob:"}
    assert ("script-src" in policy) == (name in SCENES)
    assert not [link for link in hostile.links if ":" in link or link.startswith("//")]


def study_pdf(study: Study) -> bytes:
    return typeset("study.typ", said_of(study), {drawn.name: drawn for drawn in study.figures})


@pytest.mark.parametrize(
    "make",
    [lambda: pdf(gather(diagnosis_of(HOSTILE))),
     lambda: study_pdf(study_of(HOSTILE))],
)  # fmt: skip
def test_hostile_texts_make_a_pdf_that_only_shows(make: Callable[[], bytes]) -> None:
    made = make()
    assert made.startswith(b"%PDF")
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", made, re.DOTALL)
    inside = [made]
    for stream in streams:
        try:
            inside.append(zlib.decompress(stream))
        except zlib.error:
            inside.append(stream)
    everything = b"\n".join(inside)
    assert len(inside) > 3
    for action in (b"/JavaScript", b"/JS", b"/URI", b"/Launch", b"/OpenAction", b"/AA", b"/EmbeddedFile"):
        assert not re.search(action + rb"\b", everything), action


def test_drakes_scene_keeps_hostile_texts_off() -> None:
    robot, shown = load_robot("kr500"), []
    for text in (PLAIN, HOSTILE):
        diagnosis = replace(diagnosis_of(text), errors=None)
        shown.append(scene(diagnosis, robot, np.zeros(6), np.zeros(6), text))
    plain, hostile = (re.findall(r"</?(?:script|title|style)\b", html) for html in shown)
    assert hostile == plain
    assert str(robot.urdf.parent) not in shown[1]


def test_what_has_no_shape_is_marked() -> None:
    assert legible("a\x00\x1b\u202e\ud800\ufffeb\tc\n") == "a" + 5 * "\ufffd" + "b\tc\n"
    assert legible({"a\x00": ["b\x00", ("c\x00", 1.0)]}) == {"a�": ["b�", ("c�", 1.0)]}
    array = np.zeros(3)
    assert legible(array) is array

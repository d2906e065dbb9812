"""A study's pages from several seeds beside each other: how often each claim holds, what a page says wrong.

A sentence about what a run found stands in a choice on a claim, or gives numbers and no more. Faults are: a
claim that is said though it fails in too many of all seeds' draws, a choice whose two sentences are the same,
a page that stays the same though a claim turned, a number of the run that is written out in the story, two
sentences that a choice left without a space.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np

from ..report.story import CHOICE
from ..report.study import FEWEST, LEAST

NUMBER = re.compile(r"[-−+]?\d[\d\u202f]*(?:[.,]\d+)?(?:\s?[·×]\s?10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?|10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")
WRITTEN = re.compile(r"(?<![\w.])\d+\.\d+")
COMPARES = re.compile(
    r"\b(falls?|rises?|more|less|fewer|better|worse|larger|smaller|wider|narrower|only|hardly|most|half|twice|"
    r"limit|beats?|brings?|alone|enough|decides?|tells?|shows?|follows?|never|always|none|nothing|all)\b"
)
LEAST_DIGITS = 3  # of a number that hardly stands in a text by chance


@dataclass(frozen=True)
class Page:
    """result: of `result.json`; sentences: of `index.html`, as they are read."""

    result: Mapping[str, Any]
    sentences: Sequence[str]

    @property
    def masked(self) -> frozenset[str]:
        """The sentences without their numbers."""
        return frozenset(NUMBER.sub("#", sentence) for sentence in self.sentences)


def read_page(folder: Path) -> Page:
    """The page that a run wrote."""
    html = (folder / "index.html").read_text(encoding="utf-8")
    html = html.partition("</header>")[2] or html
    html = html.partition('<section id="claims">')[0]  # what follows is about the page
    html = re.sub(r"<(script|style|svg)\b.*?</\1>", " ", html, flags=re.DOTALL)
    blocks = re.split(r"</?(?:p|h\d|t[dhr]|div|section|figcaption|li|caption)\b[^>]*>", html)
    texts = [re.sub(r"\s+", " ", unescape(re.sub(r"<[^>]+>", "", block))).strip() for block in blocks]
    sentences = [part for text in texts for part in re.split(r"(?<=[.!?]) (?=[A-ZΔ“])", text) if part]
    return Page(json.loads((folder / "result.json").read_text(encoding="utf-8")), sentences)


def claims_of(pages: Sequence[Page]) -> dict[str, dict[str, Any]]:
    """Claim → words; holds and said: in how many seeds; share: of the draws of all seeds, or of the seeds;
    draws: of all seeds."""
    found = {}
    for name in pages[0].result["claims"]:
        each = [page.result["claims"][name] for page in pages]
        draws = np.array([one["draws"] for one in each], dtype=float)
        shares = np.array([one["share"] if one["draws"] else float(one["here"]) for one in each])
        weights = draws if draws.any() else np.ones(len(each))
        found[name] = {
            "words": each[0]["words"],
            "holds": sum(one["here"] for one in each),
            "said": sum(one["stands"] for one in each),
            "share": round(float(np.average(shares, weights=weights)), 3),
            "draws": int(draws.sum()),
        }
    return found


def faults(story: str, pages: Sequence[Page]) -> list[str]:
    """What the pages of one study, or its story alone, say wrong, a line each. story: the text of its
    `story.md`."""
    if not pages:
        return _same_words(story)
    return [
        *_stuck(pages),
        *_said_too_often(pages),
        *_same_words(story),
        *_stay(pages),
        *_written_out(story, pages),
    ]


def to_read(pages: Sequence[Page]) -> list[str]:
    """Sentences that compare, stand in all pages and have a number that moves: for a reader to judge."""
    always = frozenset.intersection(*(page.masked for page in pages))
    out = []
    for masked in sorted(always):
        said = {s for page in pages for s in page.sentences if NUMBER.sub("#", s) == masked}
        if len(said) > 1 and COMPARES.search(masked):
            out.append(masked)
    return out


def _stuck(pages: Sequence[Page]) -> list[str]:
    stuck = {s for page in pages for s in page.sentences if re.search(r"[a-z]{3}[.!?][A-Z][a-z]", s)}
    return [f"no space between two sentences: {sentence}" for sentence in sorted(stuck)]


def _said_too_often(pages: Sequence[Page]) -> list[str]:
    out = []
    for name, one in claims_of(pages).items():
        if one["draws"] < FEWEST or not one["said"]:
            continue
        error = np.sqrt(LEAST * (1 - LEAST) / one["draws"])
        if one["share"] < LEAST - 2 * error:
            out.append(f"{name}: said in {one['said']} seeds, holds in {one['share']:.0%} of all draws")
    return out


def _same_words(story: str) -> list[str]:
    choices = [found for found in CHOICE.finditer(story) if found[4] is not None]
    return [
        f"{found[2]}: both sentences of its choice are the same"
        for found in choices
        if " ".join(found[3].split()) == " ".join(found[4].split())
    ]


def _stay(pages: Sequence[Page]) -> list[str]:
    out = []
    for name in pages[0].result["claims"]:
        stands: dict[bool, list[frozenset[str]]] = {True: [], False: []}
        for page in pages:
            stands[page.result["claims"][name]["stands"]].append(page.masked)
        if any(one == other for one in stands[True] for other in stands[False]):
            out.append(f"{name}: turned, and the page stays")
    return out


def _written_out(story: str, pages: Sequence[Page]) -> list[str]:
    """Numbers that move with the seed and stand in the story as digits, as the first page has them."""
    numbers = [page.result["numbers"] for page in pages]
    moving = [key for key, value in numbers[0].items() if any(n.get(key) != value for n in numbers[1:])]
    prose = story.partition("\n## Assumed")[0]
    words = {
        w for w in WRITTEN.findall(re.sub(r"\{[^{}]*\}", "", prose)) if len(w.strip("0.")) > LEAST_DIGITS
    }
    return [
        f"{key}: {word} is written out in the story"
        for word in sorted(words)
        for key in moving
        if word in {f"{scale * abs(numbers[0][key]):.{len(word.partition('.')[2])}f}" for scale in (1, 100)}
    ]

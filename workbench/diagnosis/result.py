"""The one result object: what a diagnosis found. Reports, scene and `result.json` read it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any, Literal

from ..effects.place import Parameter
from .found import (
    GIVEN,
    Detectable,
    FaultFound,
    Finding,
    GivenFact,
    Noise,
    NotTestable,
    OfCampaign,
    PoseErrors,
    Revealed,
    Stage,
    TestFigures,
)
from .found_json import (
    bounds_json,
    figures_json,
    finding_json,
    given_json,
    noise_json,
    number_json,
    of_campaign_json,
    stage_json,
)

Verdict = Literal["nothing_missing", "named", "ambiguous", "unknown"]


def html_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A plain table for notebooks; every text is escaped."""
    first = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{first}</tr></thead><tbody>{body}</tbody></table>"


@dataclass(frozen=True)
class Diagnosis:
    """Everything that a diagnosis found. ceiling_mm: RMS error of held-out poses that any smooth model
    reaches. proof: what a closed-loop run of the model showed, and the page that
    shows it. revealed: what a simulation had hidden. bounds_mm: see `with_bounds`. too_few: the poses
    are too few to say that nothing is missing."""

    robot: str
    robot_title: str
    campaign: str
    n_poses: int
    n_points: int
    noise: Noise
    stages: tuple[Stage, ...]
    verdict: Verdict
    headline: str
    causes: tuple[Finding, ...]
    ceiling_mm: float
    remainder_chi2: float
    remainder_dof: float
    remainder_p: float
    not_testable: tuple[NotTestable, ...] = ()
    detectable: tuple[Detectable, ...] = ()
    faults: tuple[FaultFound, ...] = ()
    test: TestFigures | None = None
    bounds_mm: tuple[float, float] | None = None
    too_few: bool = False
    notes: tuple[str, ...] = ()
    given: tuple[GivenFact, ...] = ()
    geometry: tuple[Parameter, ...] = ()
    unidentifiable: tuple[str, ...] = ()
    facts: Mapping[str, str] = field(default_factory=dict)
    campaigns: tuple[OfCampaign, ...] = ()
    errors: PoseErrors | None = None
    proof: tuple[str, str] | None = None
    revealed: Revealed | None = None
    version: str = ""
    inputs: Mapping[str, str] = field(default_factory=dict)

    @property
    def start(self) -> str:
        """What the errors begin with: the nominal robot, or a model that an earlier diagnosis extended."""
        return "model as given" if "Model" in self.facts else "nominal model"

    @property
    def with_given(self) -> Stage | None:
        """The stage of geometry and what was given; None where nothing was."""
        return next((stage for stage in self.stages if stage.name == f"geometry + {GIVEN}"), None)

    def __repr__(self) -> str:
        stages = ", ".join(f"{stage.name} {stage.heldout_rms_mm:.4f} mm" for stage in self.stages)
        causes = "; ".join(f"{finding.label} {finding.status}" for finding in self.causes)
        said = f"Diagnosis of {self.robot_title}, {self.campaign}: {self.headline}"
        return f"{said} Held-out RMS: {stages}." + (f" Causes: {causes}." if causes else "")

    def _repr_html_(self) -> str:
        """For notebooks: the headline, the stages and the causes."""
        stages = [(s.name, f"{s.heldout_rms_mm:.4f}", f"{s.heldout_max_mm:.4f}") for s in self.stages]
        causes = [(f.label, f.status, f"{f.gain_mm:.4f}") for f in self.causes]
        tables = html_table(("stage", "held-out RMS, mm", "max, mm"), stages)
        tables += html_table(("cause", "status", "gain, mm"), causes) if causes else ""
        return f"<p><b>{escape(self.headline)}</b></p>{tables}"

    def to_json(self) -> dict[str, Any]:
        """`result.json`, whose keys are fixed by its schema number."""
        return {
            "schema": 1,
            "robot": self.robot,
            "campaign": self.campaign,
            "n_poses": self.n_poses,
            "n_points": self.n_points,
            "noise": noise_json(self.noise),
            "stages": [stage_json(stage) for stage in self.stages],
            "test": figures_json(self.test) if self.test else None,
            "verdict": self.verdict,
            "headline": self.headline,
            "causes": [finding_json(finding) for finding in self.causes],
            "ceiling": {"heldout_rms_mm": number_json(self.ceiling_mm)},
            "remainder": {
                "chi2": number_json(self.remainder_chi2),
                "dof": number_json(self.remainder_dof),
                "p_value": number_json(self.remainder_p),
            },
            "not_testable": [
                {"cause": item.cause, **item.where.keys(), "why": item.why} for item in self.not_testable
            ],
            "detectable": [
                {"cause": item.cause, **item.where.keys(), "size": number_json(item.size), "unit": item.unit}
                for item in self.detectable
            ],
            "faults": [fault.to_json() for fault in self.faults],
            "bounds_mm": bounds_json(self.bounds_mm),
            "notes": list(self.notes),
            "given": [given_json(fact) for fact in self.given],
            **({"campaigns": [of_campaign_json(one) for one in self.campaigns]} if self.campaigns else {}),
            "inputs": dict(self.inputs),
            "version": self.version,
        }

"""Diagnoses made up for tests of the report: realistic in size and shape, not computed by a fit."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from workbench.diagnosis.found import (
    Decision,
    Detectable,
    Evidence,
    FaultFound,
    Finding,
    GivenFact,
    Noise,
    NotTestable,
    PoseErrors,
    Rival,
    Stage,
    TestFigures,
)
from workbench.diagnosis.result import Diagnosis
from workbench.effects.place import Parameter, Where
from workbench.robot.description import load_robot
from workbench.robot.rigid_plant import rigid_twin

Array = NDArray[np.float64]
SIGMA = 3e-5
LIMITS = np.radians([(-120, 120), (-100, -20), (0, 120), (-150, 150), (-100, 100), (-150, 150)])
TARGETS = np.array([(0.25, 0.1, 0.05), (-0.1, 0.22, 0.05), (-0.1, -0.18, 0.12)])


def diagnosis(n_poses: int = 200, loads: int = 2, seed: int = 0) -> Diagnosis:
    """Three causes (one ambiguous), one outlier, a test campaign, everything filled in."""
    random = np.random.default_rng(seed)
    q = np.tile(random.uniform(LIMITS[:, 0], LIMITS[:, 1], (n_poses, 6)), (loads, 1))
    load = np.repeat(np.arange(loads), n_poses)
    side = np.where(random.random(len(q)) < 0.5, -1.0, 1.0)
    errors, extra = _errors(q, load, side, random)
    stages = _stages(errors)
    return Diagnosis(
        robot="kr500",
        robot_title="KUKA KR 500 R2830",
        campaign="KR 500, laser tracker, 2 loads",
        n_poses=len(q),
        n_points=len(errors.points),
        noise=Noise(0.03, "stated", "Stated in the campaign file: 0.03 mm per axis, one sigma."),
        stages=stages,
        verdict="ambiguous",
        headline="Gear error in joint 4 and backlash in joint 5 are certain; "
        "the gravity compensator or joint 2's stiffness explains the rest",
        causes=_findings(q, load, side, random, extra),
        ceiling_mm=0.05,
        remainder_chi2=3561.0,
        remainder_dof=3528.0,
        remainder_p=0.34,
        not_testable=(
            NotTestable("thermal_growth", "no column temp_degC and no column t_s in poses.csv"),
            NotTestable("drift", "no column t_s in poses.csv"),
            NotTestable("readback_joints", "no columns r1_deg to r6_deg in poses.csv"),
            NotTestable("foundation", "no target on the base", Where(link="base_link")),
        ),
        detectable=(
            Detectable("backlash", Where(joint="joint_2"), 6e-6, "rad"),
            Detectable("wrist_coupling", Where(joint="joint_6", other="joint_5"), 9.5e-6, "1", "coupling"),
            Detectable("link_bending", Where(link="link_2"), 3.1e-10, "1/(N·m)"),
            Detectable("payload", Where(payload="heavy"), 1.4, "kg"),
            Detectable("gear_ratio", Where(joint="joint_3"), 1.1e-5, "1", "relative"),
        ),
        faults=(
            FaultFound("outlier", "117", "T2", "4.1 mm away from where all other poses put it", "left out"),
        ),
        test=TestFigures(
            "KR 500, 50 test poses, heavy load", 2.47, 0.071, 0.079, 0.196, 6.02, 150, 0.071, 0.079
        ),
        notes=("The three targets were re-fitted; their nominal places were 0.2 mm off.",),
        given=(
            GivenFact(
                "link_mass",
                Where(link="link_2"),
                "mass_kg 311 ± 2",
                "weighed",
                Parameter("mass", 3.0, 2.0, "kg"),
                Parameter("mass", 9.0, 41.0, "kg"),
                Parameter("mass", 3.1, 2.0, "kg"),
                True,
                "Given and kept to: link_mass(link_2): mass_kg 311 ± 2.",
            ),
            GivenFact(
                "backlash",
                Where(),
                "no backlash(joint_5)",
                obeyed=False,
                sentence="Given, but the data contradict it: no backlash(joint_5).",
            ),
        ),
        geometry=_geometry(random),
        unidentifiable=(
            "joint_1: zero angle (cannot be told from the instrument's frame)",
            "joint_6: length along its axis (cannot be told from the targets)",
        ),
        facts={
            "Poses": "400 (200 joint positions, 2 loads)",
            "Targets": "3 on the flange",
            "Payloads": "none, heavy (250 kg)",
            "Volume": "3.1 m × 4.2 m × 2.6 m",
            "Instrument": "one set-up, laser tracker",
            "Frame": "fitted together with the targets, on all poses of a stage",
        },
        errors=errors,
        version="0.1.0",
        inputs={
            "campaign.toml": "9f2c4b7d" * 8,
            "poses.csv": "01ab34cd" * 8,
            "points.csv": "77e0d1f2" * 8,
            "kr500.toml": "5b6c0a19" * 8,
            "kr500.urdf": "c3d2e1f0" * 8,
        },
    )


def nothing_missing() -> Diagnosis:
    """Geometry explains the data to the noise."""
    full = diagnosis(60, 1)
    assert full.errors is not None
    return replace(
        full,
        verdict="nothing_missing",
        headline="Nothing is missing: a geometric calibration explains the data to the noise",
        causes=(),
        stages=(full.stages[0], replace(full.stages[1], heldout_rms_mm=0.055, heldout_mean_mm=0.05,
                                        heldout_max_mm=0.12, fit_rms_mm=0.052)),
        errors=replace(full.errors, error_geometry=full.errors.error_final),
        ceiling_mm=0.05,
        remainder_chi2=520.0,
        remainder_dof=512.0,
        remainder_p=0.4,
        faults=(),
        notes=(),
        test=None,
    )  # fmt: skip


def unknown() -> Diagnosis:
    """Something structured is left that no cause explains."""
    full = diagnosis(80, 1)
    left = Finding(
        cause="unknown",
        title="Something that no cause of the catalogue explains",
        where=Where(joint="joint_3"),
        status="named",
        gain_mm=0.0,
        probability=1.0,
        structure="depends on joint_3",
        sentence="The remainder varies with joint 3, about ten times in its range.",
        evidence=full.causes[0].evidence,
        separate_by="measure joint 3 in steps of 2° with all other joints at rest",
    )
    return replace(
        full,
        verdict="unknown",
        headline="Joint 3 does something that no cause of the catalogue explains",
        causes=(*full.causes[:1], left),
        stages=full.stages[:3],
        remainder_p=3e-9,
        ceiling_mm=0.05,
        remainder_chi2=1240.0,
        remainder_dof=690.0,
    )


def bare() -> Diagnosis:
    """The least that a diagnosis can carry: no evidence, no errors, noise from the residual."""
    full = diagnosis(20, 1)
    return replace(
        full,
        verdict="named",
        headline="Joint 2 is softer than the model says",
        noise=Noise(0.041, "residual", "No noise stated and no repeated poses: taken from the residual."),
        causes=(replace(full.causes[0], evidence=None, parameters=(), equation="", sentence=""),),
        stages=(full.stages[0], full.stages[1], replace(full.stages[2], heldout_max_mm=math.nan)),
        ceiling_mm=0.05,
        remainder_chi2=math.nan,
        remainder_dof=math.nan,
        remainder_p=math.nan,
        not_testable=(),
        detectable=(),
        faults=(),
        test=None,
        notes=(),
        geometry=(),
        unidentifiable=(),
        facts={},
        errors=None,
        inputs={},
    )


def _places(q: Array) -> Array:
    """Targets on the KR 500's flange, base frame: (N, T, 3) [m]."""
    robot = load_robot("kr500")
    twin = rigid_twin(robot)
    flange = twin.plant.GetBodyByName(robot.flange)
    places = []
    for joints in q:
        twin.set_positions(joints)
        X_BF = twin.plant.EvalBodyPoseInWorld(twin.context, flange)
        places.append(X_BF.translation() + TARGETS @ X_BF.rotation().matrix().T)
    return np.array(places)


def _errors(q: Array, load: Array, side: Array, random: np.random.Generator) -> tuple[PoseErrors, Array]:
    """Errors per point, and the gear error of joint 4 per pose [rad]."""
    points = _places(q)
    n, t = points.shape[:2]
    gear = 2.1e-4 * np.sin(200 * q[:, 3] + 0.72)
    across = np.stack([-np.sin(q[:, 0]), np.cos(q[:, 0]), 0.3 * np.cos(q[:, 2])], axis=1)
    noise = random.normal(0, SIGMA, (n, t, 3))
    effects = 0.42 * gear[:, None, None] * across[:, None, :] + np.zeros((n, t, 3))
    effects = effects + 0.3 * 3.4e-5 * side[:, None, None] * across[:, None, ::-1]
    effects[..., 2] -= (1.1e-4 * load * np.cos(q[:, 1]))[:, None]
    smooth = np.stack([np.sin(q[:, 0] + 0.4), np.cos(q[:, 1] * 1.3), 0.4 - np.sin(q[:, 2])], axis=1)
    nominal = 1.9e-3 * smooth[:, None, :] + 1.1e-3 * np.sin(q[:, 3])[:, None, None] * across[:, None, :]
    flat = (n * t, 3)
    pose, target = np.divmod(np.arange(n * t), t)
    final = 1.06 * noise
    if n > 117:
        wrong = np.array([2.5e-3, -2.9e-3, 1.5e-3])
        effects[117, 1] += wrong
        final[117, 1] += wrong
    errors = PoseErrors(
        points.reshape(flat),
        (nominal + effects + noise).reshape(flat),
        (effects + 1.02 * noise).reshape(flat),
        final.reshape(flat),
        pose,
        target,
    )
    return errors, gear


def _stages(errors: PoseErrors) -> tuple[Stage, ...]:
    def stage(name: str, parameters: int, rms: float, peak: float, note: str = "") -> Stage:
        return Stage(name, parameters, rms, 0.89 * rms, peak, 0.96 * rms, note)

    rms = 1e3 * float(np.sqrt(np.mean(np.sum(errors.error_nominal**2, axis=1))))
    first = "geometry + gear_kinematic_error(joint_4)"
    return (
        stage("nominal", 0, rms, 2.1 * rms),
        stage("geometry", 33, 0.151, 0.412, "2 directions held at the nominal model: not identifiable"),
        stage(first, 35, 0.109, 0.33),
        stage(f"{first} + gravity_compensator", 36, 0.074, 0.21),
        stage(f"{first} + gravity_compensator + backlash(joint_5)", 37, 0.0561, 0.142),
    )


def _findings(
    q: Array, load: Array, side: Array, random: np.random.Generator, gear: Array
) -> tuple[Finding, ...]:
    noise = random.normal(0, 5e-5, (2, len(q)))
    turn = 2 * np.pi / 200
    folded = np.mod(q[:, 3], turn)
    line = np.linspace(0, turn, 200)
    wave = Evidence("joint_4, folded to one period", "rad", "angle of joint_4", "rad", folded,
                    gear + noise[0], 0.98 * noise[0], line, 2.1e-4 * np.sin(200 * line + 0.72))  # fmt: skip
    pull = -180.0 * np.sin(q[:, 1] + 0.3)
    sag = Evidence("joint_2", "rad", "torque about joint_2", "N·m", q[:, 1], pull + 9e5 * noise[1] * 0.6,
                   9e5 * noise[1] * 0.6, *_line(q[:, 1], lambda x: -180.0 * np.sin(x + 0.3)))  # fmt: skip
    play = Evidence("side of approach of joint_5", "", "angle of joint_5", "rad", side,
                    3.4e-5 * side + 0.4 * noise[1], 0.4 * noise[1],
                    np.array([-1.0, 1.0]), np.array([-3.4e-5, 3.4e-5]))  # fmt: skip
    return (
        Finding(
            cause="gear_kinematic_error",
            title="Gear kinematic error",
            where=Where(joint="joint_4", order=200.0),
            status="named",
            gain_mm=0.042,
            probability=0.999,
            parameters=(
                Parameter("amplitude", 2.1e-4, 3e-6, "rad", "half of peak to peak at the joint"),
                Parameter("phase", 0.72, 0.014, "rad", "where in the period the error is zero"),
            ),
            sentence="Joint 4 runs ahead and lags 200 times per turn, twice per turn of its motor.",
            equation="Delta q = A sin(n q + phi)",
            evidence=wave,
        ),
        Finding(
            cause="gravity_compensator",
            title="Gravity compensator",
            where=Where(),
            status="ambiguous",
            gain_mm=0.035,
            probability=0.62,
            parameters=(Parameter("relative", -0.118, 0.006, "", "charge against the model's"),),
            rivals=(
                Rival("joint_compliance", Where(joint="joint_2"), 0.25),
                Rival("link_bending", Where(link="link_2"), 0.12),
            ),
            separate_by="measure 12 poses with joint 2 between −140° and −100° with the heavy load",
            decide=(
                Decision(
                    "poses",
                    "14 more poses, chosen for it",
                    "workbench plan campaign.toml --tell "
                    "gravity_compensator,joint_compliance:joint=joint_2 --poses 14 --out follow-up",
                    14,
                    3.1,
                    44.0,
                ),
                Decision("other", "a target in the middle of the link", None, None, 3.1, None),
            ),
            sentence="The compensator pulls 11.8 % less than its charge says: gas has leaked.",
            equation="F = A (p (l / (l - (s - s_0)))^n - p_0)",
            evidence=sag,
        ),
        Finding(
            cause="backlash",
            title="Backlash",
            where=Where(joint="joint_5"),
            status="named",
            gain_mm=0.018,
            probability=0.97,
            parameters=(Parameter("half_width", 3.4e-5, 1.2e-6, "rad", "half of the play"),),
            sentence="Joint 5 rests on the side from which it came.",
            equation='Delta q = h op("sign") dot(q)',
            evidence=play,
        ),
    )


def _line(x: Array, curve: object) -> tuple[Array, Array]:
    line = np.linspace(x.min(), x.max(), 120)
    assert callable(curve)
    return line, curve(line)


def _geometry(random: np.random.Generator) -> tuple[Parameter, ...]:
    found = []
    for joint in range(1, 7):
        for name, unit, size, std in (("tx", "m", 5e-4, 2e-5), ("tz", "m", 3e-4, 2e-5),
                                      ("rx", "rad", 3e-4, 6e-6), ("rz", "rad", 4e-4, 8e-6)):  # fmt: skip
            value = float(random.normal(0, size))
            found.append(Parameter(f"joint_{joint}/{name}", value, std, unit))
    return tuple(found)

"""A thousand random programs per format, written and read back: equal to the digits that are printed."""

from __future__ import annotations

import numpy as np
import pytest
from program_paths import random_path, random_targets

from workbench.correction.programs import Format, Program, find_format, formats
from workbench.correction.programs.base import STANDSTILL
from workbench.robot import rotations

ALL = sorted(formats())
PERCENT = ("krl", "ls")  # say the share of a joint move in whole percent
NO_JOINT_TIMES = ("val3",)

# half a last digit of: tool speed [m/s], turning speed [rad/s], duration of a leg [s]
DIGITS = {
    "krl": (5e-9, np.radians(5e-9), 0.0),
    "rapid": (5e-10, 0.0, 5e-7),
    "val3": (5e-10, np.radians(5e-7), 0.0),
    "urscript": (5e-10, 0.0, 5e-8),
    "ls": (0.0, 0.0, 5e-4),
    "csv": (0.0, 0.0, 1e-9),
}


def leg_tolerance(format: Format, program: Program) -> np.ndarray:
    """(N,) how far a leg's time may be off by the digits of its speed."""
    speed, turn, time = DIGITS[format.name]
    legs = format.legs(program)
    duration = np.nan_to_num(program.leg_times)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_speed = np.where(legs.distance >= STANDSTILL, duration * speed / legs.speed, 0.0)
        by_turn = np.where(legs.turning, duration * turn / legs.turn, 0.0)
    coarse = np.where(duration > 32, 0.05, time) if format.name == "ls" else time
    pauses = 5e-3 if format.name == "ls" else 5e-4  # a standing leg is a pause
    return np.asarray(
        np.nan_to_num(by_speed) + np.nan_to_num(by_turn) + coarse + pauses * (legs.pause > 0) + 1e-9
    )


def check_common(format: Format, program: Program, back: Program) -> None:
    assert back.count == program.count
    assert back.kind == program.kind
    if format.name == "csv":
        return
    least = 0.01 if format.name in PERCENT else 0.0
    tolerance = 0.005 if format.name in PERCENT else 1e-5
    timed = program.kind == "joints" and program.time is not None
    if not timed or format.name in PERCENT:  # legs with a time say no share
        assert back.share == pytest.approx(max(program.share, least), abs=tolerance + 1e-12)
    if format.carries_tool and program.kind == "poses":
        position, angle = format.rounding()
        for name in ("tool", "base"):
            wanted, given = getattr(program, name), getattr(back, name)
            assert np.abs(given - wanted)[:3, 3].max() <= position + 1e-12
            assert rotations.angle_between(given[None, :3, :3], wanted[None, :3, :3])[0] <= angle + 1e-12
    if program.load is not None and format.name in ("krl", "rapid", "urscript"):
        assert back.load is not None
        assert back.load.mass_kg == pytest.approx(program.load.mass_kg, abs=1e-9)
        assert back.load.com_mm == pytest.approx(program.load.com_mm, abs=1e-9)


def check_path(format: Format, program: Program) -> None:
    back = format.read(format.write(program))
    check_common(format, program, back)
    assert program.X is not None
    assert back.X is not None
    position, angle = format.rounding()
    far = 3.5 * (
        0.0 if program.in_world else 1.0
    )  # m: a point's distance from the base, whose turn is rounded
    pairs = [(program.X, back.X)]
    if program.via is not None:
        assert back.via is not None
        assert (program.circular == back.circular).all()
        pairs.append((program.via[program.circular], back.via[program.circular]))
    for wanted, given in pairs:
        room = (1 if program.in_world else 4) * position + far * angle
        assert np.abs(given[:, :3, 3] - wanted[:, :3, 3]).max() <= room + 1e-12
        assert rotations.angle_between(given[:, :3, :3], wanted[:, :3, :3]).max() <= 2 * angle + 1e-12
    assert back.rails == pytest.approx(program.rails, abs=5e-7 + 1e-12)
    assert back.time is not None, "the file does not say the time"
    assert program.time is not None
    # a standing leg is read as a pause at its start, so its own start counts with the pause
    arrival, known = back.time - back.time[0], program.time - program.time[0]
    tolerance = np.cumsum(leg_tolerance(format, program) + 1e-3 * (program.dwell > 0))
    moved = np.append(True, format.legs(program).distance[1:] + format.legs(program).angle[1:] >= STANDSTILL)
    assert (np.abs(arrival - known)[moved] <= tolerance[moved]).all()
    end, wanted = arrival[-1] + back.dwell[-1], known[-1] + program.dwell[-1]
    assert abs(end - wanted) <= tolerance[-1] + 1e-3
    if format.name not in ("csv", "ls"):
        assert back.blend == pytest.approx(format.legs(program).blend.max(), abs=5e-7 + 1e-12)


def check_targets(format: Format, program: Program) -> None:
    back = format.read(format.write(program))
    check_common(format, program, back)
    slide, turn = format.joint_rounding()
    assert np.abs(back.rails - program.rails).max(initial=0.0) <= slide + 1e-12
    assert np.abs(back.arm - program.arm).max() <= turn + 1e-12
    assert back.dwell == pytest.approx(program.dwell, abs=5e-4 + 1e-12)
    if program.time is not None and program.count > 1 and format.name not in NO_JOINT_TIMES:
        assert back.time is not None, "the file does not say the time"
        each = 5e-4 if format.name == "ls" else 1e-5
        assert back.leg_times[1:] == pytest.approx(program.leg_times[1:], abs=each)


def check(name: str, seeds: range) -> list[str]:
    format, lost = find_format(name), []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        joints = seed % 4 == 3
        program = (random_targets if joints else random_path)(rng, format)
        if format.check(program):
            continue
        try:
            (check_targets if joints else check_path)(format, program)
        except AssertionError as error:
            lost.append(f"seed {seed}: {error}")
    return lost


@pytest.mark.parametrize("name", ALL)
def test_a_hundred_programs_come_back(name: str) -> None:
    assert check(name, range(100)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_a_thousand_programs_come_back(name: str) -> None:
    assert check(name, range(100, 1100)) == []


@pytest.mark.parametrize("name", ALL)
def test_most_random_programs_are_ones_that_the_controller_takes(name: str) -> None:
    format = find_format(name)
    refused = 0
    for seed in range(100):
        rng = np.random.default_rng(seed)
        refused += bool(format.check((random_targets if seed % 4 == 3 else random_path)(rng, format)))
    assert refused < 20

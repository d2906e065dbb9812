"""Numbers as an engineer writes them: few digits, a fitting unit, no 1e-05."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..effects import called
from ..effects.place import Parameter

MISSING = "–"
FARTHEST = 100.0  # mm: no robot errs by more
NOT_KNOWN = "not known"
PREFIXES = ((1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"), (1e9, "G"))
SCALABLE = ("rad", "m", "N", "Nm", "Pa", "s")
# A pure number is a share of one, in per cent, or below this in ppm; these parameters are something else.
SMALL_SHARE = 2e-4
PURE_NUMBERS = ("weight",)
ANGLE_RATIOS = ("coupling",)  # turn of one joint per turn of another
SMALL_ANGLE_RATIO = 5e-3
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
ARCSEC = math.radians(1 / 3600)


@dataclass(frozen=True)
class Scale:
    """What to multiply an SI number by, and the unit it is then in."""

    factor: float
    unit: str


@dataclass(frozen=True)
class Quantity:
    """A parameter ready to print: value, 95 % interval (or empty), unit, and the same in words."""

    value: str
    low: str
    high: str
    unit: str
    also: str = ""

    @property
    def interval(self) -> str:
        return join(f"{self.low} … {self.high}", self.unit) if self.low else ""

    def __str__(self) -> str:
        return join(self.value, self.unit)


def join(value: str, unit: str) -> str:
    """Number and unit, with the space that the unit wants (none before ° and ·10⁻⁹)."""
    return value + unit if unit.startswith(("°", "·")) else f"{value} {unit}".rstrip()


def decimals(value: float, places: int) -> str:
    """Fixed number of decimals, with a real minus sign; MISSING when not finite."""
    if not math.isfinite(value):
        return MISSING
    text = f"{value:,.{max(places, 0)}f}".replace(",", "\u202f")
    if not any(digit in text for digit in "123456789"):
        text = text.lstrip("-")
    return text.replace("-", "−")


def significant(value: float, digits: int = 3) -> str:
    """`digits` significant digits, without exponent for what people read without one."""
    if not math.isfinite(value):
        return MISSING
    if value == 0:
        return "0"
    power = math.floor(math.log10(abs(value)) + 1e-12)
    if -5 < power < 7:
        return decimals(value, digits - 1 - power)
    return f"{decimals(value / 10.0**power, digits - 1)}·10{str(power).translate(SUPERSCRIPTS)}"


def bound(value: float) -> str:
    """A bound [mm], from a centimetre in whole ones; `NOT_KNOWN` beyond `FARTHEST`."""
    if value >= FARTHEST:
        return NOT_KNOWN
    return mm(value) if value < 10 else f"{value:.0f}"


def mm(value: float) -> str:
    """A length in mm without its unit: micrometres below a millimetre, 0.01 mm above."""
    if not math.isfinite(value):
        return MISSING
    if value != 0 and abs(value) < 0.001:
        return decimals(value, 4) if abs(value) >= 0.0001 else "< 0.0001"
    return decimals(value, 3 if abs(value) < 1 else 2 if abs(value) < 100 else 1)


def mm_change(before: float, after: float) -> str:
    """What becomes of a length in mm, as a verb: as far as the printed digits show it.

    >>> mm_change(1.2, 0.031), mm_change(0.0284, 0.0281)
    ('falls from 1.20 to 0.031 mm', 'stays at 0.028 mm')
    """
    return change(mm(before), mm(after), "mm", falls=after < before)


def change(first: str, last: str, unit: str, *, falls: bool) -> str:
    """What becomes of a number, as a verb, from how it is printed before and after."""
    if first == last:
        return f"stays at {join(last, unit)}"
    return f"{'falls' if falls else 'rises'} from {first} to {join(last, unit)}"


def percent(value: float, places: int = 1) -> str:
    """A share as `−22.0 %`."""
    return f"{decimals(100 * value, places)} %" if math.isfinite(value) else MISSING


def probability(value: float) -> str:
    """A probability as `98 %`, with a decimal at the ends alone: `99.4 %`, `0.3 %`; nothing that was computed
    is certain: `> 99.9 %`, `< 0.1 %`."""
    if value > 0.999:
        return "> 99.9 %"
    return "< 0.1 %" if value < 0.001 else percent(value, 0 if 0.01 <= value < 0.99 else 1)


def p_value(value: float) -> str:
    """`p = 0.26`, or a bound where nobody cares about more: `p < 10⁻¹²`."""
    if not math.isfinite(value):
        return f"p {MISSING}"
    if value < 1e-12:
        return "p < 10⁻¹²"
    if value < 1e-3:
        return f"p ≈ 10{str(round(math.log10(value))).translate(SUPERSCRIPTS)}"
    return f"p = {decimals(value, 3 if value < 0.1 else 2)}"


def scale(size: float, unit: str, name: str = "") -> Scale:
    """A display unit in which `size` (SI) is a number between about 1 and 1000."""
    size = abs(size) if math.isfinite(size) and size != 0 else 1e-3
    if name == "phase" or (unit == "rad" and size >= 0.2):
        return Scale(math.degrees(1), "°")
    if unit in ("", "1"):
        return _ratio(size, name)
    if unit in ("1/K", "1/degC", "1/°C"):
        return Scale(1e6, "µm/(m·K)") if size < 2e-4 else Scale(100.0, "%/K")
    head, rest = _first(unit)
    if head == "1":
        power = 3 * math.floor(math.log10(size) / 3)
        return Scale(10.0**-power, f"·10{str(power).translate(SUPERSCRIPTS)}{rest}" if power else unit)
    if head not in SCALABLE:
        return Scale(1.0, unit)
    if head == "m" and not rest:
        return Scale(1e6, "µm") if size < 1e-4 else Scale(1e3, "mm") if size < 2 else Scale(1.0, "m")
    if head == "rad" and not rest:
        return Scale(1e6, "µrad") if size < 5e-3 else Scale(1e3, "mrad")
    fitting = [prefix for prefix in PREFIXES if prefix[0] <= size * 1.0001] or [PREFIXES[0]]
    factor, letter = fitting[-1]
    return Scale(1 / factor, f"{letter}{unit}")


def _ratio(size: float, name: str) -> Scale:
    if name in PURE_NUMBERS or size >= 5:
        return Scale(1.0, "")
    if name in ANGLE_RATIOS and size < SMALL_ANGLE_RATIO:
        return Scale(1e6, "µrad/rad")
    return Scale(1e6, "ppm") if size < SMALL_SHARE else Scale(100.0, "%")


def _first(unit: str) -> tuple[str, str]:
    """The unit's first symbol and the rest: `N·m/rad` gives `N` and `·m/rad`."""
    for at, letter in enumerate(unit):
        if letter in "·*/ ^²³(":
            return unit[:at], unit[at:]
    return unit, ""


def axis_scale(values: Sequence[float], unit: str) -> Scale:
    """The display unit of an axis that shows `values`."""
    finite = [abs(float(value)) for value in values if math.isfinite(value)]
    top = max(finite, default=1.0)
    if unit == "rad" and top >= 0.05:
        return Scale(math.degrees(1), "deg")
    return Scale(1.0, "") if unit in ("", "1") else scale(top, unit)


def quantity(parameter: Parameter) -> Quantity:
    """The parameter with its 95 % interval, rounded to what the interval's width tells."""
    value, std, unit = parameter.value, parameter.std, parameter.unit
    known = math.isfinite(std) and std > 0
    chosen = scale(max(abs(value), std) if known else value, unit, parameter.name)
    shown = value * chosen.factor
    also = ""
    if unit == "rad" and chosen.unit == "µrad":
        also = f"{significant(value / ARCSEC, 3)} arcsec"
    if not known:
        return Quantity(significant(shown), "", "", chosen.unit, also)
    places = _places(1.96 * std * chosen.factor)
    if 0.5 <= abs(shown) * 10.0**places < 1.0:  # it would be rounded up to what it is not
        places += 1
    low, high = (_rounded(end * chosen.factor, places) for end in parameter.interval)
    return Quantity(_rounded(shown, places), low, high, chosen.unit, also)


def _rounded(value: float, places: int) -> str:
    """Decimals, or with negative places tens and hundreds, rounded as well."""
    return decimals(round(value, places), places)


def _places(half: float) -> int:
    """Decimals worth printing beside an interval of this half width: two digits of 0.1-0.35, else one."""
    power = math.floor(math.log10(half))
    return (1 if half / 10.0**power < 3.55 else 0) - power


def size(value: float, unit: str, name: str = "") -> str:
    """A size alone, two digits: `6.0 µrad`, `0.4 mm`, `1.2 %`."""
    if not math.isfinite(value):
        return MISSING
    chosen = scale(value, unit, name)
    return join(significant(float(f"{value * chosen.factor:.2g}"), 2), chosen.unit)


def words(identifier: str) -> str:
    """`half_width` as people write it: `half width`; a cause as it is called."""
    return called(identifier)

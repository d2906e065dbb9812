"""What a diagnosis is judged by, in words, and its tables.

In set: one of a fault's names is said, or stands among the rivals of a cause that is said; first: it is said.
A fair twin is a label whose form fits the fault as well on most campaigns: a compliance where there is play,
a map of a joint for an eccentricity, an eccentricity or a line in the gear for a map of the joint, a hose for
a gear ratio, a ratio for a hose. It counts beside the names where a figure says so, and is never wrong.

A cause is wrong where it is neither a name nor a fair twin of any fault of the case, nor a part of a fault
that has a name of its own (the sines of an eccentricity as lines in the gear), nor an effect of the
background with a λ of 4 or more: that one is there too, and may be found. Nothing else: no cause that is said
is wrong, but for those with a rival that is not. Wrong name: a wrong cause has the status "named".
"""

from collections import Counter
from collections.abc import Iterable
from typing import Any

Json = dict[str, Any]
BANDS = ((20, "<20"), (40, "20-40"), (200, "40-200"), (float("inf"), ">200"))  # of λ
PROBABILITIES = (0.0, 0.2, 0.5, 0.8, 0.95, 1.0)
BACKGROUND = 4.0  # λ from which a background effect may be found
UNKNOWN = "unknown"
KEPT = ("cause", "joint", "other", "link", "payload", "order", "status", "probability")
EVERYWHERE = ("gravity_compensator", "foundation", "drift", "thermal_growth")


def _said(cause: Json) -> Json:
    """A cause or a rival, as far as it is judged."""
    return {key: cause[key] for key in KEPT if cause.get(key) not in (None, "")}


def judged(found: Json) -> Json:
    """What is judged of a diagnosis, of its JSON."""
    causes = [
        _said(cause) | {"rivals": [_said(rival) for rival in cause["rivals"]]} for cause in found["causes"]
    ]
    faults = sorted({fault["kind"] for fault in found["faults"]})
    return {"verdict": found["verdict"], "headline": found["headline"], "causes": causes, "faults": faults}


def band(strength: float) -> str:
    return next(name for upper, name in BANDS if strength < upper)


def says(cause: Json, label: list[Any]) -> bool:
    """Whether a cause is that of a label; a line in a gear: within 2 % of its order, or 1.6."""
    kind, *where = label
    if cause["cause"] != kind:
        return False
    if kind in EVERYWHERE:
        return True
    if kind in ("link_bending", "link_mass"):
        return cause.get("link") == where[0]
    if kind == "payload":
        return cause.get("payload") == where[0]
    if kind == "wrist_coupling":
        return [cause.get("joint"), cause.get("other")] == where
    if cause.get("joint") != where[0]:
        return False
    if kind == "gear_kinematic_error" and len(where) > 1:
        return abs(cause.get("order", 0) - where[1]) < max(1.6, 0.02 * where[1])
    return True


def says_any(cause: Json, labels: Iterable[list[Any]]) -> bool:
    return any(says(cause, label) for label in labels)


def is_there(cause: Json, case: Json) -> bool:
    """Whether it is no wrong one."""
    if any(says_any(cause, fault["names"] + fault["twins"] + fault["parts"]) for fault in case["faults"]):
        return True
    return any(says(cause, one["label"]) for one in case["background"] if one["lambda"] >= BACKGROUND)


def causes(case: Json) -> list[Json]:
    return [cause for cause in case["found"]["causes"] if cause["cause"] != UNKNOWN]


def said_unknown(case: Json) -> bool:
    """Of a tool that slips it is right as well that it moved."""
    slipped = any(fault["kind"] == "slip" for fault in case["faults"])
    moved = "changed_setup" in case["found"].get("faults", [])
    return len(causes(case)) < len(case["found"]["causes"]) or (slipped and moved)


def named_wrongly(case: Json) -> bool:
    return any(cause["status"] == "named" and not is_there(cause, case) for cause in causes(case))


def said_wrongly(case: Json) -> bool:
    """Not "nothing else"."""
    return any(
        not is_there(cause, case) and not any(is_there(rival, case) for rival in cause["rivals"])
        for cause in causes(case)
    )


def _whole(table: dict[str, Counter]) -> Json:
    return {
        name: {key: int(count) for key, count in counts.items()} or {"n": 0} for name, counts in table.items()
    }


def by_fault(cases: list[Json]) -> Json:
    """Per band of λ how many of its faults were found, and how often the case's other causes were wrong."""
    table = {name: Counter() for _, name in BANDS}
    for case in cases:
        said = causes(case)
        rivals = [rival for cause in said for rival in cause["rivals"]]
        for fault in case["faults"]:
            in_set = any(says_any(cause, fault["names"]) for cause in said + rivals)
            twin = any(says_any(cause, fault["twins"]) for cause in said + rivals)
            table[band(fault["lambda"])].update(
                n=1,
                in_set=in_set,
                in_set_or_twin=in_set or twin,
                first=any(says_any(cause, fault["names"]) for cause in said),
                nothing_else=not said_wrongly(case),
                wrong_name=named_wrongly(case),
            )
    return _whole(table)


def of_unknown(cases: list[Json]) -> Json:
    """Of causes that have no name, per band of λ; `any_cause`: said, named or not, that is wrong."""
    table = {name: Counter() for _, name in BANDS}
    for case in cases:
        table[band(case["faults"][0]["lambda"])].update(
            n=1, said_unknown=said_unknown(case), named=named_wrongly(case), any_cause=said_wrongly(case)
        )
    return _whole(table)


def of_clean(cases: list[Json]) -> Json:
    return {
        "n": len(cases),
        "named": sum(named_wrongly(case) for case in cases),
        "any_cause": sum(bool(causes(case)) for case in cases),
        "verdicts": dict(Counter(case["found"]["verdict"] for case in cases).most_common()),
    }


def of_probabilities(cases: list[Json]) -> list[Json]:
    """Of all causes and rivals with a stated probability: how many are a fault's name, or there at all."""
    bins = [Counter() for _ in PROBABILITIES[1:]]
    for case in cases:
        names = [name for fault in case["faults"] for name in fault["names"]]
        for cause in (one for said in causes(case) for one in (said, *said["rivals"])):
            stated = cause.get("probability")
            if stated is None or cause["cause"] == UNKNOWN:
                continue
            number = max(k for k, lower in enumerate(PROBABILITIES[:-1]) if stated >= lower)
            true = says_any(cause, names)
            there = true or is_there(cause, case)
            bins[number].update(n=1, stated=stated, true=true, true_or_there=there)
    return [
        {
            "stated": [lower, upper],
            "mean": round(counts["stated"] / counts["n"], 3) if counts["n"] else None,
            "n": counts["n"],
            "true": int(counts["true"]),
            "true_incl_twin_or_background": int(counts["true_or_there"]),
        }
        for lower, upper, counts in zip(PROBABILITIES, PROBABILITIES[1:], bins, strict=False)
    ]


def tables(cases: list[Json]) -> Json:
    """Of all cases that were diagnosed."""
    of = {
        sort: [case for case in cases if case["sort"] == sort]
        for sort in ("single", "double", "unknown", "clean")
    }
    return {
        "single": by_fault(of["single"]),
        "double": by_fault(of["double"]),
        "unknown": of_unknown(of["unknown"]),
        "clean": of_clean(of["clean"]),
        "probability": of_probabilities(cases),
    }


def print_tables(found: Json) -> None:
    for sort in ("single", "double", "unknown"):
        for name, counts in found[sort].items():
            figures = "  ".join(f"{key} {count}" for key, count in counts.items())
            print(f"{sort:8} λ {name:7} {figures}")
    print("clean   ", found["clean"])
    for row in found["probability"]:
        print("probability", *(f"{key} {value}" for key, value in row.items()), sep="  ")

"""Which room of `workbench` uses which, from the imports: `python docs/rooms.py` draws docs/rooms.svg.

Rooms stand as in `ORDER`, bottom to top. An import of the package's face (`from workbench import ...`) is no
arrow: the face names what all rooms offer.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from functools import cache
from html import escape
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "workbench"
PICTURE = Path(__file__).resolve().parent / "rooms.svg"

ORDER = {
    "files": "tables, faults, whole-or-not-at-all writing",
    "robot": "description, kinematics, loads, Drake plants",
    "campaign": "what was told and what was seen",
    "effects": "one file per cause, and the one place where they act",
    "correction": "paths, inverse kinematics, controllers' programs",
    "identification": "model, fit, noise, model file",
    "diagnosis": "prepared → candidates → evidence → findings",
    "report": "page, PDF, scene and figures of a result",
    "simulation": "virtual campaigns, closed loop, export",
    "measurement": "the next poses; protocols for one purpose",
    "studies": "one folder per study; demo, blind",
    "cli": "arguments, files in and out",
}

ROW, LEFT, WIDTH, LANE, TOP = 44, 16, 430, 34, 54  # px


@cache
def modules() -> dict[str, tuple[Path, ast.Module]]:
    """Dotted name → file and syntax tree, of every module of the package."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        found[".".join(parts).removesuffix(".__init__")] = path, ast.parse(path.read_text(encoding="utf-8"))
    return found


def imports(nodes: list[ast.AST], package: list[str], known: set[str]) -> Iterator[str]:
    """Modules of the workbench that these nodes import; `package`: the parts of their own package."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            for alias in node.names:
                whole = f"{module}.{alias.name}"
                if whole in known or module in known:
                    yield whole if whole in known else module


@cache
def uses() -> dict[str, set[str]]:
    """Module → the modules it imports, in a function and for types too."""
    everything = modules()
    found = {}
    for name, (path, tree) in everything.items():
        package = name.split(".") if path.name == "__init__.py" else name.split(".")[:-1]
        found[name] = set(imports(list(ast.walk(tree)), package, set(everything))) - {name}
    return found


def arrows() -> Counter[tuple[str, str]]:
    """(room, room it uses) → number of imports between modules of the two."""
    pairs: Counter[tuple[str, str]] = Counter()
    for name, used in uses().items():
        for other in used:
            rooms = [module.partition(".")[2].partition(".")[0] for module in (name, other)]
            if all(room in ORDER for room in rooms) and rooms[0] != rooms[1]:
                pairs[rooms[0], rooms[1]] += 1
    return pairs


def picture() -> str:
    """The drawing: a bar per room, and beside it a lane per room that is used, with a dot at each user."""
    names, pairs = list(ORDER), arrows()
    y = {name: TOP + ROW * (len(names) - 1 - i) + ROW // 2 for i, name in enumerate(names)}
    used = [name for name in reversed(names) if any(pair[1] == name for pair in pairs)]
    x = {name: LEFT + WIDTH + 30 + LANE * i for i, name in enumerate(used)}
    width, height = LEFT + WIDTH + 30 + LANE * len(used), TOP + ROW * len(names) + 34
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
        f'height="{height}" font-family="Helvetica, Arial, sans-serif" font-size="13" fill="#1f2933">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
        bar(10, 32, "workbench", "the public face: names of all rooms, imported at first use", "#ffffff"),
    ]
    for name, what in ORDER.items():
        out.append(bar(y[name] - 16, 32, name, what, "#eef3f8"))
    for name in used:
        users = [user for user in names if (user, name) in pairs]
        top = min(y[user] for user in users)
        line = f"M{x[name]} {top}V{y[name]}H{LEFT + WIDTH + 9}"
        out.append(f'<path d="{line}" fill="none" stroke="#7b8794" stroke-width="1.3"/>')
        tip = f"M{LEFT + WIDTH + 2} {y[name]}l9 -4v8z"
        out.append(f'<path d="{tip}" fill="#7b8794"/>')
        for user in users:
            count = pairs[user, name]
            radius = 4 if count < 10 else 6 if count < 25 else 8
            out.append(f'<circle cx="{x[name]}" cy="{y[user]}" r="{radius}" fill="#2563a8"/>')
    said = "A dot: the room of its row uses the room that its line leads down to; large: often."
    out.append(f'<text x="{LEFT}" y="{height - 12}" fill="#616e7c" font-size="12">{escape(said)}</text>')
    return "\n".join([*out, "</svg>", ""])


def bar(top: int, high: int, name: str, what: str, fill: str) -> str:
    middle = top + high // 2 + 5
    return (
        f'<rect x="{LEFT}" y="{top}" width="{WIDTH}" height="{high}" rx="4" fill="{fill}" stroke="#9aa5b1"/>'
        f'<text x="{LEFT + 12}" y="{middle}" font-weight="bold">{name}</text>'
        f'<text x="{LEFT + 122}" y="{middle}" font-size="12">{escape(what)}</text>'
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")

"""The rooms of the package: few, in one order, and data flows one way through them."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

from workbench.studies import PUBLISHED

DOCS = Path(__file__).resolve().parents[1] / "docs"
sys.path.insert(0, str(DOCS))
rooms = importlib.import_module("rooms")


def test_at_most_twelve_rooms_and_no_loose_modules():
    folders = {path.parent.name for path in rooms.PACKAGE.glob("*/__init__.py")}
    assert folders == set(rooms.ORDER)
    assert len(folders) <= 12
    assert {path.stem for path in rooms.PACKAGE.glob("*.py")} == {"__init__", "__main__"}


def test_nothing_imports_upwards():
    order = list(rooms.ORDER)
    assert [pair for pair in rooms.arrows() if order.index(pair[0]) < order.index(pair[1])] == []


def test_no_room_but_cli_and_studies_asks_the_face():
    users = {name for name, used in rooms.uses().items() if "workbench" in used}
    assert {name.split(".")[1] for name in users} <= {"cli", "studies", "__main__"}


@pytest.mark.parametrize("study", [*PUBLISHED, "demo"])
def test_studies_use_only_the_public_face(study):
    """And their own chapters: what a reader copies to begin a study of their own."""
    own = f"workbench.studies.{study}"
    for name, used in rooms.uses().items():
        if name == own or name.startswith(f"{own}."):
            assert all(other == "workbench" or other.startswith(own) for other in used), (name, used)


def test_no_module_imports_itself_in_a_circle():
    """Nor in a function, nor for types alone; the face apart. Take away what needs nothing that is left."""
    left = {name: used - {"workbench"} for name, used in rooms.uses().items() if name != "workbench"}
    while free := [name for name, used in left.items() if not used & left.keys()]:
        left = {name: used for name, used in left.items() if name not in free}
    assert left == {}


def test_the_picture_is_up_to_date_and_has_few_boxes():
    drawn = rooms.PICTURE.read_text(encoding="utf-8")
    assert drawn == rooms.picture(), "run `python docs/rooms.py`"
    assert drawn.count("<rect x=") <= 20

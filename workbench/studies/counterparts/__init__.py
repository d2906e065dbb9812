"""The question of each study put to robots that were measured: a UR10, a UR5 and an iiwa 7.

The measurements are not part of the workbench: a study is given a folder of campaigns, which it reads in
place, or it says that none was.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ...report.study import Table
from ..study_run import StudyRun
from .gains import gain_of_cells
from .gear import sag_or_gear
from .measured import CAMPAIGNS, Measured, load
from .sag import geometry_or_sag
from .stiffness import compliance_by_angle, stiffness_twice
from .words import TITLE

ASKED: Mapping[str, Callable[[Sequence[Measured]], Table]] = {
    "cylindrical": stiffness_twice,
    "kr500": gain_of_cells,
    "kr120": compliance_by_angle,
    "rx170": sag_or_gear,
    "longlink": geometry_or_sag,
}


def counterpart(name: str, run: StudyRun) -> Table:
    """The table of a study by its name; where no measurements are given, how to give them. Raises
    `InputError` where the folder that is given holds none of them."""
    if run.measured is None:
        names = ", ".join(known.name for known in CAMPAIGNS)
        row = ["not asked", f"--measured DIR asks it, of a folder with the campaigns {names}"]
        return Table(TITLE, ("Robots", ""), [row], "The measurements are not part of the workbench.", ())
    run.say("asking measured robots")
    robots, missing = load(run.measured)
    table = ASKED[name](robots)
    said = f"{table.note} Not in the folder: {', '.join(missing)}." if missing else table.note
    return replace(table, note=said)

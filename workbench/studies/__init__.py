"""Studies: the demo, the published ones, and the blind one that measures our own error rates.

A published study tells a paper again and asks what its numbers support. It is one folder:

    study.py     `study(run)`, the story in order: measure, fit, compare, question; it ends in `tell`
    story.md     its words; numbers, tables and figures come by name from the script
    printed.py   what the paper prints, each value with its unit and its place there; nowhere else
    *.py         chapters: what a step of the story takes beyond a screen

To begin one of your own, copy a folder to any place and change it:

1. `cp -r workbench/studies/cylindrical mine && python mine/study.py --quick`: page, PDF, scene and numbers
   are in `reports/mine/`.
2. In `printed.py` put what your paper prints. Each value has a line below it: [unit], and where it stands.
   `NUMBERS` has the printed numbers by the names that the story calls them by.
3. In `study.py` put your robot (a name that `workbench robots` lists, or the path of its TOML), the
   measurement (a plan that `simulate` measures in Drake, or `load_campaign` of your own files), the fit and
   the question. Everything comes from `from workbench import ...`; `tell` gets numbers, tables and figures.
4. In `story.md` put your words. A name that is not there, or a table that is not used, is refused.

What such a page says it has to earn:

- `judge(accounts, items, draws, run)` holds several accounts of how the print came to be, the authors' own
  among them, against all that is printed; `account_items(judged)` shows it.
- `calibrated(judged, items)` gives odds that are as right as they say, for few draws of many numbers: worlds
  drawn from the accounts are judged as the print is (`calibrated_table`, `stated_table`).
- `draw_many(work, priors, draws, run)` draws the headline over seeds and over what had to be assumed;
  `tornado` shows which assumption carries it, `.by_name()` gives a story medians and 5 to 95 %.
- `redrawn(judged, numbers)` gives what hangs on the odds over fifty runs more, for claims about them.
- `checked(claims, numbers, draws)` says how often each sentence holds; `tell(..., claims=...)` has the story
  say `[if NAME] this [else] that [end]`: a claim stands that holds in the run and in nine of ten draws.

`run` (`StudyRun`) has folder, seed, quick, workers and resume; `run.draws(full, quick)` says how many draws.
What a script writes into `run.folder` appears with the page in the end, all of it or nothing.
All run through `tasks.run_tasks`: what they call has to be a function of a module, or a `partial` of one.

The chapters are imported from the folder they lie in (`from .printed import ...`), as in any package. Run as
a script, `study.py` belongs to no package; the two lines with `as_package` make its folder one.
"""

import re
import sys
from pathlib import Path
from types import ModuleType

PUBLISHED = {  # and what each is about, for --help
    "cylindrical": "stiffness of a robot with one turning and two sliding joints",
    "kr500": "stiffness by cells of the workspace",
    "kr120": "stiffness of an arm with a gas spring",
    "rx170": "joint errors of a spiral, corrected offline",
    "longlink": "calibration of seven joints on long links",
}


def as_package(script: str) -> str:
    """Makes the folder of a script a package, so that `from .chapter import ...` works in it; its name.

    script: the `__file__` of the script. The package is named after the folder; `sys.path` stays as it is.
    """
    folder = Path(script).resolve().parent
    package = ModuleType("study_" + re.sub(r"\W", "_", folder.name))
    package.__path__ = [str(folder)]
    return sys.modules.setdefault(package.__name__, package).__name__

"""One case of the blind study by its key: `python -m workbench.studies.blind.one gear_ratio/3 [--seed 0]`."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from ...campaign import write_campaign
from .cases import draw_case
from .score import run_case


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m workbench.studies.blind.one", description=__doc__)
    parser.add_argument("keys", nargs="+", metavar="KEY", help="like gear_ratio/3, pair/0, clean-stated/2")
    parser.add_argument("--seed", type=int, default=0, help="of the study")
    parser.add_argument("--campaign", type=Path, help="write the campaign into this folder instead")
    arguments = parser.parse_args()
    for key in arguments.keys:
        if arguments.campaign is None:
            print(json.dumps(run_case(key, arguments.seed), indent=1, ensure_ascii=False))
            continue
        folder = arguments.campaign / key.replace("/", "-")
        with TemporaryDirectory() as robots:
            case = draw_case(key, arguments.seed, Path(robots))
            said = [
                f"hidden: {item.label}, size {s:g}" for item, s in zip(case.hidden, case.sizes, strict=True)
            ]
            print(write_campaign(folder, case.campaign, comments=said))
    return 0


if __name__ == "__main__":
    sys.exit(main())

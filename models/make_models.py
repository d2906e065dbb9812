"""Makes every robot under this folder again: `python models/make_models.py [NAME ...]`."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from generator.files import write  # noqa: E402
from generator.robots.kr500 import KR500  # noqa: E402
from generator.robots.ur5 import UR5  # noqa: E402

DESIGNS = (KR500, UR5)


def main(names: list[str], folder: Path = HERE) -> None:
    for design in DESIGNS:
        if not names or design.name in names:
            files = write(design, folder)
            print(f"{design.name}: {sum(path.stat().st_size for path in files) / 1000:.0f} kB")


if __name__ == "__main__":
    main(sys.argv[1:])

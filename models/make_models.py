"""Makes every robot under this folder again: `python models/make_models.py [NAME ...]`."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from generator.files import write  # noqa: E402
from generator.robots.cylindrical import CYLINDRICAL  # noqa: E402
from generator.robots.iiwa7 import IIWA7  # noqa: E402
from generator.robots.irb120 import IRB120  # noqa: E402
from generator.robots.kr120 import KR120  # noqa: E402
from generator.robots.kr500 import KR500  # noqa: E402
from generator.robots.longlink import LONGLINK  # noqa: E402
from generator.robots.lrmate200id import LRMATE200ID  # noqa: E402
from generator.robots.ma1400 import MA1400_LEFT, MA1400_RIGHT  # noqa: E402
from generator.robots.rx170 import RX170  # noqa: E402
from generator.robots.ur5 import UR5  # noqa: E402
from generator.robots.ur10 import UR10  # noqa: E402

DESIGNS = (
    *(KR500, UR5, UR10, IRB120, LRMATE200ID, IIWA7, MA1400_RIGHT, MA1400_LEFT, KR120, RX170),
    *(LONGLINK, CYLINDRICAL),
)


def main(names: list[str], folder: Path = HERE) -> None:
    for design in DESIGNS:
        if not names or design.name in names:
            files = write(design, folder)
            print(f"{design.name}: {sum(path.stat().st_size for path in files) / 1000:.0f} kB")


if __name__ == "__main__":
    main(sys.argv[1:])

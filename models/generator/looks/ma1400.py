"""The MA1400: a slim blue arm on a pedestal that leans out of a turntable."""

from __future__ import annotations

from collections.abc import Mapping

from ..design import Design
from ..mesh import Shape
from ..parts import Triad, in_link_frames
from .arms import Sizes, places
from .heavy import heavy
from .paints import BLUE, DARK, GREY

LOOK = Sizes(
    paint=BLUE,
    foot=190,
    waist=150,
    turntable=190,
    block=150,
    hub=120,
    elbow=98,
    near=-78,
    far=-160,
    cheek=125,
    forearm=92,
    tube=66,
    tube_start=240,
    wrist=48,
    flange=42,
    motor=44,
)
STAND = 965.9  # mm along S from its meeting with the turntable's axis to the arm's foot


def ma1400_look(design: Design) -> Mapping[str, Shape]:
    shapes = dict(heavy(design, LOOK, STAND))
    p = places(design)
    foot = Triad((0, 0, STAND))
    post = [
        (-700, 0, 0, 150, 150, 6),
        (-40, 0, 0, 150, 150, 6),
    ]
    stand = [
        (GREY, foot.body(post, 12, axis="n", sides=20)),
        (DARK, foot.body([(-50, 0, 0, 205, 205, 8), (0, 0, 0, 205, 205, 8)], 6, axis="n", sides=20)),
    ]
    leaning = in_link_frames(design, {"base_link": stand}, p.X_BD)["base_link"]
    table = [
        (DARK, Triad().drum("n", (-20, 60), 480, 10, sides=36)),
        (GREY, Triad().drum("n", (60, 75), 440, 6, sides=36)),
    ]
    shapes["base_link"] = [*shapes["base_link"], *leaning, *table]
    return shapes

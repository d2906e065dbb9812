"""Colours, sRGB."""

from ..mesh import Paint

ORANGE = Paint((235, 88, 0))
YELLOW = Paint((226, 152, 10))
BLUE = Paint((0, 84, 159))
SKY = Paint((70, 132, 186))
TEAL = Paint((0, 118, 132))
WHITE = Paint((164, 166, 164))
SILVER = Paint((146, 151, 157), metallic=0.1, roughness=0.65)
GREY = Paint((98, 103, 109))
DARK = Paint((52, 55, 59))
BLACK = Paint((32, 33, 35), roughness=0.75)
STEEL = Paint((140, 145, 152), metallic=0.25, roughness=0.5)

"""The camera of the comparison of whole commands: straight down on the house, without perspective, y up, meters."""

WIDTH, HEIGHT = 1024, 768
PIXEL_M = 0.025
# The corners of the picture. Centers of pixels are whole multiples of a pixel, from 0.
LEFT, BOTTOM = -PIXEL_M / 2, -PIXEL_M / 2
RIGHT, TOP = LEFT + WIDTH * PIXEL_M, BOTTOM + HEIGHT * PIXEL_M
CENTER = (LEFT + RIGHT) / 2, (BOTTOM + TOP) / 2
# The camera's height, and the nearest and furthest distance that it sees.
EYE_M, NEAR_M, FAR_M = 30.0, 10.0, 40.0
# Of each point, where pictures are seen through.
OPACITY = 0.3

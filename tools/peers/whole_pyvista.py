"""A cloud from above with PyVista: whole_pyvista.py CLOUD PICTURE nearest|unsorted|peel4|peel100."""

import sys

import numpy as np
import pyvista as pv

from above import BOTTOM, CENTER, EYE_M, FAR_M, HEIGHT, NEAR_M, OPACITY, TOP, WIDTH

source, picture, mode = sys.argv[1:]
if source.endswith(".laz"):
    import laspy

    las = laspy.read(source)
    cloud = pv.PolyData(las.xyz.astype(np.float32))
    cloud["RGB"] = (np.stack([las.red, las.green, las.blue], 1) >> 8).astype(np.uint8)
else:
    cloud = pv.read(source)
plotter = pv.Plotter(off_screen=True, window_size=(WIDTH, HEIGHT))
plotter.background_color = "white"
opacity = 1.0 if mode == "nearest" else OPACITY
plotter.add_points(cloud, scalars="RGB", rgb=True, point_size=1, lighting=False, opacity=opacity)
if mode.startswith("peel"):
    plotter.enable_depth_peeling(int(mode.removeprefix("peel")))
plotter.disable_anti_aliasing()
plotter.enable_parallel_projection()
plotter.camera.position = (*CENTER, EYE_M)
plotter.camera.focal_point = (*CENTER, 0)
plotter.camera.up = (0, 1, 0)
plotter.camera.parallel_scale = (TOP - BOTTOM) / 2
plotter.camera.clipping_range = (NEAR_M, FAR_M)
plotter.screenshot(picture)

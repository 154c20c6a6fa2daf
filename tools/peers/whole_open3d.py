"""A cloud from above with Open3D: whole_open3d.py CLOUD PICTURE nearest|unlit|lit.

The last two take Open3D's transparent materials.
"""

import sys

import open3d as o3d
from open3d.visualization import rendering

from above import BOTTOM, CENTER, EYE_M, FAR_M, HEIGHT, LEFT, NEAR_M, OPACITY, RIGHT, TOP, WIDTH

source, picture, mode = sys.argv[1:]
if source.endswith(".laz"):
    import laspy
    import numpy as np

    las = laspy.read(source)
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(las.xyz))
    colors = np.stack([las.red, las.green, las.blue], 1) / 65535
    cloud.colors = o3d.utility.Vector3dVector(colors)
else:
    cloud = o3d.io.read_point_cloud(source)
material = rendering.MaterialRecord()
shaders = {"nearest": "defaultUnlit", "unlit": "defaultUnlitTransparency", "lit": "defaultLitTransparency"}
material.shader = shaders[mode]
material.base_color = (1, 1, 1, 1 if mode == "nearest" else OPACITY)
material.point_size = 1
renderer = rendering.OffscreenRenderer(WIDTH, HEIGHT)
scene = renderer.scene
scene.set_background((1, 1, 1, 1))
scene.view.set_post_processing(False)
scene.view.set_antialiasing(False)
scene.view.set_sample_count(1)
scene.add_geometry("cloud", cloud, material)
half_width, half_height = (RIGHT - LEFT) / 2, (TOP - BOTTOM) / 2
ortho = rendering.Camera.Projection.Ortho
scene.camera.look_at((*CENTER, 0), (*CENTER, EYE_M), (0, 1, 0))
scene.camera.set_projection(ortho, -half_width, half_width, -half_height, half_height, NEAR_M, FAR_M)
o3d.io.write_image(picture, renderer.render_to_image())

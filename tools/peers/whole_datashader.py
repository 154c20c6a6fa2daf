"""A cloud from above with laspy and datashader: whole_datashader.py CLOUD.laz PICTURE nearest|density|mean."""

import sys

import datashader as ds
import datashader.transfer_functions as tf
import laspy
import numpy as np
import pandas as pd
from PIL import Image

from above import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH

source, picture, mode = sys.argv[1:]
las = laspy.read(source)
points = pd.DataFrame({name: np.asarray(las[name]) for name in ("x", "y", "z")})
for name in ("red", "green", "blue"):
    points[name] = np.asarray(las[name]) >> 8
canvas = ds.Canvas(WIDTH, HEIGHT, x_range=(LEFT, RIGHT), y_range=(BOTTOM, TOP))
if mode == "density":
    image = tf.shade(canvas.points(points, "x", "y", ds.count()), cmap=["white", "black"], how="log")
    tf.set_background(image, "white").to_pil().convert("RGB").save(picture)
else:
    if mode == "mean":
        channels = ds.summary(**{name: ds.mean(name) for name in ("red", "green", "blue")})
    else:
        channels = ds.summary(**{name: ds.where(ds.max("z"), name) for name in ("red", "green", "blue")})
    image = canvas.points(points, "x", "y", channels)
    pixels = np.stack([image[name].to_numpy() for name in ("red", "green", "blue")], 2)
    pixels = np.where(np.isnan(pixels), 255, pixels)[::-1]
    Image.fromarray(np.rint(pixels).astype(np.uint8)).save(picture)

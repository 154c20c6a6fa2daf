"""The exact image in float64, and how far another one is from it.

All splats are sorted by depth and blended over the image one by one, in plain numpy: slow, but nothing in it can be
wrong in the way that a fast renderer is. Blending runs on the stored values, as in every tool that is compared.
"""

import numpy as np

from camera import project
from scenes import radius_px


def exact_image(scene, shape):
    """Frame 0 of a scene with splats of a `shape`, "square" or "disc".

    Returns the image (height, width, 3), 0 to 1, over black, and the number of splats over each pixel.
    """
    x, y, depth = project(scene.positions, scene.view, 0)
    # Far to near; numpy's stable sort gives equal depths in the order of the points.
    order = np.argsort(-depth, kind="stable")
    if scene.opaque:
        return nearest(scene, x[order], y[order], scene.colors[order])
    return blended(scene, x[order], y[order], scene.colors[order], shape)


def nearest(scene, x, y, colors):
    """Opaque pixels: the last one written is the nearest."""
    width, height = scene.view.width, scene.view.height_px
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    pixel = row[inside] * width + column[inside]
    image = np.zeros((height * width, 3))
    image[pixel] = colors[inside, :3] / 255.0
    counts = np.bincount(pixel, minlength=height * width)
    return image.reshape(height, width, 3), counts.reshape(height, width)


def blended(scene, x, y, colors, shape):
    """Splats far to near, each over what is there."""
    width, height = scene.view.width, scene.view.height_px
    reach = radius_px(scene.size_px) if shape == "disc" else scene.size_px / 2

    # A pixel is covered if its center is: the first and the one after the last.
    def bounds(center, size):
        low, high = np.ceil(center - reach - 0.5), np.ceil(center + reach - 0.5)
        return np.clip(low, 0, size).astype(int).tolist(), np.clip(high, 0, size).astype(int).tolist()

    (x_low, x_high), (y_low, y_high) = bounds(x, width), bounds(y, height)
    alpha, color = colors[:, 3] / 255.0, colors[:, :3] / 255.0
    column, row = np.arange(width) + 0.5, np.arange(height) + 0.5
    image, counts = np.zeros((height, width, 3)), np.zeros((height, width), int)
    for i in range(len(x)):
        rows, columns = slice(y_low[i], y_high[i]), slice(x_low[i], x_high[i])
        if shape == "disc":
            squared = ((column[columns] - x[i]) ** 2)[None] + ((row[rows] - y[i]) ** 2)[:, None]
            covered = squared <= reach**2
        else:
            covered = np.ones((y_high[i] - y_low[i], x_high[i] - x_low[i]), bool)
        weight = (covered * alpha[i])[..., None]
        part = image[rows, columns]
        part *= 1 - weight
        part += weight * color[i]
        counts[rows, columns] += covered
    return image, counts


def encode_srgb(linear):
    """Linear values to sRGB's, 0 to 1."""
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)


def error(image, exact):
    """The difference of an image (height, width, 3 or 4; uint8, or float 0 to 1) from the exact one.

    Over the pixels that either covers: `rmse` in units of 0 to 1, and the share of pixels with a channel that is off by
    more than 1/255.
    """
    image = image[..., :3] / 255.0 if image.dtype == np.uint8 else image[..., :3].astype(np.float64)
    covered = (exact.max(2) > 0) | (image.max(2) > 0)
    off = np.abs(image - exact)[covered]
    return {"rmse": float(np.sqrt((off**2).mean())), "above_1_255": float((off.max(1) > 1 / 255).mean())}

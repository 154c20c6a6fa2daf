"""The peer on the CPU: splats sorted by depth and blended far to near by compiled loops, float32, two threads.

What a person would write who needs the picture and has numpy and numba. Opaque points keep the nearest instead.
"""

import numba
import numpy as np

from camera import project
from scenes import radius_px
from worker import arguments, run

# Horizontal bands of the image, one thread each.
BANDS = 2


@numba.njit(parallel=True, fastmath=True, cache=True)
def blend(image, order, x, y, colors, radius):
    """Blends discs into an image (height, width, 3), in the given order; colors are premultiplied."""
    height, width = image.shape[0], image.shape[1]
    for band in numba.prange(BANDS):
        first, last = band * height // BANDS, (band + 1) * height // BANDS
        for place in range(order.size):
            i = order[place]
            top = max(int(np.ceil(y[i] - radius - 0.5)), first)
            bottom = min(int(np.ceil(y[i] + radius - 0.5)), last)
            keep = np.float32(1) - colors[i, 3]
            for v in range(top, bottom):
                dy = v + 0.5 - y[i]
                squared = radius * radius - dy * dy
                if squared < 0:
                    continue
                half = np.sqrt(squared)
                left = max(int(np.ceil(x[i] - half - 0.5)), 0)
                right = min(int(np.ceil(x[i] + half - 0.5)), width)
                for u in range(left, right):
                    image[v, u, 0] = image[v, u, 0] * keep + colors[i, 0]
                    image[v, u, 1] = image[v, u, 1] * keep + colors[i, 1]
                    image[v, u, 2] = image[v, u, 2] * keep + colors[i, 2]


@numba.njit(parallel=True, cache=True)
def nearest(image, x, y, depth, colors, depths):
    """The nearest point of each pixel."""
    height, width = image.shape[0], image.shape[1]
    for band in numba.prange(BANDS):
        first, last = band * height // BANDS, (band + 1) * height // BANDS
        depths[first:last] = np.float32(1e30)
        image[first:last] = 0
        for i in range(x.size):
            v, u = int(np.floor(y[i])), int(np.floor(x[i]))
            if first <= v < last and 0 <= u < width and depth[i] < depths[v, u]:
                depths[v, u] = depth[i]
                image[v, u] = colors[i, :3]


def main():
    """Draws one scene."""
    scene, options = arguments(["nearest", "sorted"])
    view, radius = scene.view, np.float32(radius_px(scene.size_px))
    colors = (scene.colors / 255.0).astype(np.float32)
    colors[:, :3] *= colors[:, 3:]
    image = np.zeros((view.height_px, view.width, 3), np.float32)
    depths = np.empty(image.shape[:2], np.float32)

    def draw(frame):
        projected = project(scene.positions, view, frame, np.float32)
        x, y, depth = (values.astype(np.float32) for values in projected)
        if scene.opaque:
            nearest(image, x, y, depth, colors, depths)
        else:
            order = np.argsort(-depth, kind="stable").astype(np.int32)
            image[:] = 0
            blend(image, order, x, y, colors, radius)
        return image

    run(draw, options, f"numba {numba.__version__}", lambda: f"{numba.config.NUMBA_NUM_THREADS} threads, float32")


if __name__ == "__main__":
    main()

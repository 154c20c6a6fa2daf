"""The scenes' cameras: a view, its orbit from frame to frame, and the projection in any precision."""

import math
from dataclasses import dataclass

import numpy as np

# Degrees around the vertical from one frame to the next: enough that nothing can be kept from the frame before.
STEP_DEG = 0.25
NEAR, FAR = 0.1, 20.0


@dataclass(frozen=True)
class View:
    """A camera. Either `fov_y` (degrees, perspective) or `height` (world units over the image's height) is given."""

    width: int
    height_px: int
    eye: tuple
    target: tuple
    fov_y: float | None = None
    height: float | None = None
    # The orbit turns around Z.
    up: tuple = (0.0, 0.0, 1.0)


def eye_at(view, frame):
    """The eye's position (3,) in a frame."""
    angle = math.radians(STEP_DEG * frame)
    target = np.array(view.target, float)
    x, y, z = np.array(view.eye, float) - target
    turned = [x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle), z]
    return target + np.array(turned)


def view_matrix(view, frame):
    """World to eye (4, 4); the camera looks along -Z."""
    eye, target = eye_at(view, frame), np.array(view.target, float)
    forward = target - eye
    forward /= np.linalg.norm(forward)
    side = np.cross(forward, np.array(view.up, float))
    side /= np.linalg.norm(side)
    matrix = np.eye(4)
    matrix[:3, :3] = side, np.cross(side, forward), -forward
    matrix[:3, 3] = -matrix[:3, :3] @ eye
    return matrix


def projection_matrix(view):
    """Eye to OpenGL's clip space (4, 4)."""
    aspect, matrix = view.width / view.height_px, np.zeros((4, 4))
    if view.height:
        half = view.height / 2
        matrix[0, 0], matrix[1, 1] = 1 / (half * aspect), 1 / half
        matrix[2, 2], matrix[2, 3] = -2 / (FAR - NEAR), -(FAR + NEAR) / (FAR - NEAR)
        matrix[3, 3] = 1
    else:
        focal = 1 / math.tan(math.radians(view.fov_y) / 2)
        matrix[0, 0], matrix[1, 1] = focal / aspect, focal
        matrix[2, 2], matrix[2, 3] = -(FAR + NEAR) / (FAR - NEAR), -2 * FAR * NEAR / (FAR - NEAR)
        matrix[3, 2] = -1
    return matrix


def project(positions, view, frame, dtype=np.float64):
    """Positions (n, 3) to x and y in pixels, y down, and the distance along the viewing axis; (n,) each."""
    to_eye, clip = view_matrix(view, frame), projection_matrix(view)
    eye = positions.astype(dtype) @ to_eye[:3, :3].T.astype(dtype) + to_eye[:3, 3].astype(dtype)
    depth = -eye[:, 2]
    w = np.ones_like(depth) if view.height else depth
    x = (eye[:, 0] * clip[0, 0] / w * 0.5 + 0.5) * view.width
    y = (0.5 - eye[:, 1] * clip[1, 1] / w * 0.5) * view.height_px
    return x, y, depth


def world_per_pixel(view, depth):
    """The world units that a pixel spans at each depth (n,)."""
    if view.height:
        return np.full(len(depth), view.height / view.height_px)
    return depth * 2 * math.tan(math.radians(view.fov_y) / 2) / view.height_px

"""Cameras."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from . import _arrays
from ._types import Path, Size

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from ._settings import Change

Vector = tuple[float, float, float]

# Pixels that the principal point may be off the middle of the image.
_OFF_CENTER_PX = 0.5
# How far focal lengths may differ, and matrices be off a rotation, relative to 1: digits that files leave out.
_RATIO = 1e-3
# Degrees that a turned camera keeps from the vertical.
_POLE = 1.0
# The sine of the angle between two directions below which they count as one.
_ALONG = 1e-9


@dataclass(frozen=True)
class Camera:
    """A camera in world units: the world is right-handed, and ``up`` points to the top of the image.

    A value of None is found automatically: ``up`` becomes the vertical of the clouds; without ``fov_y`` and ``height``, the angle
    is 45 degrees; ``near`` and ``far`` become depths that keep all points in front of the camera.
    """

    eye: Vector | None = None
    """Position of the camera, world units."""
    target: Vector | None = None
    """Point that the camera looks at, in the middle of the image, world units."""
    up: Vector | None = None
    """Direction that points to the top of the image, of any length."""
    fov_y: float | None = None
    """Full vertical angle in degrees, above 0 and below 180, of a perspective camera."""
    height: float | None = None
    """Height of the image in world units, above 0, of an orthographic camera."""
    near: float | None = None
    """Smallest depth at which points are visible, world units, above 0."""
    far: float | None = None
    """Largest depth at which points are visible, world units, above 0."""

    def __post_init__(self) -> None:
        for name in ("eye", "target", "up"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, _arrays.vector(name, value))
        for name, most in (("fov_y", 180.0), ("height", math.inf), ("near", math.inf), ("far", math.inf)):
            value = getattr(self, name)
            if value is None:
                continue
            number = _number(name, value)
            if not 0.0 < number < most:
                limit = f"above 0 and below {most:.0f}" if most < math.inf else "above 0 and finite"
                raise ValueError(f"{name}: expected a number {limit}, found {number}")
            object.__setattr__(self, name, number)
        if self.fov_y is not None and self.height is not None:
            raise ValueError("fov_y and height: expected one of them: a perspective camera has fov_y, an orthographic one height")
        if self.near is not None and self.far is not None and self.near >= self.far:
            raise ValueError(f"near and far: expected near below far, found {self.near} and {self.far}")
        if self.up is not None and not any(self.up):
            raise ValueError(f"up: expected a direction, found {self.up}, which has no length")
        if self.eye is not None and self.eye == self.target:
            raise ValueError(f"eye and target: expected two points, found {self.eye} twice")

    @classmethod
    def look_at(
        cls,
        eye: ArrayLike,
        target: ArrayLike,
        *,
        up: ArrayLike | None = None,
        fov_y: float = 45.0,
        near: float | None = None,
        far: float | None = None,
    ) -> Camera:
        """Return a perspective camera at ``eye`` that looks at ``target``; ``fov_y`` is the full vertical angle in degrees."""
        return cls(*_pose(eye, target, up), fov_y=fov_y, near=near, far=far)

    @classmethod
    def orthographic(
        cls,
        eye: ArrayLike,
        target: ArrayLike,
        height: float,
        *,
        up: ArrayLike | None = None,
        near: float | None = None,
        far: float | None = None,
    ) -> Camera:
        """Return an orthographic camera; ``height`` is the height of the image in world units."""
        return cls(*_pose(eye, target, up), height=height, near=near, far=far)

    @classmethod
    def from_picture(cls, path: Path) -> Camera:
        """Return the camera with which a picture was rendered, from the metadata of its PNG or EXR.

        Rendered through it, the same scene at the same size has the same pixels. Raises SceneError for a picture without a
        camera, and OSError for a file that is none.
        """
        from . import _pellucid

        return cls._of(_pellucid.picture_camera(os.fspath(path)))

    @classmethod
    def from_opencv(
        cls,
        K: ArrayLike,
        world_to_camera: ArrayLike | None = None,
        *,
        R: ArrayLike | None = None,
        t: ArrayLike | None = None,
        size: Size,
    ) -> Camera:
        """Return the camera of an OpenCV calibration: +x right, +y down, +z forward.

        Parameters
        ----------
        K
            Intrinsics, 3 × 3, in pixels, with the last row 0, 0, 1.
        world_to_camera
            Extrinsics, 3 × 4, or 4 × 4 with the last row 0, 0, 0, 1. In their place you can pass ``R`` (a rotation matrix, 3 × 3,
            not a vector of cv2.Rodrigues) and ``t`` (3): x_camera = R x_world + t.
        size
            Width and height of the calibrated images in pixels.

        Raises
        ------
        ValueError
            A matrix is transposed, or isn't a rotation. Or the calibration has pixels that aren't square, skew, or a principal
            point more than half a pixel off the middle of the image, which scenes don't have. Undistort and crop the images first
            (cv2.undistort, cv2.getOptimalNewCameraMatrix with centerPrincipalPoint=True).
        """
        import numpy as np

        intrinsics = _arrays.matrix("K", K, (3, 3))
        _check_last_row("K", intrinsics)
        if world_to_camera is not None:
            if R is not None or t is not None:
                raise TypeError("world_to_camera: R and t say the same; give either")
            extrinsics = _pose_matrix("world_to_camera", world_to_camera)
            rotation, moved = extrinsics[:3, :3], extrinsics[:3, 3]
        elif R is None or t is None:
            raise TypeError("from_opencv() needs world_to_camera, or R and t")
        else:
            rotation, moved = _rotation_matrix(R), np.array(_arrays.vector("t", t))
        _check_rotation("R" if world_to_camera is None else "world_to_camera", rotation)
        if abs(intrinsics[0, 1]) > _RATIO * abs(intrinsics[0, 0]):
            raise ValueError(f"K: expected no skew, found {intrinsics[0, 1]}")
        fov_y = _lens("K", intrinsics[0, 0], intrinsics[1, 1], intrinsics[0, 2], intrinsics[1, 2], size)
        eye = -rotation.T @ moved
        return cls(_triple(eye), _triple(eye + rotation[2]), _triple(-rotation[1]), fov_y=fov_y)

    @classmethod
    def from_nerfstudio(
        cls, camera_to_world: ArrayLike, *, fl_x: float, fl_y: float, cx: float, cy: float, w: int, h: int
    ) -> Camera:
        """Return the camera of a frame in nerfstudio's ``transforms.json``: +x right, +y up, -z forward.

        ``camera_to_world`` is the ``transform_matrix`` of the frame, 3 × 4, or 4 × 4 with the last row 0, 0, 0, 1. The other
        arguments are keys of the file, in pixels. Raises ValueError as `from_opencv` does.
        """
        pose = _pose_matrix("camera_to_world", camera_to_world)
        _check_rotation("camera_to_world", pose[:3, :3])
        fov_y = _lens("fl_x, fl_y, cx and cy", fl_x, fl_y, cx, cy, (w, h))
        eye = pose[:3, 3]
        return cls(_triple(eye), _triple(eye - pose[:3, 2]), _triple(pose[:3, 1]), fov_y=fov_y)

    def orbit(self, azimuth: float, elevation: float = 0.0) -> Camera:
        """Return the camera turned around its target, by ``azimuth`` and ``elevation`` in degrees.

        A positive azimuth turns it counterclockwise around ``up``, seen from above; a positive elevation raises it. It stays at
        least one degree off the vertical. Raises ValueError unless eye, target and up are given.
        """
        import numpy as np

        eye, target, up = self._given("orbit")
        up = up / np.linalg.norm(up)
        arm = eye - target
        distance = float(np.linalg.norm(arm))
        level = arm - (arm @ up) * up
        if np.linalg.norm(level) < _ALONG * distance:
            # From above any direction is as good as another one.
            level = np.cross(up, [1.0, 0.0, 0.0] if abs(up[0]) < 0.9 else [0.0, 1.0, 0.0])
        level = level / np.linalg.norm(level)
        side = np.cross(up, level)
        around = math.radians(_number("azimuth", azimuth))
        level = math.cos(around) * level + math.sin(around) * side
        height = math.degrees(math.asin(max(-1.0, min(1.0, float(arm @ up) / distance))))
        height = max(_POLE - 90.0, min(90.0 - _POLE, height + _number("elevation", elevation)))
        above = math.radians(height)
        eye = target + distance * (math.cos(above) * level + math.sin(above) * up)
        return replace(self, eye=_triple(eye), up=_triple(up))

    def zoom(self, factor: float) -> Camera:
        """Return the camera at ``factor`` times its distance from the target; the height of an orthographic one grows by it, too.

        Raises ValueError unless eye and target are given, and for a factor that is not above 0.
        """
        number = _number("factor", factor)
        if not 0.0 < number < math.inf:
            raise ValueError(f"factor: expected a number above 0, found {number}")
        eye, target, _ = self._given("zoom", up=False)
        height = None if self.height is None else self.height * number
        return replace(self, eye=_triple(target + number * (eye - target)), height=height)

    def pan(self, right: float, up: float) -> Camera:
        """Return the camera with eye and target moved across the view, in parts of the image height at the target.

        Raises ValueError unless eye, target and up are given, and for a camera that looks along ``up``.
        """
        import numpy as np

        eye, target, upward = self._given("pan")
        forward = target - eye
        distance = float(np.linalg.norm(forward))
        aside = np.cross(forward / distance, upward / np.linalg.norm(upward))
        if np.linalg.norm(aside) < _ALONG:
            raise ValueError(f"up: expected a direction aside of the view, found {self.up}, along which the camera looks")
        aside = aside / np.linalg.norm(aside)
        above = np.cross(aside, forward / distance)
        angle = 45.0 if self.fov_y is None else self.fov_y
        extent = 2.0 * distance * math.tan(math.radians(angle) / 2.0) if self.height is None else self.height
        moved = extent * (_number("right", right) * aside + _number("up", up) * above)
        return replace(self, eye=_triple(eye + moved), target=_triple(target + moved))

    def _given(self, doing: str, up: bool = True) -> tuple[Any, Any, Any]:
        import numpy as np

        if self.eye is None or self.target is None or (up and self.up is None):
            needed = "eye, target and up" if up else "eye and target"
            raise ValueError(f"{doing}: expected a camera with {needed}, found {self}; that of a picture has them: image.camera")
        # Of moderate length, so that its square is a number, too.
        direction = None if self.up is None else np.array(self.up) / max(map(abs, self.up))
        return np.array(self.eye), np.array(self.target), direction

    def _changes(self) -> list[Change]:
        """Return its keys in the scene file."""
        from ._settings import toml

        names = ("eye", "target", "up", "fov_y", "height", "near", "far")
        given = ((name, getattr(self, name)) for name in names)
        return [("camera", f"camera.{name}", toml(name, value), False) for name, value in given if value is not None]

    @classmethod
    def _of(cls, numbers: tuple[Any, ...]) -> Camera:
        eye, target, up, fov_y, height, near, far = numbers
        return cls(tuple(eye), tuple(target), tuple(up), fov_y, height, near, far)


def _number(name: str, value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected a number, found {type(value).__name__}") from None
    if not math.isfinite(number):
        raise ValueError(f"{name}: expected a finite number, found {number}")
    return number


def _triple(vector: Any) -> Vector:
    x, y, z = (float(value) for value in vector)
    return (x, y, z)


def _pose(eye: ArrayLike, target: ArrayLike, up: ArrayLike | None) -> tuple[Any, Any, Any]:
    pose = _arrays.vector("eye", eye), _arrays.vector("target", target)
    return (*pose, None if up is None else _arrays.vector("up", up))


def _pose_matrix(name: str, given: ArrayLike) -> Any:
    """Return a pose of shape (3, 4), from one of that shape or of (4, 4) with the last row 0, 0, 0, 1."""
    matrix = _arrays.matrix(name, given, (3, 4), (4, 4))
    if len(matrix) == 4:
        _check_last_row(name, matrix)
    return matrix


def _rotation_matrix(given: ArrayLike) -> Any:
    array = _arrays.numbers("R", given)
    if array.size == 3:
        raise ValueError(
            f"R: expected a matrix of shape (3, 3), found {array.shape}; cv2.Rodrigues(R)[0] makes one of a rotation vector"
        )
    return _arrays.matrix("R", array, (3, 3))


def _check_last_row(name: str, matrix: Any) -> None:
    """Check that the last row is 0, …, 0, 1, as in a matrix that multiplies columns of coordinates."""
    import numpy as np

    wanted = np.eye(len(matrix))[-1]
    if np.abs(matrix[-1] - wanted).max() <= _RATIO:
        return
    help = ""
    if np.abs(matrix[:, -1] - wanted).max() <= _RATIO:
        help = f"; its transpose has it: {name}.T"
    elif abs(matrix[-1, -1]) > 0.0 and np.abs(matrix[-1] / matrix[-1, -1] - wanted).max() <= _RATIO:
        help = f"; {name} / {name}[-1, -1] has it"
    row = ", ".join(f"{value:g}" for value in wanted)
    raise ValueError(f"{name}: expected the last row ({row}), found {matrix[-1].tolist()}{help}")


def _check_rotation(name: str, rotation: Any) -> None:
    import numpy as np

    off = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if off > _RATIO or np.linalg.det(rotation) < 0.0:
        raise ValueError(f"{name}: expected a rotation without scale or mirror, found {rotation.tolist()}")


def _lens(name: str, fl_x: float, fl_y: float, cx: float, cy: float, size: Size) -> float:
    """Return the vertical angle in degrees of square pixels around the middle of an image."""
    from ._settings import _size

    width, height = _size(size)
    fl_x, fl_y, cx, cy = (_number(name, value) for value in (fl_x, fl_y, cx, cy))
    if fl_x <= 0.0 or fl_y <= 0.0:
        raise ValueError(f"{name}: expected focal lengths above 0, found {fl_x} and {fl_y}")
    if abs(fl_x - fl_y) > _RATIO * fl_y:
        raise ValueError(f"{name}: expected square pixels, found focal lengths of {fl_x} and {fl_y}; undistort the images first")
    off = max(abs(cx - width / 2.0), abs(cy - height / 2.0))
    if off > _OFF_CENTER_PX:
        raise ValueError(
            f"{name}: expected a principal point in the middle of the image, ({width / 2.0}, {height / 2.0}), found ({cx}, {cy}), "
            f"{off:.1f} pixels off it: a scene has none elsewhere. Crop the images around it, and say their new size"
        )
    return math.degrees(2.0 * math.atan(height / (2.0 * fl_y)))

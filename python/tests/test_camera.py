"""Cameras: where they stand, and what calibrations mean."""

from __future__ import annotations

import math
import re
import struct
import zlib

import numpy as np
import pytest
from conftest import SIZE

import pellucid
from pellucid import Camera


def rotation(seed: int = 0) -> np.ndarray:
    """A random one."""
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def center_of_mass(image: pellucid.Image) -> tuple[float, float]:
    alpha = image.rgba[..., 3].astype(np.float64)
    rows, columns = np.mgrid[: alpha.shape[0], : alpha.shape[1]] + 0.5
    return float((alpha * columns).sum() / alpha.sum()), float((alpha * rows).sum() / alpha.sum())


def test_a_calibration_of_opencv_projects_points_where_opencv_does(renderer):
    width, height, focal = 160, 120, 130.0
    K = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
    R, t = rotation(3), np.array([0.3, -0.2, 5.0])
    point = R.T @ (np.array([0.7, 0.4, 4.5]) - t)
    u, v, w = K @ (R @ point + t)
    expected = (u / w, v / w)
    world_to_camera = np.eye(4)
    world_to_camera[:3, :3], world_to_camera[:3, 3] = R, t
    for camera in (
        Camera.from_opencv(K, world_to_camera, size=(width, height)),
        Camera.from_opencv(K, world_to_camera[:3], size=(width, height)),
        Camera.from_opencv(K, R=R, t=t.reshape(3, 1), size=(width, height)),
    ):
        image = pellucid.render([point], radii=[0.2], camera=camera, size=(width, height))
        assert center_of_mass(image) == pytest.approx(expected, abs=0.1)


def test_a_camera_of_nerfstudio_is_that_of_opencv_turned(renderer):
    K = np.array([[130.0, 0, 80], [0, 130.0, 60], [0, 0, 1]])
    world_to_camera = np.eye(4)
    world_to_camera[:3, :3], world_to_camera[:3, 3] = rotation(5), [0.1, 0.2, 6.0]
    of_opencv = Camera.from_opencv(K, world_to_camera, size=(160, 120))
    camera_to_world = np.linalg.inv(world_to_camera) @ np.diag([1.0, -1.0, -1.0, 1.0])
    camera = Camera.from_nerfstudio(camera_to_world, fl_x=130.0, fl_y=130.0, cx=80.0, cy=60.0, w=160, h=120)
    for name in ("eye", "target", "up", "fov_y"):
        assert getattr(camera, name) == pytest.approx(getattr(of_opencv, name), abs=1e-9)
    assert camera.fov_y == pytest.approx(math.degrees(2 * math.atan(60 / 130)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fl_y": 140.0}, "square pixels"),
        ({"cx": 81.0}, "principal point"),
        ({"fl_x": 0.0}, "focal lengths above 0"),
        ({"w": 0.5}, "size"),
    ],
)
def test_cameras_that_a_scene_can_not_express_are_refused(change, message):
    fine = {"fl_x": 130.0, "fl_y": 130.0, "cx": 80.0, "cy": 60.0, "w": 160, "h": 120}
    Camera.from_nerfstudio(np.eye(4), **{**fine, "cx": 80.5})
    with pytest.raises(ValueError, match=message):
        Camera.from_nerfstudio(np.eye(4), **{**fine, **change})
    with pytest.raises(ValueError, match="rotation without scale or mirror"):
        Camera.from_nerfstudio(np.diag([2.0, 2.0, 2.0, 1.0]), **fine)
    with pytest.raises(ValueError, match="rotation without scale or mirror"):
        Camera.from_nerfstudio(np.diag([1.0, 1.0, -1.0, 1.0]), **fine)


K = np.array([[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]])
MOVED = np.array([[1.0, 0, 0, 1], [0, 1, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])


def of_opencv(K=K, *pose, **given):
    return Camera.from_opencv(K, *pose, size=(640, 480), **given)


def of_nerfstudio(pose):
    return Camera.from_nerfstudio(pose, fl_x=500, fl_y=500, cx=320, cy=240, w=640, h=480)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: of_opencv(K, MOVED.T),
            "world_to_camera: expected the last row (0, 0, 0, 1), found [1.0, 2.0, 3.0, 1.0]; its transpose has it: "
            "world_to_camera.T",
        ),
        (
            lambda: of_nerfstudio(MOVED.T),
            "camera_to_world: expected the last row (0, 0, 0, 1), found [1.0, 2.0, 3.0, 1.0]; its transpose has it: "
            "camera_to_world.T",
        ),
        (
            lambda: of_opencv(K.T, MOVED),
            "K: expected the last row (0, 0, 1), found [320.0, 240.0, 1.0]; its transpose has it: K.T",
        ),
        (
            lambda: of_opencv(2 * K, MOVED),
            "K: expected the last row (0, 0, 1), found [0.0, 0.0, 2.0]; K / K[-1, -1] has it",
        ),
        (
            lambda: of_nerfstudio(MOVED * [[1], [1], [1], [0]]),
            "camera_to_world: expected the last row (0, 0, 0, 1), found [0.0, 0.0, 0.0, 0.0]",
        ),
        (
            lambda: of_opencv(K, "abc"),
            "world_to_camera: expected real numbers, found an array of <U3 of shape ()",
        ),
        (
            lambda: of_nerfstudio([["a"]]),
            "camera_to_world: expected real numbers, found an array of <U1 of shape (1, 1)",
        ),
        (
            lambda: of_nerfstudio(np.eye(3)),
            "camera_to_world: expected a matrix of shape (3, 4) or (4, 4), found (3, 3)",
        ),
        (
            lambda: of_opencv(K, R=[0.1, 0.2, 0.3], t=[0, 0, 1]),
            "R: expected a matrix of shape (3, 3), found (3,); cv2.Rodrigues(R)[0] makes one of a rotation vector",
        ),
        (
            lambda: of_opencv(K, R=np.eye(3), t=[[1], [2]]),
            "t: expected 3 numbers, found an array of shape (2, 1)",
        ),
    ],
)
def test_matrices_that_are_none_of_a_camera_are_refused(call, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        call()


def test_rounded_matrices_are_taken():
    assert of_opencv(K + 1e-6, MOVED + 1e-6).eye == pytest.approx((-1, -2, -3), abs=1e-4)
    assert of_nerfstudio(MOVED.astype(np.float32)[:3]).eye == (1, 2, 3)


def test_up_may_have_any_length():
    for length in (1e-300, 1.0, 1e300):
        camera = Camera.look_at((0.0, -10.0, 0.0), (0.0, 0.0, 0.0), up=(0, 0, length), fov_y=90.0)
        assert camera.pan(0.5, 0.25).target == pytest.approx((10.0, 0.0, 5.0))
        assert camera.orbit(90.0).eye == pytest.approx((10.0, 0.0, 0.0))


def test_orbits_keep_the_distance_and_come_back():
    camera = Camera.look_at((3.0, -4.0, 2.0), (1.0, 0.0, 0.0), up=(0, 0, 1))
    distance = math.dist(camera.eye, camera.target)
    turned = camera.orbit(90.0)
    assert math.dist(turned.eye, camera.target) == pytest.approx(distance)
    # A quarter turn to the left, seen from above: (2, -4) becomes (4, 2).
    assert turned.eye == pytest.approx((5.0, 2.0, 2.0))
    assert camera.orbit(360.0).eye == pytest.approx(camera.eye)
    assert camera.orbit(30.0, 10.0).orbit(-30.0, -10.0).eye == pytest.approx(camera.eye)
    above = camera.orbit(0.0, 500.0)
    assert math.degrees(math.asin(above.eye[2] / distance)) == pytest.approx(89.0)
    below = camera.orbit(0.0, -500.0)
    assert math.degrees(math.asin(below.eye[2] / distance)) == pytest.approx(-89.0)


def test_zoom_and_pan():
    camera = Camera.look_at((0.0, -10.0, 0.0), (0.0, 0.0, 0.0), up=(0, 0, 1), fov_y=90.0)
    assert camera.zoom(0.5).eye == pytest.approx((0.0, -5.0, 0.0))
    moved = camera.pan(0.5, 0.25)
    # The image shows 20 units from bottom to top at the target.
    assert moved.target == pytest.approx((10.0, 0.0, 5.0))
    assert moved.eye == pytest.approx((10.0, -10.0, 5.0))
    flat = Camera.orthographic((0, -10, 0), (0, 0, 0), 4.0, up=(0, 0, 1))
    assert flat.zoom(0.5).height == 2.0
    assert flat.pan(0.0, 1.0).target == pytest.approx((0.0, 0.0, 4.0))
    with pytest.raises(ValueError, match=r"image\.camera"):
        Camera(fov_y=30.0).orbit(5.0)
    with pytest.raises(ValueError, match="factor"):
        camera.zoom(0.0)


def test_the_camera_that_was_found_takes_the_same_picture(renderer, points):
    image = pellucid.render(points, opacity=0.3, size=SIZE)
    camera = image.camera
    assert None not in (camera.eye, camera.target, camera.up, camera.near, camera.far)
    again = pellucid.render(points, opacity=0.3, size=SIZE, camera=camera)
    np.testing.assert_allclose(again.rgba, image.rgba, atol=1e-4)
    flat = pellucid.render(points, opacity=0.3, size=SIZE, ortho=True)
    assert flat.camera.fov_y is None
    assert flat.camera.height > 0.0


def test_a_camera_may_leave_things_open(renderer, points):
    image = pellucid.render(points, size=SIZE, camera=Camera(fov_y=20.0))
    assert image.camera.fov_y == pytest.approx(20.0)
    as_keys = pellucid.render(points, size=SIZE, camera={"fov_y": 20.0})
    np.testing.assert_array_equal(as_keys.rgba, image.rgba)


def test_far_from_the_origin_nothing_changes(renderer, points):
    points = points.astype(np.float32).astype(np.float64)
    moved = np.array([500_000.0, 4_500_000.0, 128.0])
    eye, target = np.array([6.0, -7.0, 3.0]), np.zeros(3)
    near = pellucid.render(points, radius=0.2, opacity=0.3, size=SIZE, camera=Camera.look_at(eye, target, up=(0, 0, 1)))
    far = pellucid.render(
        points + moved, radius=0.2, opacity=0.3, size=SIZE, camera=Camera.look_at(eye + moved, target + moved, up=(0, 0, 1))
    )
    np.testing.assert_allclose(far.rgba, near.rgba, atol=1e-3)


@pytest.mark.parametrize("end", ["png", "exr"])
def test_the_camera_of_a_file_takes_the_same_picture_to_the_last_bit(renderer, points, tmp_path, end):
    surveyed = points + np.array([512345.6, 5403210.9, 312.5])
    image = pellucid.render(surveyed, opacity=0.3, size=SIZE, view="top")
    image.save(tmp_path / f"a.{end}")
    camera = Camera.from_picture(tmp_path / f"a.{end}")
    assert camera == image.camera
    assert "pellucid:camera" in image.metadata
    again = pellucid.render(surveyed, opacity=0.3, size=SIZE, camera=camera)
    np.testing.assert_array_equal(again.rgba, image.rgba)
    np.testing.assert_array_equal(again.depth, image.depth)


def test_a_picture_without_a_camera_is_refused(tmp_path):
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    # One gray pixel.
    head = chunk(b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 0, 0, 0, 0))
    data = chunk(b"IDAT", zlib.compress(b"\0\0")) + chunk(b"IEND", b"")
    (tmp_path / "photo.png").write_bytes(b"\x89PNG\r\n\x1a\n" + head + data)
    with pytest.raises(pellucid.SceneError, match=r"photo\.png: expected the camera"):
        Camera.from_picture(tmp_path / "photo.png")
    with pytest.raises(OSError, match=r"nowhere\.png"):
        Camera.from_picture(tmp_path / "nowhere.png")

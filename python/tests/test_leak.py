"""Memory that comes back: of the host and of the device."""

from __future__ import annotations

import gc

import numpy as np
import pytest
from conftest import SIZE

import pellucid

RENDERS = 1000
# Resident bytes that may be added after the first renders: arenas of allocators grow a little for long.
SLACK = 16 << 20


def resident() -> int:
    with open("/proc/self/statm") as file:
        pages = int(file.read().split()[1])
    return pages * 4096


@pytest.fixture(autouse=True)
def linux():
    try:
        resident()
    except FileNotFoundError:
        pytest.skip("a system without /proc")


def test_renders_leave_nothing_behind(points):
    """Each takes points, device buffers and a picture of some 200 kB: a thousand would leave 200 MB."""
    renderer = pellucid.Renderer()
    points = np.tile(points, (4, 1))

    def render() -> None:
        with renderer.load(points, opacity=0.3, size=(96, 64)) as loaded:
            image = loaded.frame(fragments=True)
            assert np.asarray(image).shape == (64, 96, 4)

    for _ in range(50):
        render()
    gc.collect()
    before, on_device = resident(), renderer.bytes_in_use
    for _ in range(RENDERS):
        render()
    gc.collect()
    assert renderer.bytes_in_use == on_device
    assert resident() - before < SLACK, f"{(resident() - before) / RENDERS:.0f} bytes each"


def test_frames_leave_nothing_behind(renderer, points):
    with renderer.load(points, opacity=0.3, size=SIZE) as loaded:
        # Once around: buffers are as large as the fullest view wants them.
        cameras = [loaded.camera.orbit(10.0 * step) for step in range(36)]
        factors = [0.5, 1.0]
        for camera in cameras:
            for factor in factors:
                loaded.frame(camera=camera, opacity_factor=factor)
        gc.collect()
        before, on_device = resident(), renderer.bytes_in_use
        for step in range(RENDERS):
            loaded.frame(camera=cameras[step % 36], opacity_factor=factors[step % 2])
        gc.collect()
        assert renderer.bytes_in_use == on_device
        assert resident() - before < SLACK


def test_failures_leave_nothing_behind(renderer, points):
    def fail() -> None:
        with pytest.raises(pellucid.SceneError):
            renderer.load(points, opacity=0.3, size=SIZE, radius=-1.0)
        with renderer.load(points, size=SIZE) as loaded, pytest.raises(pellucid.SceneError):
            loaded.frame(method="no such method")

    for _ in range(20):
        fail()
    gc.collect()
    before, on_device = resident(), renderer.bytes_in_use
    for _ in range(200):
        fail()
    gc.collect()
    assert renderer.bytes_in_use == on_device
    assert resident() - before < SLACK


def test_clouds_leave_nothing_behind():
    """A million points take 24 MB in float64."""
    points = np.zeros((1_000_000, 3), dtype=np.float32)
    pellucid.Cloud(points, z_up=True)
    gc.collect()
    before = resident()
    for _ in range(30):
        assert len(pellucid.Cloud(points, z_up=True)) == 1_000_000
    gc.collect()
    assert resident() - before < 60 << 20

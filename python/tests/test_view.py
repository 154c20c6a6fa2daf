"""`pellucid.view` without a browser: fallbacks, and what the painter's thread does."""

import queue
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pellucid
from pellucid._painter import Painter, Picture

POINTS = np.random.default_rng(5).random((2000, 3))


def test_without_a_notebook_it_is_a_picture() -> None:
    image = pellucid.view(POINTS, size=(64, 48), opacity=0.3)
    assert isinstance(image, pellucid.Image)
    np.testing.assert_array_equal(image.rgba, pellucid.render(POINTS, size=(64, 48), opacity=0.3).rgba)


def test_a_budget_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^budget_ms: found 0, expected milliseconds above 0$"):
        pellucid.view(POINTS, budget_ms=0)


def test_a_notebook_without_widgets_is_told_what_to_install(tmp_path: Path) -> None:
    """In a process of its own, where jupyter_rfb can't be imported and a shell pretends to have a kernel."""
    code = """
import sys, types, warnings
import numpy as np
sys.modules["jupyter_rfb"] = None
sys.modules["IPython"] = types.SimpleNamespace(get_ipython=lambda: types.SimpleNamespace(kernel=object()))
import pellucid
with warnings.catch_warnings(record=True) as found:
    warnings.simplefilter("always")
    image = pellucid.view(np.eye(3), size=(16, 16))
assert type(image) is pellucid.Image
print(*[(w.category.__name__, str(w.message)) for w in found if "view" in str(w.message)])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert "PellucidWarning" in done.stdout
    assert "pip install jupyter_rfb ipywidgets" in done.stdout


class Made:
    """A painter, and the pictures that it delivers."""

    def __init__(self, **arguments: object) -> None:
        self.pictures: queue.Queue[Picture | Exception] = queue.Queue()
        self.painter = Painter(POINTS, arguments, device=None, size=(160, 120), budget_ms=33, deliver=self.pictures.put)
        self.request = self.painter.begin.request

    def until_whole(self) -> list[Picture]:
        found: list[Picture] = []
        while not found or not found[-1].whole:
            picture = self.pictures.get(timeout=60)
            assert isinstance(picture, Picture), picture
            found.append(picture)
        return found


@pytest.fixture
def made() -> object:
    made = Made(opacity=0.3, method="stochastic")
    yield made
    made.painter.close()


def test_pictures_get_finer_until_nothing_is_left_out(made: Made) -> None:
    made.painter.ask(replace(made.request, samples=64))
    pictures = made.until_whole()
    assert len(pictures) > 1, "the first one is a draft"
    work = [picture.draft.work(64) for picture in pictures]
    assert work == sorted(work)
    assert work[0] < 1 == work[-1]
    assert pictures[0].pixels.shape == (60, 80, 3), "a quarter of the pixels, as nothing was measured yet"
    assert pictures[-1].pixels.shape == (120, 160, 3)
    errors = [picture.standard_error for picture in pictures]
    assert errors[0] is not None
    assert errors[-1] is not None
    assert errors[-1] < errors[0]


def test_the_whole_picture_is_that_of_render(made: Made) -> None:
    request = replace(made.request, samples=16)
    own = made.painter.whole(request)
    expected = pellucid.render(POINTS, opacity=0.3, method="stochastic", samples=16, size=(160, 120), camera=made.request.camera)
    np.testing.assert_array_equal(own.rgba, expected.rgba)


def test_only_the_latest_request_is_finished(made: Made) -> None:
    for azimuth in range(40):
        made.painter.ask(replace(made.request, camera=made.request.camera.orbit(azimuth), samples=1024))
    last = made.until_whole()[-1]
    direct = made.painter.whole(replace(made.request, camera=made.request.camera.orbit(39), samples=1024))
    difference = last.pixels.astype(int) - direct.to_srgb()
    assert np.abs(difference).max() <= 1, "what a byte of sRGB tells no more"
    assert made.pictures.qsize() == 0


def test_opacity_and_settings_change_the_picture(made: Made) -> None:
    plain = made.painter.whole(replace(made.request, samples=64)).rgba[..., 3].mean()
    faint = made.painter.whole(replace(made.request, samples=64, opacity_factor=0.1)).rgba[..., 3].mean()
    assert 0 < faint < 0.5 * plain


def test_drafts_of_many_points_leave_some_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """A quarter of the points in a quarter of the pixels; the picture at rest has all of them, as if none had been left out."""
    asked: list[object] = []
    frame = pellucid.Loaded.frame

    def counted(loaded: pellucid.Loaded, **settings: object) -> pellucid.Image:
        asked.append((settings.get("size"), settings.get("detail")))
        return frame(loaded, **settings)  # type: ignore[arg-type]

    monkeypatch.setattr(pellucid.Loaded, "frame", counted)
    monkeypatch.setattr("pellucid._painter._FEW_POINTS", 1000)
    made = Made(opacity=0.3, method="abuffer")
    made.painter.ask(made.request)
    last = made.until_whole()[-1]
    made.painter.close()
    assert asked[:2] == [((160, 120), None), ((80, 60), {"max_points": 500})]
    assert asked[-1] == ((160, 120), None)
    monkeypatch.undo()
    expected = pellucid.render(POINTS, opacity=0.3, method="abuffer", accuracy="8-bit", size=(160, 120), camera=made.request.camera)
    np.testing.assert_array_equal(last.pixels, expected.to_srgb())


def test_errors_of_frames_are_delivered_and_painting_goes_on(made: Made) -> None:
    made.painter.ask(replace(made.request, settings={"no_such_key": 1}))
    error = made.pictures.get(timeout=60)
    assert isinstance(error, TypeError)
    assert "no_such_key" in str(error)
    made.painter.ask(replace(made.request, samples=8))
    assert made.until_whole()


def test_errors_of_loading_are_raised() -> None:
    with pytest.raises(pellucid.ReadError, match=r"nowhere\.las"):
        Painter("/nowhere.las", {}, device=None, budget_ms=33, deliver=print)


def test_a_closed_painter_has_no_thread(made: Made) -> None:
    made.painter.close()
    assert not any(thread.name == "pellucid view" for thread in threading.enumerate())
    with pytest.raises(pellucid.Error, match="the window is closed"):
        made.painter.whole(made.request)

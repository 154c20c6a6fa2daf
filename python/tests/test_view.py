"""`pellucid.view` without a browser: fallbacks, and what the painter's thread does."""

import asyncio
import gc
import inspect
import json
import queue
import signal
import subprocess
import sys
import threading
import time
import types
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pellucid
from pellucid._painter import Painter, Picture, Request

POINTS = np.random.default_rng(5).random((2000, 3))


def test_without_a_notebook_it_is_a_picture() -> None:
    image = pellucid.view(POINTS, size=(64, 48), opacity=0.3)
    assert isinstance(image, pellucid.Image)
    np.testing.assert_array_equal(image.rgba, pellucid.render(POINTS, size=(64, 48), opacity=0.3).rgba)


def test_it_refuses_what_render_refuses() -> None:
    for call in (pellucid.render, pellucid.view):
        with pytest.raises(TypeError, match=r"^'nonsense' is neither an argument nor a key of the scene file"):
            call(POINTS, nonsense=None)


@pytest.mark.parametrize("frame_ms", [0, "a", float("nan"), None])
def test_a_budget_of_nothing_is_refused(frame_ms: object) -> None:
    with pytest.raises(ValueError, match=rf"^frame_ms: expected a number above 0, found {frame_ms!r}$"):
        pellucid.view(POINTS, frame_ms=frame_ms)


def test_arguments_are_those_of_render() -> None:
    theirs, own = (dict(inspect.signature(function).parameters) for function in (pellucid.render, pellucid.view))
    assert own.pop("frame_ms").default == 33.0
    assert own == theirs
    image = pellucid.view(POINTS, size=(32, 24), opacity=0.3, method="abuffer", fragments=True, depths=True, accuracy="8-bit")
    assert image.fragments is not None
    assert image.median_depth is not None
    chosen = pellucid.view(POINTS, size=(32, 24), opacity=0.3, radius=0.1, budget_ms=1000)
    assert "pellucid:choice" in chosen.metadata, "which is the budget of render"
    with pytest.raises(ValueError, match=r"^accuracy: expected 'exact' or '8-bit', found 'good'$"):
        pellucid.view(POINTS, accuracy="good")


def test_a_notebook_without_widgets_is_told_what_to_install(tmp_path: Path) -> None:
    """Runs in a process of its own, where jupyter_rfb can't be imported and a shell pretends to have a kernel."""
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
print(*[(w.category.__name__, str(w.message), w.filename) for w in found if "view" in str(w.message)])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert "PellucidWarning" in done.stdout
    assert "pip install jupyter_rfb ipywidgets" in done.stdout
    assert "'<string>'" in done.stdout, "the warning is about the line that called"


class Made:
    """A painter, and the pictures that it delivers."""

    def __init__(self, **arguments: object) -> None:
        self.pictures: queue.Queue[Picture | Exception] = queue.Queue()
        self.painter = Painter(POINTS, arguments, device=None, size=(160, 120), frame_ms=33, deliver=self.pictures.put)
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
    of_picture = {"size": (160, 120), "camera": made.request.camera}
    expected = pellucid.render(POINTS, opacity=0.3, method="stochastic", method__samples=16, **of_picture)
    np.testing.assert_array_equal(own.rgba, expected.rgba)


def test_only_the_latest_request_is_finished(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    """A few others may be finished, too, if the system lets this thread wait between two of them."""
    followed: list[Request] = []
    follow = Painter._follow

    def noted(painter: Painter, scene: pellucid.Loaded, request: Request) -> None:
        try:
            follow(painter, scene, request)
        finally:
            followed.append(request)

    monkeypatch.setattr(Painter, "_follow", noted)
    requests = [replace(made.request, camera=made.request.camera.orbit(azimuth), samples=1024) for azimuth in range(40)]
    for request in requests:
        made.painter.ask(request)
    wait_until(lambda: requests[-1] in followed, 60)
    pictures = [made.pictures.get() for _ in range(made.pictures.qsize())]
    last = pictures[-1]
    assert isinstance(last, Picture)
    assert last.whole
    assert sum(isinstance(picture, Picture) and picture.whole for picture in pictures) < 20
    direct = made.painter.whole(requests[-1])
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
        Painter("/nowhere.las", {}, device=None, frame_ms=33, deliver=print)
    with pytest.raises(TypeError, match="progress: expected"):
        Painter(POINTS, {"progress": 3}, device=None, frame_ms=33, deliver=print)


def test_a_closed_painter_has_no_thread(made: Made) -> None:
    made.painter.close()
    assert not any(thread.name == "pellucid view" for thread in threading.enumerate())
    with pytest.raises(pellucid.Error, match="the window is closed"):
        made.painter.whole(made.request)


def painters() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == "pellucid view"]


def wait_until(condition: object, seconds: float = 30) -> None:
    limit = time.monotonic() + seconds
    while not condition():  # type: ignore[operator]
        assert time.monotonic() < limit
        time.sleep(0.01)


def in_a_thread(work: object) -> tuple[threading.Thread, list[object]]:
    """A thread that does work, and what came of it: a result or an error."""
    found: list[object] = []

    def run() -> None:
        try:
            found.append(work())  # type: ignore[operator]
        except Exception as error:
            found.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    return thread, found


def test_closing_lets_nobody_wait(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of two requested pictures is in work when the window is closed, and the other isn't begun."""
    begun = threading.Event()
    frame = pellucid.Loaded.frame

    def slow(loaded: pellucid.Loaded, **settings: object) -> pellucid.Image:
        begun.set()
        wait_until(lambda: made.painter._closed)
        return frame(loaded, **settings)  # type: ignore[arg-type]

    monkeypatch.setattr(pellucid.Loaded, "frame", slow)
    waiting = [in_a_thread(lambda: made.painter.whole(made.request)) for _ in range(2)]
    assert begun.wait(30)
    wait_until(lambda: len(made.painter._tasks) == 1)
    made.painter.close()
    for thread, _ in waiting:
        thread.join(30)
        assert not thread.is_alive()
    results = [found[0] for _, found in waiting]
    assert any(isinstance(result, pellucid.Error) and str(result) == "the window is closed" for result in results), results


def test_a_painter_that_died_lets_nobody_wait(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("no more")

    monkeypatch.setattr(Painter, "_follow", broken)
    monkeypatch.setattr(made.painter, "_deliver", broken)
    monkeypatch.setattr("threading.excepthook", lambda _: None)
    made.painter.ask(made.request)
    made.painter._thread.join(30)
    with pytest.raises(pellucid.Error, match=r"^the window was closed by an error: no more$"):
        made.painter.whole(made.request)


def test_whole_pictures_wait_for_one_another(made: Made) -> None:
    waiting = [in_a_thread(lambda: made.painter.whole(made.request)) for _ in range(4)]
    for thread, found in waiting:
        thread.join(60)
        assert isinstance(found[0], pellucid.Image)


def test_ctrl_c_while_points_are_loaded_ends_the_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    load = pellucid.Renderer.load

    def interrupted(renderer: pellucid.Renderer, *points: object, **arguments: object) -> pellucid.Loaded:
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)  # type: ignore[arg-type]
        time.sleep(0.5)
        return load(renderer, *points, **arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(pellucid.Renderer, "load", interrupted)
    with pytest.raises(KeyboardInterrupt):
        Painter(POINTS, {}, device=None, frame_ms=33, deliver=print)
    wait_until(lambda: not painters())


def test_closing_stops_loading() -> None:
    """The bar is asked for in the midst of it: Ctrl-C comes, and the thread ends with the next step."""
    steps: list[str] = []
    updates: list[float] = []
    # Made in two steps, as the bar is asked for before there would be a painter.
    painter = Painter.__new__(Painter)

    def bar(total: int | None = None, desc: str = "") -> object:
        if not steps:
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)  # type: ignore[arg-type]
            wait_until(lambda: painter._closed)
        steps.append(desc)
        return types.SimpleNamespace(update=updates.append, close=lambda: None)

    many = np.random.default_rng(0).random((300_000, 3))
    with pytest.raises(KeyboardInterrupt):
        Painter.__init__(painter, many, {"progress": bar}, device=None, frame_ms=33, deliver=print)
    wait_until(lambda: not painters())
    assert len(steps) == 1
    assert updates == [], "the work is outdated"


def window(**arguments: object) -> object:
    """Makes the window that `view` makes in a notebook, here in a loop without one."""
    from pellucid._window import Window

    frame = {"fragments": True, "depths": False, "accuracy": "exact"}
    return Window(POINTS, size=(80, 60), device=None, frame_ms=33, arguments=arguments, frame=frame)


def test_a_window_that_fails_leaves_no_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("jupyter_rfb")

    def broken(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("pellucid._window._controls", broken)

    async def work() -> None:
        with pytest.raises(KeyboardInterrupt):
            window(opacity=0.3)
        # Nor complaints by what collects it.
        with pytest.raises(TypeError, match="no_such"):
            window(no_such=1)
        gc.collect()

    asyncio.run(work())
    wait_until(lambda: not painters())


GIVEN_DEPTHS = {
    "as keys": {"near": 1.9, "far": 2.3},
    "one of them": {"near": 1.9},
    "in a dict": {"camera": {"near": 1.9, "far": 2.3}},
    "in a camera": {"camera": pellucid.Camera(near=1.9, far=2.3)},
    "in a camera with a lens": {"camera": pellucid.Camera(fov_y=30, near=2.9)},
}


@pytest.mark.parametrize("given", GIVEN_DEPTHS.values(), ids=GIVEN_DEPTHS.keys())
def test_near_and_far_that_were_given_stay(given: dict[str, object]) -> None:
    made = Made(opacity=0.3, method="abuffer", **given)
    made.painter.close()
    first, camera = made.painter.begin.image, made.request.camera
    plain = pellucid.render(POINTS, opacity=0.3, method="abuffer", size=first.size, camera=replace(camera, near=None, far=None))
    assert np.abs(first - plain).mean() > 0.01, "they cut"
    again = pellucid.render(POINTS, opacity=0.3, method="abuffer", size=first.size, camera=camera)
    assert np.abs(first - again).mean() < 0.001


def test_a_camera_of_the_window_is_whole() -> None:
    pytest.importorskip("jupyter_rfb")

    async def work() -> None:
        shown = window(opacity=0.3)
        try:
            home = shown.camera
            shown.camera = pellucid.Camera(fov_y=30)
            assert shown.camera == replace(home, fov_y=30)
            shown.camera = pellucid.Camera((5, 6, 7), height=2.0)
            assert shown.camera == pellucid.Camera((5, 6, 7), home.target, home.up, height=2.0)
            drag = {"x": 10, "y": 10, "button": 1}
            shown._handle({**drag, "type": "pointer_down"})
            shown._handle({**drag, "type": "pointer_move", "x": 30})
            turned = shown.camera
            assert turned.eye != (5, 6, 7)
            for wrong, kind in ((None, "NoneType"), ({"fov_y": 30}, "dict")):
                with pytest.raises(TypeError, match=f"^camera: expected a Camera, found {kind}$"):
                    shown.camera = wrong
            assert shown.camera == turned
        finally:
            shown.close()

    asyncio.run(work())


def test_the_slider_multiplies_the_opacity_that_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The opacity is looked for once."""
    pytest.importorskip("jupyter_rfb")
    asked: list[dict[str, object]] = []
    frame = pellucid.Loaded.frame

    def noted(loaded: pellucid.Loaded, **settings: object) -> pellucid.Image:
        asked.append(settings)
        return frame(loaded, **settings)  # type: ignore[arg-type]

    monkeypatch.setattr(pellucid.Loaded, "frame", noted)

    async def work() -> None:
        shown = window(radius=0.1, see_through=0.5, method="abuffer")
        try:
            first = shown.picture()
            assert first.fragments is not None, "as it was asked for"
            covered = first[..., 3][first[..., 3] > 0]
            assert np.median(1 - covered) == pytest.approx(0.5, abs=0.01)
            shown._controls["opacity_factor"].value = 0.1
            faint = shown.picture()
            assert faint[..., 3].mean() < 0.5 * first[..., 3].mean()
        finally:
            shown.close()

    asyncio.run(work())
    assert ["see_through" in settings for settings in asked] == [True] + [False] * (len(asked) - 1)


def test_the_choice_for_the_first_picture_stays() -> None:
    made = Made(opacity=0.3, radius=0.1, method="stochastic", max_error=0.05)
    try:
        begin = made.painter.begin
        chosen = json.loads(begin.image.metadata["pellucid:choice"])["setting"]
        # Which other keys belong to the fastest setting depends on the machine.
        assert chosen.split()[0] == f"method.samples={begin.settings['samples']}"
        image = made.painter.whole(made.request)
        assert json.loads(image.metadata["pellucid:settings"])["method"]["samples"] == begin.settings["samples"]
        assert "pellucid:choice" not in image.metadata
    finally:
        made.painter.close()

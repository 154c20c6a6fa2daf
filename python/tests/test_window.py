"""The window of `pellucid.view` in a real browser: JupyterLab, headless Chromium, a pointer."""

import base64
import io
import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import nbformat
import numpy as np
import pytest
from conftest import require
from matplotlib.image import imread
from nbclient import NotebookClient
from playwright.sync_api import Locator, Page, sync_playwright

CHROMIUM = os.environ.get("PELLUCID_CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")

CELL = """
import numpy as np, pellucid
rng = np.random.default_rng(1)
points = rng.random((20_000, 3)) * (3, 2, 1)
colors = (points / points.max(axis=0) * 255).astype(np.uint8)
cloud = pellucid.Cloud(points, colors=colors, radii=np.full(20_000, 0.03), opacity=0.3)
window = pellucid.view(cloud, method="stochastic", size=(400, 300))
window
"""


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


@pytest.fixture
def jupyter(tmp_path: Path) -> Iterator[str]:
    """The address of a notebook with one cell, in a server that has nothing of the user's settings."""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(CELL)])
    notebook.metadata["kernelspec"] = {"name": "python3", "display_name": "Python 3", "language": "python"}
    (tmp_path / "window.ipynb").write_text(nbformat.writes(notebook))
    port, token = free_port(), "pellucid"
    folders = {
        name: str(tmp_path / name)
        for name in ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR", "JUPYTERLAB_SETTINGS_DIR")
    }
    command = [
        sys.executable,
        "-m",
        "jupyterlab",
        "--no-browser",
        "--allow-root",
        f"--port={port}",
        f"--IdentityProvider.token={token}",
    ]
    log = (tmp_path / "log").open("w")
    server = subprocess.Popen([*command, f"--ServerApp.root_dir={tmp_path}"], env={**os.environ, **folders}, stdout=log, stderr=log)
    try:
        for _ in range(600):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    break
            assert server.poll() is None, (tmp_path / "log").read_text()
            time.sleep(0.1)
        yield f"http://127.0.0.1:{port}/doc/tree/window.ipynb?token={token}"
    finally:
        server.terminate()
        server.wait(timeout=30)
        log.close()


@pytest.fixture
def page(jupyter: str) -> Iterator[Page]:
    if CHROMIUM is None:
        require("no Chromium: apt-get install chromium, or PELLUCID_CHROMIUM names one")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1100, "height": 900})
        # JupyterLab may ask to be built anew, for extensions that Open3D brings.
        page.add_locator_handler(page.locator(".jp-Dialog"), lambda dialog: dialog.locator(".jp-mod-reject").click())
        page.goto(jupyter, timeout=120_000)
        yield page
        browser.close()


def run_first_cell(page: Page) -> None:
    """Runs it, however often the page loses the click: before the kernel is there, or behind a dialog."""
    page.locator(".jp-Notebook-ExecutionIndicator[data-status=idle]").wait_for(timeout=60_000)
    prompt = page.locator(".jp-InputPrompt").first
    for _ in range(40):
        if prompt.inner_text().strip() not in ("", "[ ]:"):
            return
        page.locator(".jp-CodeCell .cm-content").first.click()
        page.locator("[data-command='notebook:run-cell-and-select-next']").click()
        page.wait_for_timeout(500)
    raise AssertionError(f"the cell was not run: {prompt.inner_text()!r}")


def seen(canvas: Locator) -> np.ndarray:
    """The canvas as the browser shows it, (h, w, 3) from 0 to 1."""
    return imread(io.BytesIO(canvas.screenshot()))[..., :3]


def difference(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs(a - b).mean())


def wait_until_whole(page: Page, canvas: Locator, before: np.ndarray | None = None) -> tuple[str, np.ndarray]:
    """The caption and the picture, once a whole one is there that stays, and is another one than ``before``."""
    limit = time.monotonic() + 60
    caption = page.locator(".widget-label", has_text="· whole ·")
    while time.monotonic() < limit:
        if caption.count():
            picture = seen(canvas)
            page.wait_for_timeout(600)  # the picture without losses comes 0.3 s after the last one
            stays = np.array_equal(picture, seen(canvas)) and caption.count() > 0
            if stays and (before is None or difference(before, picture) > 0.001):
                return str(caption.last.inner_text()), picture
        page.wait_for_timeout(100)
    raise AssertionError(f"no whole picture within a minute: {page.locator('.widget-label').all_inner_texts()}")


def drag(page: Page, canvas: Locator, by: tuple[int, int], key: str | None = None) -> None:
    box = canvas.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    if key is not None:
        page.keyboard.down(key)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + by[0], y + by[1], steps=8)
    page.mouse.up()
    if key is not None:
        page.keyboard.up(key)


def test_the_window_follows_the_pointer(page: Page, tmp_path: Path) -> None:
    pictures = Path(os.environ.get("PELLUCID_PICTURES", tmp_path))
    run_first_cell(page)
    canvas = page.locator("img.renderview-view")
    canvas.wait_for(timeout=60_000)
    caption, first = wait_until_whole(page, canvas)
    assert caption.startswith("stochastic · 64 samples · whole · standard error 0.0"), caption
    page.screenshot(path=pictures / "window.png")
    assert first.std() > 0.05, "the points are there"

    # A drag turns: the picture changes, and dragging back brings the first one back.
    drag(page, canvas, (90, 30))
    _, turned = wait_until_whole(page, canvas, first)
    page.screenshot(path=pictures / "turned.png")
    assert difference(first, turned) > 0.03
    drag(page, canvas, (-90, -30))
    _, back = wait_until_whole(page, canvas, turned)
    assert difference(first, back) < 0.2 * difference(first, turned)

    # Shift moves: what stood left of the middle stands right of it.
    drag(page, canvas, (60, 0), key="Shift")
    _, moved = wait_until_whole(page, canvas, back)
    # Near points move farther than far ones: the two are alike, not the same.
    assert difference(first[:, :-60], moved[:, 60:]) < 0.5 * difference(first, moved)

    # The wheel comes nearer, and a double click brings the first view back.
    canvas.hover()
    page.mouse.wheel(0, -400)
    _, nearer = wait_until_whole(page, canvas, moved)
    page.screenshot(path=pictures / "nearer.png")
    black = lambda picture: float((picture.max(axis=2) < 0.02).mean())  # noqa: E731
    assert black(nearer) < black(moved) - 0.05
    canvas.dblclick()
    _, home = wait_until_whole(page, canvas, nearer)
    page.screenshot(path=pictures / "home.png")
    assert difference(first, home) < 0.2 * difference(first, turned)

    # A slider: fewer samples are noisier, less opacity is darker.
    samples = page.locator(".widget-inline-hbox", has_text="samples").locator(".noUi-handle")
    samples.focus()
    for _ in range(4):
        page.keyboard.press("ArrowLeft")
    caption, noisy = wait_until_whole(page, canvas, home)
    assert caption.startswith("stochastic · 4 samples · whole"), caption
    opacity = page.locator(".widget-inline-hbox", has_text="opacity").locator(".noUi-handle")
    opacity.focus()
    for _ in range(10):
        page.keyboard.press("PageDown")
    _, faint = wait_until_whole(page, canvas, noisy)
    assert faint.mean() < 0.7 * first.mean()
    page.screenshot(path=pictures / "faint.png")


LATER_CELL = """
first = window.picture()
window.camera = window.camera.orbit(30)
turned = window.picture(size=(40, 30))
window.close()
try:
    window.picture()
except pellucid.Error as error:
    print(first.shape, turned.shape, float(abs(first.camera.eye[0] - turned.camera.eye[0])) > 0.1, error)
"""


def test_a_notebook_without_a_page() -> None:
    """Pages without a kernel show a PNG, which the output holds beside the widget. Later cells use the window."""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in (CELL, LATER_CELL)])
    NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = [output for output in notebook.cells[0].outputs if "image/png" in output.get("data", {})]
    assert len(outputs) == 1, json.dumps([list(output.get("data", {})) for output in notebook.cells[0].outputs])
    assert "application/vnd.jupyter.widget-view+json" in outputs[0].data
    assert imread(io.BytesIO(base64.b64decode(outputs[0].data["image/png"]))).shape == (300, 400, 3)
    later = notebook.cells[1].outputs
    assert [output.text for output in later] == ["(300, 400, 4) (30, 40, 4) True the window is closed\n"]

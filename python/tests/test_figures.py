"""Figures show the numbers of their results."""

import re

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

import pellucid

POINTS = np.random.default_rng(6).random((3000, 3))


def png_of(figure: Figure) -> np.ndarray:
    """The pixels that a notebook would show."""
    from io import BytesIO

    from matplotlib.image import imread

    return imread(BytesIO(figure._repr_png_()))  # type: ignore[attr-defined]


def assert_drawn(figure: Figure) -> None:
    assert isinstance(figure, Figure)
    pixels = png_of(figure)
    assert pixels.shape[0] > 100
    assert pixels[..., :3].std() > 0.01, "an empty page"


def test_profile() -> None:
    data = pellucid.profile(POINTS, frames=3, opacity=0.2, size=(128, 96), method="abuffer")
    figure = data.figure()
    assert_drawn(figure)
    bars, lists = figure.axes
    names = [label.get_text() for label in bars.get_yticklabels()]
    known = {one.name for frame in data.frames for one in frame.passes}
    assert "abuffer/count" in names
    assert set(names) - known <= {name for name in names if name.endswith(" others")}
    at = names.index("abuffer/count")
    times = [sum(one.gpu_ms for one in frame.passes if one.name == "abuffer/count") for frame in data.frames]
    assert bars.patches[at].get_width() == pytest.approx(np.median(times))
    pixels = sum(count for length, count in data.list_histogram if length > 0)
    assert sum(patch.get_height() for patch in lists.patches) == pixels
    assert f"{data.points:,} points" in figure.get_suptitle()


def test_tradeoff() -> None:
    data = pellucid.tradeoff(POINTS, quick=True, only=["abuffer", "weighted", "stochastic"], opacity=0.2, size=(96, 72))
    figure = data.figure()
    assert_drawn(figure)
    (axes,) = figure.axes
    drawn = {line.get_label(): line for line in axes.lines}
    for method in {row.method for row in data.rows}:
        rows = [row for row in data.rows if row.method == method]
        np.testing.assert_array_equal(drawn[method].get_xdata(), [row.gpu_ms for row in rows])
    weighted = next(row for row in data.rows if row.method == "weighted")
    assert weighted.rmse in drawn["weighted"].get_ydata()


def test_stress() -> None:
    data = pellucid.stress(sides=[16], layers=[1, 4, 16], methods=["abuffer", "sorted"], frames=1)
    figure = data.figure()
    assert_drawn(figure)
    workloads = list(dict.fromkeys(cell.workload for cell in data.cells))
    assert len(figure.axes) == 2 * len(workloads)
    line = next(line for line in figure.axes[0].lines if line.get_label() == "abuffer")
    own = sorted((cell.layers, cell.gpu_ms) for cell in data.cells if (cell.workload, cell.method) == (workloads[0], "abuffer"))
    np.testing.assert_array_equal(np.transpose([line.get_xdata(), line.get_ydata()]), own)


def test_check() -> None:
    cases = [
        pellucid.CheckCase("a/good", "", "pass", 0.5, 1.0, None),
        pellucid.CheckCase("a/bad", "", "fail", 3.0, 1.0, None),
        pellucid.CheckCase("b/exact", "", "pass", 0.0, 0.0, None),
        pellucid.CheckCase("b/lost", "", "fail", None, None, "the device was lost"),
        pellucid.CheckCase("c/none", "", "not applicable", None, None, "no such device"),
    ]
    data = pellucid.Check(device="d", driver="v", passed=2, failed=2, cases=tuple(cases), json={})
    figure = data.figure()
    assert_drawn(figure)
    (axes,) = figure.axes
    dots = axes.collections[0]
    shares, rows = dots.get_offsets().T
    assert list(shares[1:3]) == [0.5, 3.0]
    assert shares[0] < 1e-3
    assert shares[3] > 3.0, "a failure without numbers is one, too"
    assert list(rows) == [1, 0, 0, 1]
    assert [label.get_text() for label in axes.get_yticklabels()] == ["a (2)", "b (2)"]
    red = [tuple(color[:3]) == to_rgba("#d55e00")[:3] for color in dots.get_facecolors()]
    assert red == [False, False, True, True]
    assert [text.get_text() for text in axes.texts] == ["bound", "a/bad", "b/lost"]
    assert axes.get_title().startswith("2 passed, 2 failed, 1 not applicable")


def test_comparison() -> None:
    a = pellucid.render(POINTS, opacity=0.2, size=(64, 48), method="abuffer")
    b = pellucid.render(POINTS, opacity=0.2, size=(64, 48), method="weighted")
    data = pellucid.compare(a, b)
    figure = data.figure()
    assert_drawn(figure)
    shown = figure.axes[0].images[0].get_array()
    np.testing.assert_array_equal(shown, data.difference.max(axis=2))
    assert f"RMSE {data.rmse:.3g}" in figure.get_suptitle()
    assert figure.axes[0].lines[0].get_xydata().tolist() == [list(map(float, data.max_at))]
    assert_drawn(pellucid.compare(a, a).figure())
    upright = pellucid.compare(np.zeros((90, 30, 3)), np.ones((90, 30, 3))).figure()
    assert_drawn(upright)
    assert upright.get_figheight() > upright.get_figwidth()


def test_plan() -> None:
    data = pellucid.plan(POINTS, opacity=0.2)
    figure = data.figure()
    assert_drawn(figure)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts[0].startswith(data.method)
    on = [one.name for one in data.passes if one.on]
    assert texts[2 : 3 * len(on) : 3] == on
    assert texts.count("●") == len(on)
    # The others are grouped, and none is lost.
    off = texts[2 + 3 * len(on) :: 3]
    assert texts.count("○") == len(off) == len({one.reason for one in data.passes if not one.on})
    numbers = [re.search(r"\((\d+) passes\)$", text) for text in off]
    total = sum(text.count(",") + 1 if number is None else int(number[1]) for text, number in zip(off, numbers, strict=True))
    assert total == len(data.passes) - len(on)

"""Figures show the numbers of their results."""

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
        pellucid.CheckCase("good", "", "pass", 0.5, 1.0, None),
        pellucid.CheckCase("bad", "", "fail", 3.0, 1.0, None),
        pellucid.CheckCase("exact", "", "pass", 0.0, 1.0, None),
        pellucid.CheckCase("none", "", "not applicable", None, None, "no such device"),
    ]
    data = pellucid.Check(device="d", driver="v", passed=2, failed=1, cases=tuple(cases), json={})
    figure = data.figure()
    assert_drawn(figure)
    (axes,) = figure.axes
    shares = axes.collections[0].get_offsets()[:, 0]
    assert list(shares[1:]) == [0.5, 3.0]
    assert shares[0] < 0.5
    assert axes.collections[0].get_facecolors()[2] == pytest.approx(to_rgba("#d55e00"))
    assert "bad" in [text.get_text() for text in axes.texts]
    assert axes.get_title().startswith("2 passed, 1 failed, 1 not applicable")


def test_comparison() -> None:
    a = pellucid.render(POINTS, opacity=0.2, size=(64, 48), method="abuffer")
    b = pellucid.render(POINTS, opacity=0.2, size=(64, 48), method="weighted")
    data = pellucid.compare(a, b)
    figure = data.figure()
    assert_drawn(figure)
    shown = figure.axes[0].images[0].get_array()
    np.testing.assert_array_equal(shown, data.difference.max(axis=2))
    assert f"RMSE {data.rmse:.3g}" in figure.axes[0].get_title()
    assert figure.axes[0].lines[0].get_xydata().tolist() == [list(map(float, data.max_at))]
    assert_drawn(pellucid.compare(a, a).figure())


def test_plan() -> None:
    data = pellucid.plan(POINTS, opacity=0.2)
    figure = data.figure()
    assert_drawn(figure)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert texts[0].startswith(data.method)
    assert [text for text in texts if text in {one.name for one in data.passes}] == [one.name for one in data.passes]
    assert texts.count("●") == sum(one.on for one in data.passes)

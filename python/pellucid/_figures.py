"""Matplotlib figures of results. Each function takes a result and returns a figure that displays itself in a notebook."""

from __future__ import annotations

import io
import math
import textwrap
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure as _Figure
from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation

if TYPE_CHECKING:
    from . import Check, CheckCase, Comparison, Plan, PlanPass, Profile, Stress, Tradeoff

# Passes with a bar of their own; the others are one bar.
_MOST_PASSES = 16

# Told apart by people who see no red or no green, too: Okabe and Ito's colors, then those of Tol.
_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#332288", "#999933", "#882255", "#777777")
_MARKERS = "osD^vP*Xph"
# Errors of checks below this share of their bound are drawn as if they had it.
_LEAST_SHARE = 1e-6

# Inches of a line of text in a plan, and between rows.
_LINE, _GAP = 0.165, 0.07

_GREEN, _RED, _GREY = "#009e73", "#d55e00", "#8a8a8a"


class Figure(_Figure):
    """A figure that a notebook shows without `pyplot`, which would keep it alive."""

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        self.savefig(file, format="png", dpi=110)
        return file.getvalue()


def _axes(size: tuple[float, float], columns: int = 1, rows: int = 1, **given: Any) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=size, layout="constrained")
    made = figure.subplots(rows, columns, squeeze=False, **given)
    for axes in made.flat:
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=9)
    return figure, list(made.flat)


def _plain(value: float, _: object = None) -> str:
    """Format a number on an axis: 0.05, 3, 1 200."""
    return f"{value:,.12g}".replace(",", "\u2009") if 1e-4 <= abs(value) < 1e6 or value == 0 else f"{value:.0e}"


def _styles(names: Iterable[str]) -> Callable[[str], dict[str, Any]]:
    """Return a function that gives each name a color and a marker, in the order of the names."""
    places = {name: place for place, name in enumerate(dict.fromkeys(names))}
    return lambda name: {
        "color": _COLORS[places[name] % len(_COLORS)],
        "marker": _MARKERS[(places[name] + places[name] // len(_COLORS)) % len(_MARKERS)],
    }


def profile(data: Profile) -> Figure:
    """Draw the times of the passes of a frame, and the lengths of the lists of its pixels."""
    times: dict[str, list[float]] = {}
    for frame in data.frames:
        # A pass may stand in a frame several times.
        sums: dict[str, float] = {}
        for one in frame.passes:
            sums[one.name] = sums.get(one.name, 0.0) + one.gpu_ms
        for name, milliseconds in sums.items():
            times.setdefault(name, []).append(milliseconds)
    medians = {name: float(np.median(all)) for name, all in times.items()}
    shown = sorted(medians, key=lambda name: -medians[name])[:_MOST_PASSES]
    # In the order of the frame.
    bars = [(name, medians[name], times[name]) for name in medians if name in shown]
    rest = sum(all for name, all in medians.items() if name not in shown)
    if rest > 0:
        bars.append((f"{len(medians) - len(shown)} others", rest, [rest]))
    histogram = [(length, pixels) for length, pixels in data.list_histogram if length > 0 and pixels > 0]
    figure, axes = _axes((11 if histogram else 8, 1.6 + 0.3 * len(bars)), 2 if histogram else 1)
    _passes(axes[0], bars)
    if histogram:
        _lists(axes[1], histogram)
    figure.suptitle(
        f"{data.gpu_ms:.3g} ms on the device, {data.wall_ms:.3g} ms in all "
        f"(medians of {len(data.frames)}): {data.points:,} points, {data.pixels:,} pixels\n{data.device}",
        fontsize=10,
    )
    return figure


def _passes(axes: Axes, bars: list[tuple[str, float, list[float]]]) -> None:
    whole = sum(median for _, median, _ in bars) or 1.0
    places = np.arange(len(bars))
    spread = np.array([[median - min(all), max(all) - median] for _, median, all in bars]).T.reshape(2, len(bars))
    axes.barh(places, [median for _, median, _ in bars], color=_COLORS[0], xerr=np.maximum(spread, 0), ecolor=_GREY)
    for place, (_, median, all) in enumerate(bars):
        axes.annotate(
            f"{median / whole:.0%}", (max(all), place), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8
        )
    axes.set_yticks(places, [name for name, *_ in bars])
    axes.invert_yaxis()
    axes.set_xlabel("ms (median; lines from the least to the most)")
    axes.margins(x=0.1)
    axes.set_xlim(left=0)


def _lists(axes: Axes, histogram: list[tuple[int, int]]) -> None:
    """Draw pixels by the length of their lists, in bins of powers of √2: single lengths are ragged where they are few."""
    lengths = np.array([length for length, _ in histogram], dtype=float)
    pixels = np.array([count for _, count in histogram], dtype=float)
    edges = np.unique(np.round(np.sqrt(2.0) ** np.arange(0, 2 * math.log2(lengths.max()) + 3)))
    # One edge beyond the longest list is enough.
    edges = edges[: np.searchsorted(edges, lengths.max(), side="right") + 1]
    counts, edges = np.histogram(lengths, bins=edges, weights=pixels)
    axes.bar(edges[:-1], counts, width=np.diff(edges), align="edge", color=_COLORS[5], edgecolor="white", linewidth=0.5)
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_formatter(FuncFormatter(_plain))
    axes.yaxis.set_major_formatter(FuncFormatter(_plain))
    axes.set_xlabel("fragments in a pixel's list")
    axes.set_ylabel("pixels")


def tradeoff(data: Tradeoff) -> Figure:
    """Draw error over time of each method and setting, with the Pareto front."""
    figure, (axes,) = _axes((9, 5.6))
    errors = [row.rmse for row in data.rows if row.rmse > 0]
    # Exact ones lie on a line of their own below all others: a logarithm has no zero.
    least = min(errors, default=1e-3)
    floor = 10.0 ** (math.floor(math.log10(least)) - 1)
    style = _styles(row.method for row in data.rows)
    for method in dict.fromkeys(row.method for row in data.rows):
        rows = [row for row in data.rows if row.method == method]
        axes.plot(
            [row.gpu_ms for row in rows],
            [row.rmse or floor for row in rows],
            linestyle="",
            label=method,
            markersize=7,
            alpha=0.85,
            **style(method),
        )
    front = sorted((row for row in data.rows if row.front), key=lambda row: row.gpu_ms)
    axes.step(
        [row.gpu_ms for row in front],
        [row.rmse or floor for row in front],
        where="post",
        color="black",
        linewidth=1,
        zorder=0,
        label="front",
    )
    for row in front:
        if row.setting:
            at = (row.gpu_ms, row.rmse or floor)
            axes.annotate(row.setting.removeprefix("method."), at, xytext=(6, 5), textcoords="offset points", fontsize=7.5)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("device time of a frame, ms")
    axes.set_ylabel("RMSE of linear color")
    _plain_logarithm(axes.xaxis)
    if any(row.rmse == 0 for row in data.rows):
        axes.axhline(floor, color=_GREY, linewidth=0.8, linestyle=":")
        axes.set_ylim(bottom=floor / 1.6)
        plain = LogFormatterSciNotation()
        plain.set_axis(axes.yaxis)
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, at: "exact" if value < 1.5 * floor else plain(value, at)))
    figure.legend(loc="outside right upper", fontsize=8, frameon=False)
    axes.set_title(f"{data.points:,} points, {data.size[0]} × {data.size[1]} pixels\n{data.device}", fontsize=10)
    return figure


def _plain_logarithm(axis: Axis) -> None:
    """Put plain numbers at powers of ten, and at 2 and 5 between them; at all ticks if the axis has hardly a power of ten."""

    def between(value: float, _: object = None) -> str:
        low, high = axis.get_view_interval()
        digit = round(value / 10.0 ** math.floor(math.log10(value)))
        return _plain(value) if digit in (2, 5) or high < 10 * low else ""

    axis.set_major_formatter(FuncFormatter(_plain))
    axis.set_minor_formatter(FuncFormatter(between))
    axis.set_tick_params(which="minor", labelsize=8)


def stress(data: Stress) -> Figure:
    """Draw time and error of each method over the layers, a column for each workload, of the largest measured image."""
    workloads = list(dict.fromkeys(cell.workload for cell in data.cells))
    figure, axes = _axes((5.2 * max(len(workloads), 1) + 1.6, 7), max(len(workloads), 1), 2, sharex="col", sharey="row")
    style = _styles(cell.method for cell in data.cells)
    errors = [cell.rmse for cell in data.cells if cell.rmse > 0]
    floor = min(errors, default=1e-9)
    for column, workload in enumerate(workloads):
        side = max(cell.side for cell in data.cells if cell.workload == workload)
        cells = [cell for cell in data.cells if cell.workload == workload and cell.side == side]
        above, below = axes[column], axes[column + len(workloads)]
        for method in dict.fromkeys(cell.method for cell in cells):
            own = sorted((cell for cell in cells if cell.method == method), key=lambda cell: cell.layers)
            layers = [cell.layers for cell in own]
            line = {"linewidth": 1.2, "markersize": 4.5, **style(method)}
            label = method if column == 0 else None
            above.plot(layers, [cell.gpu_ms for cell in own], label=label, **line)
            below.plot(layers, [max(cell.rmse, floor) for cell in own], **line)
        above.set_title(f"{workload}, {side} × {side} pixels", fontsize=10)
        below.set_xlabel("layers in each pixel")
        for one in (above, below):
            one.set_xscale("log", base=2)
            one.set_yscale("log")
            one.grid(color="#e5e5e5", linewidth=0.6)
            one.xaxis.set_major_formatter(FuncFormatter(_plain))
        _plain_logarithm(above.yaxis)
    axes[0].set_ylabel("device time of a frame, ms")
    axes[max(len(workloads), 1)].set_ylabel("RMSE of linear color")
    figure.suptitle(data.device, fontsize=10)
    if data.cells:
        figure.legend(loc="outside right upper", fontsize=8, frameon=False)
    return figure


def check(data: Check) -> Figure:
    """Draw the error of each hard case as a share of its bound, a row for each method; cases right of the line fail."""
    cases = sorted((case for case in data.cases if case.verdict in ("pass", "fail")), key=_share)
    groups = dict.fromkeys(_group(case) for case in data.cases if case in cases)
    rows = {group: row for row, group in enumerate(groups)}
    ceiling = 10 * max([1.0, *(share for share in map(_share, cases) if share < math.inf)])
    drawn = [(min(max(_share(case), _LEAST_SHARE), ceiling), rows[_group(case)]) for case in cases]
    figure, (axes,) = _axes((8, 1.8 + 0.19 * len(rows)))
    colors = [_RED if case.verdict == "fail" else _COLORS[0] for case in cases]
    axes.scatter([x for x, _ in drawn], [y for _, y in drawn], s=16, color=colors, alpha=0.6, linewidth=0, clip_on=False)
    axes.axvline(1, color="black", linewidth=1)
    axes.annotate("bound", (1, 1), xycoords=("data", "axes fraction"), xytext=(3, 2), textcoords="offset points", fontsize=8)
    for case, at in zip(cases, drawn, strict=True):
        if case.verdict == "fail":
            axes.annotate(case.name, at, xytext=(6, 0), textcoords="offset points", va="center", fontsize=8, color=_RED)
    axes.set_xscale("log")
    axes.set_xlim(_LEAST_SHARE, 1.3 * ceiling)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_yticks(range(len(rows)), [f"{group} ({sum(_group(case) == group for case in cases)})" for group in groups])
    axes.tick_params(axis="y", length=0, labelsize=8)
    axes.grid(axis="y", color="#e5e5e5", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.set_xlabel("error as a share of its bound (at the left edge $10^{-6}$ and less, 0 as well)")
    skipped = sum(case.verdict not in ("pass", "fail") for case in data.cases)
    axes.set_title(f"{data.passed} passed, {data.failed} failed, {skipped} not applicable\n{data.device}", fontsize=10, pad=14)
    return figure


def _share(case: CheckCase) -> float:
    """Return the error as a share of its bound; infinite for failures without numbers."""
    if case.error is None or case.bound is None:
        return math.inf if case.verdict == "fail" else 0.0
    return case.error / case.bound if case.bound else math.inf if case.error else 0.0


def _group(case: CheckCase) -> str:
    return case.name.partition("/")[0]


def comparison(data: Comparison) -> Figure:
    """Draw where two images differ: the largest difference of each pixel over its channels, and its place."""
    largest = np.asarray(data.difference).max(axis=2)
    height, width = largest.shape
    wide = width >= height
    size = (6.0, 1.1 + 5.8 * height / width) if wide else (max(1.6 + 6 * width / height, 5.4), 6.8)
    figure, (axes,) = _axes(size)
    top = float(largest.max()) or 1.0
    drawn = axes.imshow(largest, cmap="magma", vmin=0, vmax=top, interpolation="nearest")
    if data.max_value > 0:
        axes.plot(*data.max_at, marker="o", markersize=11, fillstyle="none", color="#56b4e9", clip_on=False)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set(visible=True, color=_GREY, linewidth=0.5)
    # Along the longer side of the image, where its label has room: 0.1 inches off it, and as thick.
    if wide:
        tenth = 0.1 / (5.8 * height / width)
        bar, orientation = axes.inset_axes((0.0, -2 * tenth, 1.0, tenth)), "horizontal"
    else:
        tenth = 0.1 / (6 * width / height)
        bar, orientation = axes.inset_axes((1.0 + tenth, 0.0, tenth, 1.0)), "vertical"
    figure.colorbar(drawn, cax=bar, orientation=orientation, label="largest difference of R, G, B (linear)")
    psnr = "∞" if math.isinf(data.psnr) else f"{data.psnr:.1f} dB"
    figure.suptitle(
        f"RMSE {data.rmse:.3g}   PSNR {psnr}   SSIM {data.ssim:.4f}   FLIP {data.flip:.3g}\n"
        f"largest {data.max_value:.3g} at {data.max_at}, {data.above_1_255:.2%} of pixels above 1/255",
        fontsize=9,
    )
    return figure


def plan(data: Plan) -> Figure:
    """Draw the passes that run, in order, each with its reason; below them the others, a row for each reason."""
    rows = [(one.name, True, _reason(data, one)) for one in data.passes if one.on]
    off: dict[str, list[str]] = {}
    for one in data.passes:
        if not one.on:
            off.setdefault(_reason(data, one), []).append(one.name)
    rows += [(_names(names), False, reason) for reason, names in off.items()]
    wrapped = [(textwrap.fill(names, 46), on, textwrap.fill(reason, 92)) for names, on, reason in rows]
    heights = [_LINE * max(names.count("\n") + 1, reason.count("\n") + 1) + _GAP for names, _, reason in wrapped]
    title = textwrap.fill(f"{data.method}: {data.reason}", 120)
    top = 0.35 + 0.2 * (title.count("\n") + 1)
    height = top + sum(heights) + 0.1
    figure = Figure(figsize=(11, height))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(0, 11)
    axes.set_ylim(height, 0)
    axes.text(0.2, 0.15, title, fontsize=10, weight="bold", va="top")
    y = top
    for (names, on, reason), rise in zip(wrapped, heights, strict=True):
        color = "black" if on else _GREY
        axes.text(0.2, y, "●" if on else "○", fontsize=8, color=_GREEN if on else _GREY, va="top")
        axes.text(0.45, y, names, fontsize=8, family="monospace", color=color, va="top")
        axes.text(3.8, y, reason, fontsize=8, color=color, va="top")
        y += rise
    return figure


def _reason(data: Plan, one: PlanPass) -> str:
    """Return why a pass runs or not, without the reason for the method, which the title has."""
    return one.reason.removesuffix(f": {data.reason}").removeprefix(f"{data.reason}: ")


def _names(names: list[str]) -> str:
    """Return a few names, or the methods that many names belong to and their number."""
    if len(names) <= 3:
        return ", ".join(names)
    return ", ".join(dict.fromkeys(f"{name.partition('/')[0]}/…" for name in names)) + f" ({len(names)} passes)"

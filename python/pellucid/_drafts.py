"""Decide what a picture leaves out while things move in the window of `pellucid.view`.

Samples go first, then pixels and, where that is possible, points in the same proportion.
"""

from __future__ import annotations

from dataclasses import dataclass

# Columns and rows of the screen for one that is rendered.
_COARSE = (1, 2, 3, 4, 6, 8)

# Samples of a frame of unknown cost, and the least of any frame: below it, larger pixels show more.
_FEWEST = 4

# Where points stay, a picture may take so many times of what all pictures take alike: a coarser one would hardly be
# faster.
_ALIKE = 1.5

# Share of all work from which a picture at rest is the whole one.
_NEARLY_ALL = 0.5


@dataclass(frozen=True)
class Draft:
    """Part of the whole picture that is rendered."""

    # Samples, of methods that have some.
    samples: int | None
    # Columns and rows of the screen for one that is rendered.
    coarse: int

    def work(self, samples: int | None) -> float:
        """Return its share of the work of the picture with all samples."""
        share = 1.0 if self.samples is None or not samples else self.samples / samples
        return share / self.coarse**2

    def points(self, all: int) -> int | None:
        """Return the largest number of points to draw; None for all."""
        return None if self.coarse == 1 else max(all // self.coarse**2, 1)

    def size(self, size: tuple[int, int]) -> tuple[int, int]:
        """Return the width and height that are rendered for a picture of this size."""
        width, height = size
        return -(-width // self.coarse), -(-height // self.coarse)


class Costs:
    """Costs of two frames: the last one, and the last one with a very different share of the work, to find the fixed cost."""

    def __init__(self) -> None:
        self._last: tuple[float, float] | None = None
        self._other: tuple[float, float] | None = None

    def add(self, ms: float, work: float) -> None:
        """Add a frame's milliseconds and its share of the whole work."""
        if self._last is not None and _apart(work, self._last[1]):
            self._other = self._last
        self._last = (ms, work)

    def share(self, budget_ms: float, *, thins: bool = True) -> float | None:
        """Return the share of the work that should fit in a budget in milliseconds; None without any frame."""
        if self._last is None:
            return None
        ms, work = self._last
        if self._other is not None and _apart(work, self._other[1]):
            slope = (self._other[0] - ms) / (self._other[1] - work)
            alike = ms - slope * work
            if slope > 0 and alike > 0:
                return ((budget_ms if thins else max(budget_ms, _ALIKE * alike)) - alike) / slope
        return work * budget_ms / max(ms, 1e-9)


def _apart(a: float, b: float) -> bool:
    return a > 2 * b or b > 2 * a


def whole(samples: int | None) -> Draft:
    """Return the draft that leaves nothing out."""
    return Draft(samples, 1)


def moving(costs: Costs, budget_ms: float, samples: int | None, *, thins: bool = True) -> Draft:
    """Return the most accurate draft that should take no more than the budget; the coarsest if none does.

    `thins` is True if coarser pictures have fewer points.
    """
    share = costs.share(budget_ms, thins=thins)
    fewest = None if samples is None else min(samples, _FEWEST)
    if share is None:
        return Draft(fewest, 2)
    if samples is None or fewest is None:
        return Draft(None, _coarse(share))
    fitting = int(max(share, 0) * samples)
    if fitting >= fewest:
        return Draft(min(fitting, samples), 1)
    return Draft(fewest, _coarse(share * samples / fewest))


def resting(costs: Costs, budget_ms: float, samples: int | None, *, thins: bool = True) -> Draft:
    """Return the draft of `moving`, or the whole picture if half of its work would fit."""
    share = costs.share(budget_ms, thins=thins)
    if share is not None and share >= _NEARLY_ALL:
        return whole(samples)
    return moving(costs, budget_ms, samples, thins=thins)


def _coarse(share: float) -> int:
    return next((coarse for coarse in _COARSE if 1 / coarse**2 <= share), _COARSE[-1])

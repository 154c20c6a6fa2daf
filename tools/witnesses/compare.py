"""Two pictures by two programs: how far they are apart, and how far they may be."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Agreement:
    """What one witness says."""

    # What was drawn, and by which other program.
    what: str
    other: str
    values: int
    # The largest difference over what is allowed there; below 1 the two agree.
    share: float
    largest: float
    # What is allowed, in words.
    allowed: str

    @property
    def agrees(self) -> bool:
        """Whether no value is farther off than allowed. Nothing compared is no agreement, and neither is a NaN."""
        return self.values > 0 and self.share < 1.0


def compare(names: tuple[str, str], ours: np.ndarray, theirs: np.ndarray, allowed: np.ndarray | float, words: str) -> Agreement:
    """Compares all values of what was drawn by another program, its names. Infinite values must be so in both."""
    what, other = names
    if ours.shape != theirs.shape:
        raise ValueError(f"{what}: {ours.shape} values and {theirs.shape}")
    same = np.isinf(ours) & (ours == theirs)
    difference = np.where(same, 0.0, np.abs(np.where(same, 0.0, ours) - np.where(same, 0.0, theirs)))
    share = difference / np.broadcast_to(allowed, ours.shape)
    return Agreement(what, other, ours.size, _largest(share), _largest(difference), words)


def _largest(values: np.ndarray) -> float:
    """The largest value; a NaN counts as infinite."""
    return float(np.nan_to_num(values, nan=np.inf).max(initial=0.0))


def table(rows: list[Agreement]) -> str:
    """A Markdown table of what the witnesses say."""
    lines = ["| what | drawn by | values | largest difference | allowed | |", "|---|---|--:|--:|---|---|"]
    for row in rows:
        verdict = "agrees" if row.agrees else "**differs**"
        lines.append(f"| {row.what} | {row.other} | {row.values} | {row.largest:.1e} | {row.allowed} | {verdict} |")
    return "\n".join(lines)

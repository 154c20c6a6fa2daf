"""What the tests share: a device, small clouds, the command line."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import pellucid

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "tests" / "data"
SIZE = (64, 48)


def require(reason: str) -> None:
    """Skips a test, or fails it where everything must be there."""
    if os.environ.get("PELLUCID_REQUIRE_ALL") == "1" or os.environ.get("CI") == "true":
        pytest.fail(reason)
    pytest.skip(reason)


@pytest.fixture(scope="session")
def renderer() -> pellucid.Renderer:
    """The best device."""
    try:
        return pellucid.Renderer()
    except pellucid.DeviceError as error:
        if os.environ.get("PELLUCID_REQUIRE_GPU", "1") == "1":
            pytest.fail(str(error))
        pytest.skip(f"no device: {error}")


@pytest.fixture
def points() -> NDArray[np.float64]:
    """A ball of 500 points around the origin."""
    return np.random.default_rng(7).normal(size=(500, 3))


@pytest.fixture(scope="session")
def binary() -> Path:
    """The command line."""
    named = os.environ.get("PELLUCID_BINARY")
    candidates = [Path(named)] if named else [ROOT / "target" / kind / "pellucid" for kind in ("release", "debug")]
    for candidate in candidates:
        if candidate.exists():
            return candidate
    require("no binary: cargo build --release -p pellucid-cli, or name one in PELLUCID_BINARY")
    raise AssertionError


@pytest.fixture
def cli(binary: Path, tmp_path: Path):
    """Runs the command line in the test's folder, and gives what it prints."""

    def run(*arguments: str) -> str:
        done = subprocess.run([binary, *arguments], cwd=tmp_path, text=True, capture_output=True, timeout=300, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run

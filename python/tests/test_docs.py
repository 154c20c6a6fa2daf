"""The lines of docs/python.md run, one block after the other, and do what stands beside them."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

ROOT = Path(__file__).parents[2]


def test_python_in_five_minutes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/python.md").read_text(), re.MULTILINE | re.DOTALL)
    assert len(blocks) >= 8
    shutil.copy(ROOT / "tests/data/lidar/sample_c_2k.las", tmp_path / "scan.las")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)
    np.testing.assert_array_equal(imread(tmp_path / "scan.png"), imread(tmp_path / "same.png"))
    assert names["rgba"].shape == (480, 640, 4)
    assert names["srgb"].shape == (480, 640, 3)
    assert len(list(tmp_path.glob("turn-*.png"))) == 6
    assert {"cloud.png", "scene.png", "all.exr", "passes.png"} <= {path.name for path in tmp_path.iterdir()}

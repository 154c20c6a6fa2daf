"""The notebooks run from their first cell to their last one, say nothing on stderr, and show their pictures."""

import base64
import io
import os
from pathlib import Path

import nbformat
import numpy as np
import pytest
from matplotlib.image import imread
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).parents[1] / "notebooks"

# Pictures that a notebook shows.
PICTURES = {
    "forest_by_class.ipynb": 5,
    "into_a_building.ipynb": 5,
    "what_accuracy_costs.ipynb": 7,
    "own_method_against_exact.ipynb": 2,
}


def test_there_are_four() -> None:
    assert {path.name for path in NOTEBOOKS.glob("*.ipynb")} == set(PICTURES)


@pytest.mark.parametrize("name", PICTURES)
def test_notebook(name: str, tmp_path: Path) -> None:
    notebook = nbformat.read(NOTEBOOKS / name, as_version=4)
    nbformat.validate(notebook)
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": str(NOTEBOOKS)}}).execute()
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert [output.text for output in outputs if output.get("name") == "stderr"] == []
    pictures = [base64.b64decode(output.data["image/png"]) for output in outputs if "image/png" in output.get("data", {})]
    folder = Path(os.environ.get("PELLUCID_PICTURES", tmp_path))
    for at, picture in enumerate(pictures):
        (folder / f"{Path(name).stem}-{at}.png").write_bytes(picture)
        pixels = imread(io.BytesIO(picture))
        assert np.ptp(pixels[..., :3]) > 0.2, f"picture {at} is even"
    assert len(pictures) == PICTURES[name]

"""Run the notebooks and write them with their output.

    python python/tools/notebooks.py [NOTEBOOK…]

Pictures get a palette, so that the files stay small. If you run the notebooks yourself, they show all colors.
"""

from __future__ import annotations

import base64
import io
import sys
from pathlib import Path

import nbformat
import numpy as np
from nbclient import NotebookClient
from PIL import Image

NOTEBOOKS = Path(__file__).resolve().parents[1] / "notebooks"


def run(path: Path) -> None:
    """Run all cells in the notebook's folder."""
    notebook = nbformat.read(path, as_version=4)
    folder = {"metadata": {"path": str(path.parent)}}
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources=folder, record_timing=False).execute()
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "image/png" in data:
                data["image/png"] = base64.b64encode(with_palette(base64.b64decode(data["image/png"]))).decode()
    # The version of the kernel would change with each machine.
    notebook.metadata = {"kernelspec": notebook.metadata["kernelspec"], "language_info": {"name": "python"}}
    path.write_text(nbformat.writes(notebook) + "\n", encoding="utf-8")


def with_palette(png: bytes) -> bytes:
    """Return the same picture in 256 colors."""
    picture = Image.open(io.BytesIO(png)).convert("RGB")
    palette = picture.quantize(255, kmeans=2)
    indices = np.array(picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG))
    # The background stays what it is.
    _, background = max(picture.getcolors(picture.width * picture.height))
    indices[(np.asarray(picture) == background).all(axis=2)] = 255
    small = Image.fromarray(indices, mode="P")
    small.putpalette([*palette.getpalette()[: 3 * 255], *background])
    file = io.BytesIO()
    small.save(file, "PNG", optimize=True)
    return file.getvalue()


if __name__ == "__main__":
    for path in [Path(name) for name in sys.argv[1:]] or sorted(NOTEBOOKS.glob("*.ipynb")):
        print(path)
        run(path)

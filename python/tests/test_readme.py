"""The lines of README, and pictures of objects of other packages, against the files that the command line writes."""

from __future__ import annotations

import re
import shutil

import open3d
import pytest
import pyvista
from conftest import DATA, ROOT

import pellucid


def block(path):
    """The first block of Python of a page."""
    return re.search(r"```python\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL).group(1)


def test_the_lines_of_readme_write_the_file_of_the_command_line(renderer, cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(DATA / "lidar/sample_c_2k.las", "scan.laz")
    lines = block(ROOT / "README.md")
    assert len([line for line in lines.splitlines() if line.strip()]) <= 5
    exec(compile(lines, "README.md", "exec"), {})
    ours = (tmp_path / "out.png").read_bytes()
    page = (ROOT / "README.md").read_text("utf-8")
    (command,) = re.findall(r"^pellucid (render scan\.laz --see-through .* -o out\.png)$", page, re.M)
    cli(*command.split())
    assert (tmp_path / "out.png").read_bytes() == ours


def test_the_lines_of_the_package_run(renderer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(block(ROOT / "python" / "README.md"), "README.md", "exec"), {})
    assert (tmp_path / "cloud.png").stat().st_size > 1000


@pytest.mark.parametrize("suffix", [".png", ".exr"])
@pytest.mark.parametrize("read", [open3d.io.read_point_cloud, pyvista.read], ids=["open3d", "pyvista"])
def test_objects_of_other_packages_are_the_file(renderer, cli, tmp_path, monkeypatch, read, suffix):
    monkeypatch.chdir(tmp_path)
    # VTK has no double positions of PLY files.
    shutil.copy(DATA / ("models/turbine_blade_6k.ply" if read is pyvista.read else "indoor/livingroom_fragment_2k.ply"), "room.ply")
    accuracy = "8-bit" if suffix == ".png" else "exact"
    image = pellucid.render(read("room.ply"), opacity=0.4, size=(160, 120), accuracy=accuracy, name="room.ply")
    image.save(f"python{suffix}")
    cli("render", "room.ply", "--opacity", "0.4", "--size", "160x120", "-o", f"cli{suffix}")
    assert (tmp_path / f"python{suffix}").read_bytes() == (tmp_path / f"cli{suffix}").read_bytes()

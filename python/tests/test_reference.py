"""The API reference: every public name is explained, with all of its arguments."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

import pellucid


@pytest.fixture
def reference() -> ModuleType:
    path = Path(__file__).parents[1] / "reference.py"
    spec = importlib.util.spec_from_file_location("reference", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_public_name_is_explained(reference: ModuleType) -> None:
    assert reference.undocumented() == []


def test_what_is_not_explained_is_found(reference: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    class Plain:
        def method(self) -> None: ...

    def function(width: int, height: int) -> None:
        """Takes a width."""

    monkeypatch.setattr(pellucid, "__all__", ["Plain", "function"])
    monkeypatch.setattr(pellucid, "Plain", Plain, raising=False)
    monkeypatch.setattr(pellucid, "function", function, raising=False)
    assert reference.undocumented() == [
        "Plain has no docstring",
        "Plain.method has no docstring",
        "function: the docstring does not name the argument `height`",
    ]


def test_pages_are_built(reference: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", ["reference.py", str(tmp_path)])
    assert reference.main() == 0
    page = (tmp_path / "pellucid.html").read_text()
    assert all(f'id="{name}"' in page for name in ("render", "Camera", "Camera.orbit", "Scene", "profile"))

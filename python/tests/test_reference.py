"""The API reference: every public name is explained."""

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

import pellucid


@pytest.fixture
def reference() -> ModuleType:
    path = Path(__file__).parents[1] / "tools" / "reference.py"
    spec = importlib.util.spec_from_file_location("reference", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_public_name_is_explained(reference: ModuleType) -> None:
    assert reference.undocumented() == []


def test_members_without_an_explanation_are_found(
    reference: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    class Plain:
        """Explained."""

        length: int
        """Explained, too."""
        width: int
        _depth: int

        def method(self) -> None: ...

        @property
        def size(self) -> int:
            return 1

        def _own(self) -> None: ...

    def function() -> None: ...

    monkeypatch.setattr(pellucid, "__all__", ["Plain", "function", "render"])
    monkeypatch.setattr(pellucid, "Plain", Plain, raising=False)
    monkeypatch.setattr(pellucid, "function", function, raising=False)
    assert reference.undocumented() == ["Plain.method", "Plain.size", "Plain.width", "function"]
    assert reference.main() == 1
    assert "error: Plain.size has no docstring" in capsys.readouterr().err


def test_pages_are_built(reference: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The script goes to another folder, from which this brings back.
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["reference.py", str(tmp_path)])
    assert reference.main() == 0
    page = (tmp_path / "pellucid.html").read_text()
    assert "Full vertical angle in degrees" in page, "the docstring of a field"
    assert all(f'id="{name}"' in page for name in ("render", "Camera", "Camera.orbit", "Scene", "profile"))

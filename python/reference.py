"""Builds the API reference from docstrings, and fails where a public name has none.

    python python/reference.py [FOLDER]

FOLDER is target/python-reference by default. Made by pdoc: it needs no configuration and no theme, reads signatures and
docstrings as they are, and its pages work from disk.
"""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path
from typing import Any

import pdoc

import pellucid

ROOT = Path(__file__).parents[1]


def undocumented() -> list[str]:
    """What is missing: a docstring, or an argument in one."""
    found = []
    for name in sorted(pellucid.__all__):
        thing = getattr(pellucid, name)
        if inspect.isclass(thing):
            found += _of_class(name, thing)
        elif callable(thing):
            found += _of_call(name, thing, thing.__doc__)
    return found


def _of_class(name: str, kind: type) -> list[str]:
    found = [] if kind.__doc__ else [f"{name} has no docstring"]
    members = {member: value for member, value in vars(kind).items() if not member.startswith("_")}
    for member, value in members.items():
        full = f"{name}.{member}"
        if isinstance(value, property):
            found += [] if value.__doc__ else [f"{full} has no docstring"]
        elif callable(value) or isinstance(value, classmethod | staticmethod):
            bound = getattr(kind, member)
            found += _of_call(full, bound, bound.__doc__)
    own = vars(kind).get("__init__")
    # Attributes of plain data stand in the source with a comment; their names say most.
    if own is not None and not hasattr(kind, "__dataclass_fields__"):
        found += _of_call(f"{name}()", own, f"{kind.__doc__}\n{own.__doc__}")
    return found


def _of_call(name: str, call: Any, doc: str | None) -> list[str]:
    """What the docstring of something that is called lacks: one that points to another's arguments lacks none."""
    if not doc:
        return [f"{name} has no docstring"]
    try:
        parameters = inspect.signature(call).parameters.values()
    except ValueError:
        return [f"{name} has no signature"]
    if re.search(r"\b(as|those) of `", doc):
        return []
    named = [parameter.name for parameter in parameters if parameter.name != "self" and not parameter.name.startswith("_")]
    return [f"{name}: the docstring does not name the argument `{argument}`" for argument in named if not _names(doc, argument)]


def _names(doc: str | None, word: str) -> bool:
    """True if the text has the word, with or without stars or backticks."""
    return re.search(rf"(?<!\w){re.escape(word)}(?!\w)", doc or "") is not None


def main() -> int:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "target" / "python-reference"
    missing = undocumented()
    for line in missing:
        print(f"error: {line}", file=sys.stderr)
    if missing:
        return 1
    pdoc.render.configure(docformat="numpy", footer_text=f"pellucid {pellucid.__version__}", search=False)
    pdoc.pdoc("pellucid", output_directory=folder)
    print(f"{len(pellucid.__all__)} names documented: {folder / 'pellucid.html'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

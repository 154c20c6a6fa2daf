"""Build the API reference from docstrings, and fail if a public name has none.

    python python/tools/reference.py [FOLDER]

FOLDER is target/python-reference by default. The generator is pdoc: it needs no configuration and no theme, reads signatures and
docstrings as they are, and its pages work from disk.
"""

from __future__ import annotations

import inspect
import os
import sys
from pathlib import Path

import pdoc
from pdoc import doc_ast

import pellucid

ROOT = Path(__file__).resolve().parents[2]


def undocumented() -> list[str]:
    """Return the public names without a docstring."""
    found: list[str] = []
    for name in sorted(pellucid.__all__):
        thing = getattr(pellucid, name)
        if inspect.isclass(thing):
            found += _of_class(name, thing)
        elif callable(thing) and not thing.__doc__:
            found.append(name)
    return found


def _of_class(name: str, kind: type) -> list[str]:
    found = [] if kind.__doc__ else [name]
    for member, value in vars(kind).items():
        named = isinstance(value, property | classmethod | staticmethod) or callable(value)
        if named and not member.startswith("_") and not getattr(kind, member).__doc__:
            found.append(f"{name}.{member}")
    # Docstrings of fields stand below them, where only the source tells of them.
    fields = doc_ast.walk_tree(kind).var_docstrings
    found += [f"{name}.{field}" for field in inspect.get_annotations(kind) if not field.startswith("_") and field not in fields]
    return found


def main() -> int:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "target" / "python-reference"
    missing = undocumented()
    for name in missing:
        print(f"error: {name} has no docstring", file=sys.stderr)
    if missing:
        return 1
    # Where no folder `pellucid` could be meant instead.
    folder = folder.resolve()
    os.chdir(ROOT)
    # pdoc looks for what is loaded when it is asked for first.
    for name in pellucid.__all__:
        setattr(pellucid, name, getattr(pellucid, name))
    pdoc.render.configure(docformat="numpy", footer_text=f"pellucid {pellucid.__version__}", search=False)
    pdoc.pdoc("pellucid", output_directory=folder)
    print(f"{len(pellucid.__all__)} names documented: {folder / 'pellucid.html'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

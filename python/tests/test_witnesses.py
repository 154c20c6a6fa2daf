"""The comparer of tools/witnesses needs numpy, which this environment has."""

import sys

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools" / "witnesses"))

from test_compare import Compare  # noqa: F401

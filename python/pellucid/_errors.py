"""Exceptions and warnings of the package."""

from __future__ import annotations

import sys
from os.path import dirname


class Error(RuntimeError):
    """Something could not be done; the message says why, and what would help."""


class DeviceError(Error):
    """No Vulkan device was found, it lacks something, it failed, or its memory is too small.

    Where no driver is installed the message says what to install.
    """


class SceneError(Error, ValueError):
    """A key of a scene is unknown, its value is wrong, or keys contradict each other."""


class ReadError(Error, OSError):
    """A file is missing, damaged, or no point cloud."""


class PellucidWarning(UserWarning):
    """Something was done in another way than one might expect: points that were left out, settings without effect."""


def outside() -> int:
    """The ``stacklevel`` of the first caller that is not of this package, for `warnings.warn` in the function that calls."""
    here = dirname(__file__)
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and dirname(frame.f_code.co_filename) == here:
        level, frame = level + 1, frame.f_back
    return level


def tell(warned: list[str], noted: list[str]) -> None:
    """Hands on what work had to say: warnings, and notes for the logger ``pellucid``."""
    if warned:
        import warnings

        level = outside()
        for message in warned:
            warnings.warn(message, PellucidWarning, stacklevel=level)
    if noted:
        import logging

        for message in noted:
            logging.getLogger("pellucid").info(message)

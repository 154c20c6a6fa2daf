"""Exceptions and warnings of the package."""

from __future__ import annotations

import sys
from os.path import dirname


class Error(RuntimeError):
    """Something could not be done. The message says why, and what would help."""


class DeviceError(Error):
    """No Vulkan device was found, or the device lacks a feature, failed, or has too little memory.

    If no driver is installed, the message says what to install.
    """


class SceneError(Error, ValueError):
    """A key of a scene is unknown, its value is wrong, or keys contradict each other."""


class ReadError(Error, OSError):
    """A file is missing, damaged, or not a point cloud."""


class PellucidWarning(UserWarning):
    """The result differs from what you might expect: points were left out, or settings had no effect."""


def outside() -> int:
    """Return the ``stacklevel`` of the first caller outside this package, for `warnings.warn` in the calling function."""
    here = dirname(__file__)
    level, frame = 1, sys._getframe(1)
    while frame.f_back is not None and dirname(frame.f_code.co_filename) == here:
        level, frame = level + 1, frame.f_back
    return level


def tell(warned: list[str], noted: list[str]) -> None:
    """Pass on warnings, and notes for the logger ``pellucid``."""
    if warned:
        import warnings

        level = outside()
        for message in warned:
            warnings.warn(message, PellucidWarning, stacklevel=level)
    if noted:
        import logging

        for message in noted:
            logging.getLogger("pellucid").info(message)

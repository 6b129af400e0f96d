"""What several answers hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

Progress = Callable[[int, int], object]
"""Called with the parts (rows, poses) done and all parts, some times a second, in the calling thread."""


class Event(NamedTuple):
    """Something that happened at one time."""

    t: float
    """When (s)."""
    kind: str
    """A short fixed word: contact, lift_off, inconsistent, …"""
    detail: str
    """What happened, for people."""

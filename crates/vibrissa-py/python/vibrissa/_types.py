"""What several answers hold."""

from __future__ import annotations

from typing import NamedTuple


class Event(NamedTuple):
    """Something that happened at one time."""

    t: float
    """When (s)."""
    kind: str
    """A short fixed word: contact, lift_off, inconsistent, …"""
    detail: str
    """What happened, for people."""

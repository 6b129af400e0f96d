"""What can go wrong."""

from __future__ import annotations

import errno
from collections.abc import Iterable
from difflib import get_close_matches


class Error(Exception):
    """A fault in a file, a value or a call; the text names thing, value, allowed range and the next step."""

    file: str | None
    """The file at fault, where there is one."""
    line: int | None
    """The line at fault, counted from 1, where there is one."""

    def __init__(self, message: str, file: str | None = None, line: int | None = None) -> None:
        super().__init__(message)
        self.file = file
        self.line = line


class DataError(Error, ValueError):
    """The log, the map or another input is at fault (exit code 1 of the command)."""


class MissingFileError(DataError, FileNotFoundError):
    """A file that is not there; Python's own FileNotFoundError catches it, too."""

    def __new__(cls, message: str, file: str | None = None, line: int | None = None) -> MissingFileError:
        return FileNotFoundError.__new__(cls, message)

    def __init__(self, message: str, file: str | None = None, line: int | None = None) -> None:
        super().__init__(message, file, line)
        self.errno = errno.ENOENT
        self.filename = file

    def __str__(self) -> str:
        return str(self.args[0])


class UsageError(Error, ValueError):
    """The call is at fault (exit code 2 of the command)."""


def one_of(name: str, given: str, known: Iterable[str]) -> str:
    """The word given, which must be one of those known; of another the error tells which was meant."""
    words = list(known)
    if given in words:
        return given
    raise UsageError(f"{name}: {given!r} (allowed: {', '.join(words)}){meant(given, words)}")


def meant(given: object, known: Iterable[str]) -> str:
    """A line of help with the word that is most like the one given; empty where none is."""
    near = get_close_matches(given, list(known), n=1) if isinstance(given, str) else []
    return f"\n  help: did you mean {near[0]!r}?" if near else ""


class DataWarning(UserWarning):
    """Something looked wrong but could be used."""

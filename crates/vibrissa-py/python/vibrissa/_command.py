"""The command ``vibrissa``."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence

from . import _vibrissa


def run(args: Sequence[str | os.PathLike[str]]) -> int:
    """Runs ``vibrissa ARGS…`` within this process.

    What it prints goes to the process's standard output and error. Result files are as those of the command.

    Parameters
    ----------
    args : sequence of str or path
        The command's arguments, such as ``["demo", "--out", "demo"]``.

    Returns
    -------
    int
        The exit code: 0 done, 1 the data are at fault, 2 the call is.
    """
    _flush()
    return _vibrissa.run_command(["vibrissa", *(os.fspath(arg) for arg in args)])


def main() -> None:
    """The entry point of the command."""
    # Ctrl-C ends the command at once, as any other; half-written files keep their temporary names.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    _flush()
    sys.exit(_vibrissa.run_command_here(["vibrissa", *sys.argv[1:]]))


def _flush() -> None:
    sys.stdout.flush()
    sys.stderr.flush()


"""``python -m vibrissa`` is the command."""

from ._command import main

main()

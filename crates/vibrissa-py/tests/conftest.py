"""What several tests need: the command of this package, and one demo."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import vibrissa

Command = Callable[..., Any]


@pytest.fixture
def command() -> Command:
    """Runs ``vibrissa ARGS… --json`` in a process of its own and gives the parsed answer."""

    def run(*args: object) -> Any:
        words = [sys.executable, "-m", "vibrissa", *map(str, args), "--json"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="session")
def demo() -> vibrissa.Demo:
    return vibrissa.demo()


@pytest.fixture(scope="session")
def demo_files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files of the demo as the command writes them."""
    folder = tmp_path_factory.mktemp("demo")
    subprocess.run([sys.executable, "-m", "vibrissa", "demo", "--out", str(folder)], check=True, capture_output=True)
    return folder


def table(path: Path) -> dict[str, list[str]]:
    """A CSV file by columns."""
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def numbers(cells: list[str]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Cells as numbers; an empty one is NaN."""
    return np.array([float(cell) if cell else np.nan for cell in cells])

"""How answers show themselves: one line, a table in notebooks, pandas and matplotlib where they are installed."""

from __future__ import annotations

import base64
import html
import importlib
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

_LONGEST = 160


def _short(value: Any) -> str:
    """A value in a few characters: sizes of what is large."""
    if isinstance(value, np.ndarray):
        return f"array{value.shape}"
    if isinstance(value, np.floating | float):
        return f"{value:.6g}"
    if isinstance(value, str):
        return repr(value) if len(value) <= 24 else f"text of {len(value)}"
    if isinstance(value, tuple) and not hasattr(value, "_fields") and len(value) <= 6:
        return "(" + ", ".join(_short(one) for one in value) + ")"
    if isinstance(value, list | tuple | dict) and not hasattr(value, "_fields"):
        return f"{len(value)} of {type(next(iter(value))).__name__}" if value else "none"
    if is_dataclass(value):
        return f"<{type(value).__name__}>"
    return " ".join(repr(value).split())[:48]


class Shown:
    """A dataclass whose ``repr`` is one line with the sizes of its arrays, and a table in notebooks."""

    def _items(self) -> list[tuple[str, str]]:
        names = [one.name for one in fields(self) if not one.name.startswith("_")]  # type: ignore[arg-type]
        return [(name, _short(getattr(self, name))) for name in names]

    def __repr__(self) -> str:
        line = f"{type(self).__name__}({', '.join(f'{name}={value}' for name, value in self._items())})"
        return line if len(line) <= _LONGEST else line[: _LONGEST - 2] + "…)"

    def _repr_html_(self) -> str:
        row = "<tr><th style='text-align:left'>{}</th><td style='text-align:left'>{}</td></tr>"
        rows = "".join(row.format(html.escape(name), html.escape(value)) for name, value in self._items())
        table = f"<table><caption>{type(self).__name__}</caption>{rows}</table>"
        # Notebooks show HTML alone where there are both. As an image the figure keeps its names and styles to itself.
        figure = getattr(self, "_repr_svg_", lambda: None)()
        if figure is None:
            return table
        data = base64.b64encode(figure.encode()).decode()
        return f"<img alt='{type(self).__name__}' src='data:image/svg+xml;base64,{data}'>{table}"


def pandas() -> Any:
    """The module pandas."""
    return _wanted("pandas", "to_pandas()")


def axes(ax: Any) -> Any:
    """The axes to draw into: those given, or new ones of matplotlib."""
    if ax is not None:
        return ax
    new = _wanted("matplotlib.pyplot", "plot()").subplots()[1]
    # At equal scale a plot may become narrow: with few ticks their numbers stand apart.
    new.locator_params(axis="x", nbins=5)
    return new


def _wanted(name: str, user: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.split(".")[0]
        raise ImportError(f"{user} needs {package}: pip install {package}") from error


def draw_map(ax: Any, map: Any) -> None:
    """Draws a map's boundaries (m) at equal scale, with the bands in which they lie; what is not known of them is dotted."""
    bands, unknown = map.bands()
    for corners in bands:
        ax.fill(corners[:, 0], corners[:, 1], color="#e69f00", alpha=0.3, linewidth=0)
    for line in unknown:
        ax.plot(line[:, 0], line[:, 1], color="#e69f00", linestyle=":", linewidth=4.0)
    shapes = map.boundaries(1e-4)
    if any(role == "arena" for role, _ in shapes):
        # What is outside of the arena is solid, as in the figures of the command.
        ax.set_facecolor("#e3e3e0")
    fills = {"arena": "#ffffff", "obstacle": "#c9c9c4"}
    for role, points in sorted(shapes, key=lambda shape: list((*fills, "wall")).index(shape[0])):
        if role in fills:
            ax.fill(points[:, 0], points[:, 1], facecolor=fills[role], edgecolor="#222222", linewidth=1.4, zorder=0.5)
        else:
            ax.plot(points[:, 0], points[:, 1], color="#222222", linewidth=2.0)
    plane(ax)


def plane(ax: Any) -> None:
    """Equal scale, and the words of the axes."""
    ax.set_aspect("equal")
    ax.set_xlabel("x (m)")
    ax.set_ylabel("y (m)")


_UNITS = {
    "moment": "N m",
    "force": "N",
    "slope": "rad",
    "strip_lo": "m",
    "strip_hi": "m",
    "bx": "T",
    "by": "T",
    "bz": "T",
}


def _with_unit(column: str) -> str:
    unit = _UNITS.get(column.rsplit(".", 1)[-1])
    return f"{column} ({unit})" if unit else column


def draw_log(ax: Any, log: Any) -> None:
    """Draws a log's readings over time."""
    for name, values in log.readings.items():
        ax.plot(log.t, values, linewidth=1.0, label=_with_unit(name))
    ax.set_xlabel("t (s)")
    ax.legend()


def log_table(log: Any) -> str:
    """A log's columns with their ranges as HTML."""
    x, y, theta = log.odometry.reshape(-1, 3).T
    columns = {"t (s)": log.t, "x (m)": x, "y (m)": y, "theta (rad)": theta}
    columns |= {_with_unit(name): values for name, values in log.readings.items()}
    if log.heading is not None:
        columns["heading (rad)"] = log.heading
    left = "style='text-align:left'"
    head = f"<tr><th {left}>column</th><th>least</th><th>largest</th></tr>"

    def row(name: str, values: Any) -> str:
        known = values[np.isfinite(values)]
        ends = (known.min(), known.max()) if known.size else (np.nan, np.nan)
        return f"<tr><th {left}>{html.escape(name)}</th>" + "".join(f"<td>{end:.6g}</td>" for end in ends) + "</tr>"

    rows = "".join(row(name, values) for name, values in columns.items())
    return f"<table><caption>SensorLog, {len(log)} rows</caption>{head}{rows}</table>"


def log_frame(log: Any) -> Any:
    """A log's columns as a ``pandas.DataFrame``."""
    x, y, theta = log.odometry.reshape(-1, 3).T
    columns = {"t": log.t, "x": x, "y": y, "theta": theta, **log.readings}
    if log.heading is not None:
        columns["heading"] = log.heading
    return pandas().DataFrame(columns)

"""The report's pictures: SVG from plain numbers."""

import math
from html import escape

COLORS = ["#1f5fa8", "#b3541e", "#3a7d44", "#7a4a9e"]


def decades(values):
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


def number(x):
    """A number of an axis: thousands apart, no powers of ten."""
    return f"{x:,.0f}" if abs(x) >= 1000 else f"{x:g}"


def opened(width, height, title):
    return [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
            f'<rect width="{width}" height="{height}" fill="white"/>', f'<text x="14" y="24" font-size="15">{escape(title)}</text>']


def dots(benches, title, shown):
    """Every bench as a dot on a logarithmic axis of time: the least, with a bar to the median."""
    left, width, step, top = 560, 520, 17, 66
    low, high = decades([t for median, least, _ in benches.values() for t in (median, least)])
    place = lambda t: left + width * (math.log10(t) - low) / (high - low)
    height = top + step * len(benches) + 20
    svg = opened(left + width + 60, height, f"{title}: the least of all batches, with a bar to the median")
    for decade in range(low, high + 1):
        x = place(10.0**decade)
        svg.append(f'<line x1="{x:.1f}" y1="{top - 12}" x2="{x:.1f}" y2="{height - 14}" stroke="#ddd"/>')
        svg.append(f'<text x="{x:.1f}" y="{top - 18}" text-anchor="middle">{shown(10.0**decade)}</text>')
    for index, (name, (median, least, _)) in enumerate(benches.items()):
        y = top + step * index
        label = name if len(name) < 88 else name[:86] + "…"
        color = "#888" if "baseline" in name else COLORS[0]
        svg.append(f'<text x="{left - 12}" y="{y + 4}" text-anchor="end" font-size="11">{escape(label)}</text>')
        svg.append(f'<line x1="{place(least):.1f}" y1="{y}" x2="{place(median):.1f}" y2="{y}" stroke="{color}" stroke-width="2"/>')
        svg.append(f'<circle cx="{place(least):.1f}" cy="{y}" r="3.5" fill="{color}"/>')
    return "\n".join(svg + ["</svg>"]) + "\n"


def scaling(series, title, axis, shown, measured=" (least processor time)"):
    """Time, or what else is measured, by size, both logarithmic, a line for each series."""
    left, top, width, height = 90, 60, 560, 340
    xs = sorted({x for points in series.values() for x, _ in points})
    low, high = decades([t for points in series.values() for _, t in points])
    span = max(math.log10(xs[-1] / xs[0]), 1e-9)
    across = lambda x: left + width * math.log10(x / xs[0]) / span
    up = lambda t: top + height * (high - math.log10(t)) / (high - low)
    svg = opened(left + width + 40, top + height + 60 + 20 * len(series), f"{title}{measured}")
    for decade in range(low, high + 1):
        y = up(10.0**decade)
        svg.append(f'<line x1="{left}" y1="{y:.1f}" x2="{left + width}" y2="{y:.1f}" stroke="#ddd"/>')
        svg.append(f'<text x="{left - 8}" y="{y + 4:.1f}" text-anchor="end">{shown(10.0**decade)}</text>')
    last = -math.inf
    for x in xs:
        svg.append(f'<line x1="{across(x):.1f}" y1="{top + height}" x2="{across(x):.1f}" y2="{top + height + 5}" stroke="#888"/>')
        if across(x) - last > 34:
            svg.append(f'<text x="{across(x):.1f}" y="{top + height + 19}" text-anchor="middle">{number(x)}</text>')
            last = across(x)
    svg.append(f'<text x="{left + width / 2}" y="{top + height + 38}" text-anchor="middle">{escape(axis)}</text>')
    for k, (name, points) in enumerate(series.items()):
        color, y = COLORS[k % len(COLORS)], top + height + 62 + 20 * k
        line = " ".join(f"{across(x):.1f},{up(t):.1f}" for x, t in sorted(points))
        svg.append(f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="2"/>')
        svg += [f'<circle cx="{across(x):.1f}" cy="{up(t):.1f}" r="3.5" fill="{color}"/>' for x, t in points]
        svg.append(f'<line x1="{left}" y1="{y - 4}" x2="{left + 24}" y2="{y - 4}" stroke="{color}" stroke-width="2"/>')
        svg.append(f'<text x="{left + 32}" y="{y}">{escape(name)}</text>')
    return "\n".join(svg + ["</svg>"]) + "\n"

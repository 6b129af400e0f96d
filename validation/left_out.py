"""Prints the table of distances that were found without their own distance, from `vibrissa calibrate --json`.

Usage: left_out.py WHAT BASELINE, the JSON on standard input. The last line holds the headline figures.
"""

import json
import math
import sys


def figures(contacts):
    errors = [1e3 * abs(c["found"] - c["truth"]) for c in contacts if c["found"] is not None]
    if not errors:
        return None
    return (sum(errors) / len(errors), math.sqrt(sum(e * e for e in errors) / len(errors)), max(errors))


def main():
    what, baseline = sys.argv[1:3]
    text = sys.stdin.read()
    if not text:
        sys.exit("the calibration failed; run the command by hand for its message")
    result = json.loads(text)
    model, contacts = result["distance"], result["report"]["contacts"]
    if not contacts:
        print("skipped: too few distances to leave one out")
        return
    groups = {}
    for contact in contacts:
        near = [d for d in groups if abs(d - contact["truth"]) < 1e-3]
        groups.setdefault(near[0] if near else contact["truth"], []).append(contact)
    print(f"fit to all: tip ratio {model['tip_ratio']:.4f}, EI/k_base {1e3 * model['base_compliance']:.2f} mm, "
          f"scatter of a slope {100 * model['scatter']:.2f} %")
    print(f"{'distance':>10} {what:>7} {'bias':>9} {'mean':>9} {'RMS':>9} {'largest':>9}")
    for distance in sorted(groups):
        group = groups[distance]
        own = [1e3 * (c["found"] - c["truth"]) for c in group if c["found"] is not None]
        numbers = figures(group)
        if numbers is None:
            print(f"{1e3 * distance:>7.2f} mm {len(group):>7}  none fits a distance on the shaft")
            continue
        cells = " ".join(f"{v:>6.2f} mm" for v in (sum(own) / len(own), *numbers))
        print(f"{1e3 * distance:>7.2f} mm {len(group):>7} {cells}")
    lost = sum(c["found"] is None for c in contacts)
    numbers = figures(contacts)
    if numbers is None:
        sys.exit("no contact fits a distance on the shaft")
    mean, rms, worst = numbers
    print(f"to beat: {baseline}")
    print(f"leave one distance out, {len(contacts)} {what} at {len(groups)} distances ({lost} without answer): "
          f"mean {mean:.2f} mm, RMS {rms:.2f} mm, largest {worst:.2f} mm")


main()

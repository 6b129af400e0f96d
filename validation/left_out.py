"""Prints tables of distances that were found without their own distance, from `vibrissa calibrate --json`.

Usage: left_out.py WHAT BASELINE; one JSON object or several on standard input. The last line holds the headline figures.
"""

import json
import math
import sys


def results(text):
    """The JSON objects in the text."""
    decoder, place = json.JSONDecoder(), 0
    while text[place:].strip():
        place += len(text[place:]) - len(text[place:].lstrip())
        value, place = decoder.raw_decode(text, place)
        yield value


def figures(contacts):
    """Mean, RMS and largest error (mm); None where no contact has an answer."""
    errors = [1e3 * abs(c["found"] - c["truth"]) for c in contacts if c["found"] is not None]
    if not errors:
        return None
    return (sum(errors) / len(errors), math.sqrt(sum(e * e for e in errors) / len(errors)), max(errors))


def groups(contacts):
    """The contacts by distance; those within a millimetre are one."""
    found = {}
    for contact in contacts:
        near = [d for d in found if abs(d - contact["truth"]) < 1e-3]
        found.setdefault(near[0] if near else contact["truth"], []).append(contact)
    return dict(sorted(found.items()))


def table(result, what):
    model, contacts = result["distance"], result["report"]["contacts"]
    names = [source["file"] for source in result["data"]]
    print(", ".join(names) if len(names) < 3 else f"{len(names)} recordings, {names[0]} to {names[-1]}")
    print(f"fit to all: tip ratio {model['tip_ratio']:.4f}, EI/k_base {1e3 * model['base_compliance']:.2f} mm, "
          f"scatter of a slope {100 * model['scatter']:.2f} %")
    if not contacts:
        known = ", ".join(f"{1e3 * source['distance']:.1f}" for source in result["data"] if source["distance"])
        print(f"too few distances to leave one out{': ' + known + ' mm' if known else ''}")
        return
    print(f"{'distance':>10} {what:>7} {'bias':>9} {'mean':>9} {'RMS':>9} {'largest':>9}")
    for distance, group in groups(contacts).items():
        numbers = figures(group)
        if numbers is None:
            print(f"{1e3 * distance:>7.2f} mm {len(group):>7}  none fits a distance on the shaft")
            continue
        own = [1e3 * (c["found"] - c["truth"]) for c in group if c["found"] is not None]
        cells = " ".join(f"{v:>6.2f} mm" for v in (sum(own) / len(own), *numbers))
        print(f"{1e3 * distance:>7.2f} mm {len(group):>7} {cells}")


def main():
    what, baseline = sys.argv[1:3]
    contacts, distances = [], 0
    for result in results(sys.stdin.read()):
        table(result, what)
        if result["report"]["contacts"]:
            contacts += result["report"]["contacts"]
            distances += len(groups(result["report"]["contacts"]))
    numbers = figures(contacts)
    print(f"to beat: {baseline}")
    if numbers is None:
        print(f"leave one distance out, 0 {what} at 0 distances: no recording had enough distances to leave one out")
        return
    lost = sum(c["found"] is None for c in contacts)
    mean, rms, worst = numbers
    print(f"leave one distance out, {len(contacts)} {what} at {distances} distances ({lost} without answer): "
          f"mean {mean:.2f} mm, RMS {rms:.2f} mm, largest {worst:.2f} mm")


main()

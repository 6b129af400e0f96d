"""Reads a recording of ours by independent readers and holds it against the text files beside it.

Usage: read_back.py FOLDER: a folder written by `vibrissa simulate --mcap --out` and `vibrissa localize --mcap --out`.
"""

import collections
import csv
import math
import sys
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_JAZZY)
failures = 0


def check(what, worst, allowed):
    global failures
    failures += not worst <= allowed
    print(f"  {what:<58} {worst:10.3g}  (allowed {allowed:g})  {'ok' if worst <= allowed else 'FAILED'}")


def by_mcap(path):
    """Messages by the definitions that the file itself carries."""
    found = collections.defaultdict(list)
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            found[channel.topic].append((schema.name, message.log_time, bytes(message.data), decoded))
    return found


def by_rosbags(path, found):
    """The same bytes by the definitions that rosbags knows; how many messages disagree."""
    wrong = 0
    for topic, messages in found.items():
        for kind, _, data, decoded in messages:
            message = store.deserialize_cdr(data, kind)
            wrong += bytes(store.serialize_cdr(message, kind)) != data and kind != "visualization_msgs/msg/MarkerArray"
            wrong += hasattr(decoded, "header") and decoded.header.stamp.sec != message.header.stamp.sec
    return wrong


def seconds(message):
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


def heading(q):
    return 2 * math.atan2(q.z, q.w)


def around(a):
    return abs(math.remainder(a, math.tau))


def tum(path):
    rows = [list(map(float, line.split())) for line in open(path) if not line.startswith("#")]
    return {round(r[0] * 1e6): (r[1], r[2], 2 * math.atan2(r[6], r[7])) for r in rows}


def against_tum(what, messages, path, pose):
    truth = tum(path)
    worst = 0
    for _, _, _, m in messages:
        x, y, theta = truth[round(seconds(m) * 1e6)]
        p = pose(m)
        worst = max(worst, abs(p.position.x - x), abs(p.position.y - y), around(heading(p.orientation) - theta))
    check(f"{what}: {len(messages)} poses against {path.name} (m, rad)", worst, 2e-9)


def log(folder):
    found = by_mcap(folder / "log.mcap")
    print(f"log.mcap: {(folder / 'log.mcap').stat().st_size} bytes, " + ", ".join(f"{t} {len(m)}" for t, m in found.items()))
    check("messages that rosbags reads otherwise", by_rosbags(folder / "log.mcap", found), 0)
    rows = list(csv.DictReader(open(folder / "log.csv")))
    check("rows without odometry", abs(len(rows) - len(found["/odom"])), 0)
    worst = 0
    for row, (_, _, _, m) in zip(rows, found["/odom"]):
        p = m.pose.pose
        worst = max(worst, abs(seconds(m) - float(row["t"])), abs(p.position.x - float(row["x"])))
        worst = max(worst, abs(p.position.y - float(row["y"])), around(heading(p.orientation) - float(row["theta"])))
    check("/odom against log.csv (s, m, rad)", worst, 1e-9)
    for column in [c for c in rows[0] if c.endswith("moment")]:
        topic = "/whisker/" + column.replace(".moment", "/wrench") if "." in column else "/whisker/wrench"
        pairs = zip(rows, found[topic])
        check(f"{topic} against log.csv (N m)", max(abs(m[3].wrench.torque.z - float(r[column])) for r, m in pairs), 0)
    against_tum("/truth", found["/truth"], folder / "truth.tum", lambda m: m.pose)


def localization(folder):
    found = by_mcap(folder / "localization.mcap")
    size = (folder / "localization.mcap").stat().st_size
    print(f"localization.mcap: {size} bytes, " + ", ".join(f"{t} {len(m)}" for t, m in found.items()))
    check("messages that rosbags reads otherwise", by_rosbags(folder / "localization.mcap", found), 0)
    against_tum("/vibrissa/pose", found["/vibrissa/pose"], folder / "trajectory.tum", lambda m: m.pose.pose)
    against_tum("/vibrissa/robot", found["/vibrissa/robot"], folder / "trajectory.tum", lambda m: m.pose)
    grid = found["/map"][0][3]
    check("/map: cells that are missing", abs(grid.info.width * grid.info.height - len(grid.data)), 0)
    sizes = [m.width for _, _, _, m in found["/vibrissa/states"]]
    print(f"  the state set's points: first {sizes[0]}, last {sizes[-1]}, at {len(sizes)} times")
    check("the set shrinks: last over first", sizes[-1] / max(sizes[0], 1), 0.2)


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    log(folder)
    localization(folder)
    sys.exit(failures > 0)

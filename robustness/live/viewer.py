#!/usr/bin/env python3
"""The socket of `vibrissa live --view` against clients that are not ours: `websockets` for the protocol, `rosbags` for the messages.

Usage: robustness/live/viewer.py VIBRISSA

Runs `vibrissa live --demo --view`, subscribes to every channel as the Foxglove app does, decodes binary messages by the schemas that the
server tells, and checks what docs/live.md says of the JSON topics. Skips where the packages are missing.
"""

import asyncio
import json
import math
import socket
import struct
import subprocess
import sys
import tempfile

try:
    import websockets
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore
except ImportError:
    print("SKIPPED: pip install websockets rosbags, so the socket was NOT checked with clients that are not ours")
    sys.exit(0)

CDR = {"/vibrissa/pose", "/vibrissa/states", "/vibrissa/lines"}
JSON = {"/vibrissa/estimate", "/vibrissa/whiskers", "/vibrissa/readings", "/vibrissa/health"}


def need(condition, words):
    if not condition:
        raise SystemExit(f"FAILED: {words}")


def decoder(channel):
    """Reads messages of a channel by the schema that the server told."""
    if channel["encoding"] == "json":
        return lambda body: json.loads(body)
    store = get_typestore(Stores.EMPTY)
    name = channel["schemaName"]
    # The definition of the message itself, then those that it needs, each behind a line "MSG: ".
    first, *others = channel["schema"].split("=" * 80 + "\n")
    types = get_types_from_msg(first, name)
    for part in others:
        head, text = part.split("\n", 1)
        other = head.removeprefix("MSG: ").strip()
        types.update(get_types_from_msg(text, other if "/msg/" in other else other.replace("/", "/msg/")))
    store.register(types)
    return lambda body: store.deserialize_cdr(body, name)


async def look(port, seconds):
    """Everything that is told in so many seconds, by topic."""
    heard = {}
    for protocol in ("foxglove.sdk.v1", "foxglove.websocket.v1"):
        async with websockets.connect(f"ws://127.0.0.1:{port}", subprotocols=[protocol], max_size=None) as ws:
            need(ws.subprotocol == protocol, f"{protocol} was asked for, {ws.subprotocol} answered")
            info = json.loads(await ws.recv())
            need(info["op"] == "serverInfo" and isinstance(info["capabilities"], list), f"greeting {info}")
            channels = json.loads(await ws.recv())["channels"]
            need({c["topic"] for c in channels} == CDR | JSON, f"topics {[c['topic'] for c in channels]}")
            by_id = {10 + c["id"]: (c["topic"], decoder(c)) for c in channels}
            await ws.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 10 + c["id"], "channelId": c["id"]} for c in channels]}))
            loop = asyncio.get_running_loop()
            end = loop.time() + seconds
            while loop.time() < end:
                try:
                    data = await asyncio.wait_for(ws.recv(), end - loop.time())
                except (asyncio.TimeoutError, TimeoutError):
                    break
                kind, subscription, time = struct.unpack_from("<BIQ", data)
                need(kind == 1, f"a message of the kind {kind}")
                topic, read = by_id[subscription]
                heard.setdefault(topic, []).append((time * 1e-9, read(data[13:])))
    return heard


def segments(markers):
    for marker in markers.markers:
        points = [(p.x, p.y) for p in marker.points]
        yield from zip(points, points[1:]) if marker.type == 4 else zip(points[::2], points[1::2])


def distance(p, a, b):
    (ax, ay), (bx, by) = a, b
    dx, dy = bx - ax, by - ay
    share = max(0.0, min(1.0, ((p[0] - ax) * dx + (p[1] - ay) * dy) / max(dx * dx + dy * dy, 1e-18)))
    return math.hypot(p[0] - ax - share * dx, p[1] - ay - share * dy)


def check(heard):
    for topic in CDR | JSON:
        need(heard.get(topic), f"nothing on {topic}")
    walls = list(segments(heard["/vibrissa/lines"][0][1]))
    bent, worst, misfit = 0, 0.0, 0.0
    for t, message in heard["/vibrissa/whiskers"]:
        need(abs(t - message["t"]) < 1e-6 and message["carried"] >= 0, f"times {t} {message['t']}")
        (whisker,) = message["whiskers"]
        shape = whisker["shape"]
        need(whisker["name"] == "w0" and shape[0] == [0, 0] and whisker["from"] in ("map", "reading", "rest"), f"whisker {whisker}")
        need(len(shape) in (2, 25), f"{len(shape)} points")
        long = sum(math.dist(a, b) for a, b in zip(shape, shape[1:]))
        need(abs(long - whisker["length"]) < 1e-4, f"the whisker is {long} m long")
        (reading,) = whisker["readings"]
        need(reading["column"].endswith("moment") and reading["unit"] == "N m" and reading["bound"] > 0, f"reading {reading}")
        if whisker["from"] != "map":
            continue
        bent += 1
        pose = message["pose"]
        c, s = math.cos(pose["theta"]), math.sin(pose["theta"])
        x, y = whisker["contact"]
        place = (pose["x"] + c * x - s * y, pose["y"] + s * x + c * y)
        worst = max(worst, min(distance(place, *wall) for wall in walls))
        misfit = max(misfit, abs(reading["expected"] - reading["value"]) - reading["bound"]) if message["carried"] == 0 else misfit
    need(bent > 20, f"{bent} bent whiskers")
    need(worst < 2e-4, f"contacts are up to {worst} m from the map's lines")
    times = [t for _, message in heard["/vibrissa/readings"] for t in message["t"]]
    for _, message in heard["/vibrissa/readings"]:
        need(len(message["columns"]) == len(message["units"]) == len(message["values"]), "columns of readings")
        need(all(len(values) == len(message["t"]) for values in message["values"]), "lengths of readings")
    steps = [b - a for a, b in zip(times, times[1:])]
    need(all(step > 0 for step in steps), "readings come twice or out of order")
    # Two viewers one after the other: one gap between them.
    need(sum(step > 0.1 for step in steps) <= 2, "readings are missing")
    _, health = heard["/vibrissa/health"][-1]
    for key in ("rows", "merged", "missing", "not_recorded", "latency_p99", "estimate_p99", "sources"):
        need(key in health, f"health has no {key}")
    need([source["name"] for source in health["sources"]] == ["whisker", "base"], f"sources {health['sources']}")
    for (_, pose), (_, estimate) in zip(heard["/vibrissa/pose"], heard["/vibrissa/estimate"]):
        need(pose.header.frame_id == "map" and len(pose.pose.covariance) == 36, "the pose's header")
    print(
        f"ok: {', '.join(f'{len(messages)} {topic}' for topic, messages in sorted(heard.items()))}; {len(times)} readings; "
        f"{bent} bent whiskers, contacts at most {1e3 * worst:.3f} mm from the map's lines, expected moments at most "
        f"{1e6 * max(misfit, 0.0):.1f} uN m beyond the readings' bounds"
    )


def main(program):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.Popen([program, "live", "--demo", "--view", str(port), "--out", folder], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            # From the first touch on.
            asyncio.run(asyncio.sleep(3.0))
            heard = asyncio.run(look(port, 3.5))
        finally:
            run.kill()
            run.wait()
    check(heard)


if len(sys.argv) != 2:
    sys.exit(__doc__)
main(sys.argv[1])

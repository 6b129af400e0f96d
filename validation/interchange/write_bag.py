"""Writes recordings by independent tools: messages by rosbags, containers by rosbags and mcap.

Usage: write_bag.py LOG.csv OUT.mcap [none|lz4|zstd|rosbags]

The log's columns are t,x,y,theta and moment, NAME.moment or NAME.bx,by,bz. Odometry goes out at half the rate of the
readings and half a period late, as on a real robot.
"""

import csv
import math
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Bag
from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores.ROS2_JAZZY)
T = store.types
EPOCH = 1_700_000_000


def stamp(t):
    ns = round(t * 1e9)
    return T["builtin_interfaces/msg/Time"](sec=EPOCH + ns // 10**9, nanosec=ns % 10**9)


def header(t, frame):
    return T["std_msgs/msg/Header"](stamp=stamp(t), frame_id=frame)


def vector(x, y, z):
    return T["geometry_msgs/msg/Vector3"](x=x, y=y, z=z)


def odometry(t, x, y, theta):
    pose = T["geometry_msgs/msg/Pose"](
        position=T["geometry_msgs/msg/Point"](x=x, y=y, z=0.0),
        orientation=T["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=math.sin(theta / 2), w=math.cos(theta / 2)),
    )
    twist = T["geometry_msgs/msg/Twist"](linear=vector(0.0, 0.0, 0.0), angular=vector(0.0, 0.0, 0.0))
    zeros = np.zeros(36)
    return T["nav_msgs/msg/Odometry"](
        header=header(t, "odom"),
        child_frame_id="base_link",
        pose=T["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=zeros),
        twist=T["geometry_msgs/msg/TwistWithCovariance"](twist=twist, covariance=zeros),
    )


def wrench(t, moment):
    wrench = T["geometry_msgs/msg/Wrench"](force=vector(0.0, 0.0, 0.0), torque=vector(0.0, 0.0, moment))
    return T["geometry_msgs/msg/WrenchStamped"](header=header(t, "whisker_base"), wrench=wrench)


def field(t, b):
    return T["sensor_msgs/msg/MagneticField"](
        header=header(t, "chip"), magnetic_field=vector(*b), magnetic_field_covariance=np.zeros(9)
    )


def messages(path):
    rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(open(path))]
    names = [c for c in rows[0] if c.split(".")[-1] in ("moment", "bx")]
    for i, row in enumerate(rows):
        for name in names:
            whisker, _, word = name.rpartition(".")
            base = f"/whisker/{whisker}" if whisker else "/whisker"
            if word == "moment":
                yield row["t"], base + "/wrench", wrench(row["t"], row[name])
            else:
                axes = [row[(whisker + "." if whisker else "") + a] for a in ("bx", "by", "bz")]
                yield row["t"], base + "/magnetic_field", field(row["t"], axes)
        if i % 2 == 0 or i == len(rows) - 1:
            yield row["t"], "/odom", odometry(row["t"], row["x"], row["y"], row["theta"])


def by_mcap(log, out, compression):
    kinds = {"none": CompressionType.NONE, "lz4": CompressionType.LZ4, "zstd": CompressionType.ZSTD}
    with open(out, "wb") as stream:
        writer = Writer(stream, compression=kinds[compression], chunk_size=4096)
        writer.start(profile="ros2", library="validation")
        channels = {}
        for t, topic, message in messages(log):
            kind = message.__msgtype__
            if topic not in channels:
                text, _ = store.generate_msgdef(kind, ros_version=2)
                schema = writer.register_schema(kind, "ros2msg", text.encode())
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            ns = EPOCH * 10**9 + round(t * 1e9)
            writer.add_message(channels[topic], ns, bytes(store.serialize_cdr(message, kind)), ns)
        writer.finish()


def by_rosbags(log, out):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bag"
        with Bag(path, version=9, storage_plugin=StoragePlugin.MCAP) as bag:
            connections = {}
            for t, topic, message in messages(log):
                kind = message.__msgtype__
                if topic not in connections:
                    connections[topic] = bag.add_connection(topic, kind, typestore=store)
                ns = EPOCH * 10**9 + round(t * 1e9)
                bag.write(connections[topic], ns, store.serialize_cdr(message, kind))
        shutil.copy(next(path.glob("*.mcap")), out)


if __name__ == "__main__":
    log, out, how = (sys.argv + ["none"])[1:4]
    by_rosbags(log, out) if how == "rosbags" else by_mcap(log, out, how)

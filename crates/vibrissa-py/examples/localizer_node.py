"""A node of ROS 2: odometry and the moment of a whisker in, the robot's pose out. Run: python3 localizer_node.py --ros-args -p map:=arena.svg"""

import math
from collections import deque

import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

import vibrissa


def seconds(stamp):
    return stamp.sec + 1e-9 * stamp.nanosec


class LocalizerNode(Node):
    def __init__(self):
        super().__init__("vibrissa")
        robot = self.declare_parameter("robot", "").value or None
        self.localizer = vibrissa.Localizer(self.declare_parameter("map", "arena.svg").value, robot)
        self.waiting, self.before = deque(maxlen=1000), None
        self.pose = self.create_publisher(PoseWithCovarianceStamped, "pose", 10)
        self.create_subscription(WrenchStamped, "whisker/wrench", self.waiting.append, qos_profile_sensor_data)
        self.create_subscription(Odometry, "odom", self.odometry, qos_profile_sensor_data)

    def odometry(self, message):
        """Readings between two messages of odometry: the pose is interpolated at their times."""
        p, q = message.pose.pose.position, message.pose.pose.orientation
        now = (seconds(message.header.stamp), p.x, p.y, math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y**2 + q.z**2)))
        before, self.before = self.before, now
        while before and self.waiting and seconds(self.waiting[0].header.stamp) <= now[0]:
            reading = self.waiting.popleft()
            t = seconds(reading.header.stamp)
            if not before[0] < t:
                continue
            part = (t - before[0]) / (now[0] - before[0])
            turn = math.remainder(now[3] - before[3], math.tau)
            x, y, theta = (a + part * (b - a) for a, b in zip(before[1:], (now[1], now[2], before[3] + turn)))
            try:
                self.localizer.step(t, (x, y, theta), reading.wrench.torque.z)
            except vibrissa.Error as error:
                self.get_logger().warning(str(error))
        self.publish(message.header.stamp)

    def publish(self, stamp):
        estimate = self.localizer.estimate()
        if estimate.pose is None:
            return
        out = PoseWithCovarianceStamped()
        out.header.frame_id, out.header.stamp = "map", stamp
        x, y, theta = estimate.pose
        out.pose.pose.position.x, out.pose.pose.position.y = x, y
        out.pose.pose.orientation.z, out.pose.pose.orientation.w = math.sin(theta / 2), math.cos(theta / 2)
        covariance = estimate.hypotheses[0].covariance
        for i, row in enumerate([] if covariance is None else covariance):
            for k, value in enumerate(row):
                out.pose.covariance[6 * (0, 1, 5)[i] + (0, 1, 5)[k]] = float(value)
        self.pose.publish(out)


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(LocalizerNode())

"""A node of ROS 2: odometry and the moment of a whisker in, the robot's pose out. Run: python3 localizer_node.py --ros-args -p map:=arena.svg"""

import math
from collections import deque

import numpy as np
import rclpy
from geometry_msgs.msg import PoseWithCovarianceStamped, WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data

import vibrissa


def seconds(message):
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


class LocalizerNode(Node):
    def __init__(self):
        super().__init__("vibrissa")
        files = [self.declare_parameter(name, default).value for name, default in (("map", "arena.svg"), ("robot", ""))]
        self.localizer = vibrissa.Localizer(files[0], files[1] or None)
        self.readings, self.odometry = deque(maxlen=1000), deque(maxlen=2)
        self.pose = self.create_publisher(PoseWithCovarianceStamped, "pose", 10)
        self.create_subscription(WrenchStamped, "whisker/wrench", self.readings.append, qos_profile_sensor_data)
        self.create_subscription(Odometry, "odom", self.step, qos_profile_sensor_data)

    def step(self, message):
        """Takes the readings between two messages of odometry, with the pose interpolated at their times."""
        p, q = message.pose.pose.position, message.pose.pose.orientation
        self.odometry.append((seconds(message), p.x, p.y, math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y**2 + q.z**2))))
        times, x, y, theta = zip(*self.odometry)
        while self.readings and (t := seconds(self.readings[0])) <= times[-1]:
            moment = self.readings.popleft().wrench.torque.z
            try:
                if t > times[0]:
                    self.localizer.step(t, [np.interp(t, times, values) for values in (x, y, np.unwrap(theta))], moment)
            except vibrissa.DataError as error:
                self.get_logger().warning(str(error))
        estimate = self.localizer.estimate()
        if estimate.pose is not None:
            self.publish(message.header.stamp, *estimate.pose, estimate.hypotheses[0].covariance)

    def publish(self, stamp, x, y, theta, covariance):
        out, full = PoseWithCovarianceStamped(), np.zeros((6, 6))
        out.header.frame_id, out.header.stamp = "map", stamp
        out.pose.pose.position.x, out.pose.pose.position.y = x, y
        out.pose.pose.orientation.z, out.pose.pose.orientation.w = math.sin(theta / 2), math.cos(theta / 2)
        full[np.ix_((0, 1, 5), (0, 1, 5))] = 0.0 if covariance is None else covariance
        out.pose.covariance = full.ravel()
        self.pose.publish(out)


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(LocalizerNode())

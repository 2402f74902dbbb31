"""ROS 2 node that publishes the estimated stiffness of each pinched object.

python examples/ros_node.py twin

A second argument names a model that `firstcontact adapt` made, instead of the package's.

Needs rclpy and std_msgs of a ROS 2 installation. Each message on /stiffness holds the value and
the ends of the interval, Shore A.
"""

import sys

import rclpy
from rclpy.node import Node
from std_msgs.msg import Float32MultiArray

import firstcontact as fc


class Stiffness(Node):
    """ROS 2 node that publishes the final estimate of each pinch."""

    def __init__(self, device: str, model: str | None = None, pinches: int | None = None) -> None:
        super().__init__("firstcontact")
        self.publisher = self.create_publisher(Float32MultiArray, "stiffness", 10)
        self.device, self.model, self.pinches = device, model, pinches

    def run(self) -> None:
        """Publish estimates until ROS is shut down, the source ends or all pinches are done."""
        with fc.open(self.device) as source:
            for event in fc.live(source, self.model, pinches=self.pinches):
                if isinstance(event, fc.Estimate) and event.final:
                    e = event
                    self.publisher.publish(Float32MultiArray(data=[e.value, e.low, e.high]))
                if not rclpy.ok():
                    break


if __name__ == "__main__":
    rclpy.init()
    Stiffness(*sys.argv[1:3]).run()
    rclpy.shutdown()

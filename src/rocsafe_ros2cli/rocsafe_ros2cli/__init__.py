# SPDX-License-Identifier: Apache-2.0
"""Stand-in for the `ros2` command on machines whose ROS 2 comes from wheels, which bring none.

It takes the words of the real command and answers with its output, so that what is written for
one kind of machine holds on the other: `python -m rocsafe_ros2cli topic list` is
`ros2 topic list`. Set-up puts it on the PATH as `ros2` only where no other `ros2` is found.

`cli` holds the table of commands, one module each (`topic_command` and so on); a command is a row
of verbs. `command_node` gives a verb its node, `discovery` tells when it has met the others.
"""

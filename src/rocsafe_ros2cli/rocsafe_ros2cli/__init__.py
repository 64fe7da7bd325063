# SPDX-License-Identifier: Apache-2.0
"""Small replacement of the `ros2` command for machines whose ROS 2 comes from wheels.

The wheels bring no `ros2` command. This one takes the same words and prints the same output for
the verbs that the documents and tests of ROCSAFE use; `python -m rocsafe_ros2cli topic list` is
`ros2 topic list`. Set-up installs it as `ros2` only where no other `ros2` is on the PATH.

`cli` parses the arguments. Each command has a module of its own (`topic_command` and so on) with
a table of verbs. `command_node` makes the node of a verb, which waits until it knows the others.
"""

# SPDX-License-Identifier: Apache-2.0
"""Run the stand-in: `python -m rocsafe_ros.ros2_cli ...`."""

import sys

from rocsafe_ros.ros2_cli.cli import main

if __name__ == '__main__':
    sys.exit(main())

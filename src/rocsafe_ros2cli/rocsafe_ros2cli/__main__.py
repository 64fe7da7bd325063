# SPDX-License-Identifier: Apache-2.0
"""Run the stand-in: `python -m rocsafe_ros2cli ...`."""

import sys

from rocsafe_ros2cli.cli import main

if __name__ == '__main__':
    sys.exit(main())

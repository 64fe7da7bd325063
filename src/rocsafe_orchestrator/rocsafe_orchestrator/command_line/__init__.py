# SPDX-License-Identifier: Apache-2.0
"""The commands of `rocsafe`, one module each.

Each command loads what it needs when it runs: `--help` and `check` are quick and work where ROS
is not set up, and a Ctrl-C while Python loads modules prints no traceback.
"""

import argparse
from typing import TypeAlias

Commands: TypeAlias = 'argparse._SubParsersAction[argparse.ArgumentParser]'

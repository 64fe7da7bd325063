# SPDX-License-Identifier: Apache-2.0
"""Make the workspace ready; started by ``tools/setup.sh``, which finds the Python for it.

Needs the standard library only. What it does is in ``tools/workspace/``.
"""

import sys

from workspace.command import main

if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))

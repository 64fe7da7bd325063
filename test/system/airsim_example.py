# SPDX-License-Identifier: Apache-2.0
"""Run an example of AirSim, unmodified, with the package cosysairsim: PORT SCRIPT [ARGUMENTS].

Not a test: test_airsim_examples.py runs it in the Python that has the package. The examples take
the port of AirSim, wait for keys of a terminal, and some import the client by its old name.
"""

import runpy
import sys
from pathlib import Path

import cosysairsim


def main() -> None:
    """Run the script as if it were the program."""
    port, script = int(sys.argv[1]), Path(sys.argv[2])
    cosysairsim.wait_key = _key_of_stdin
    for client in (cosysairsim.VehicleClient, cosysairsim.MultirotorClient):
        client.__init__.__defaults__ = ('', port, 3600)
    sys.modules['airsim'] = cosysairsim
    sys.argv = [str(script), *sys.argv[3:]]
    sys.path.insert(0, str(script.parent))
    runpy.run_path(str(script), run_name='__main__')


def _key_of_stdin(message: str = '') -> str:
    sys.stdout.write(f'{message}\n')
    return sys.stdin.readline()[:1]


if __name__ == '__main__':
    main()

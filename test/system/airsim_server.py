# SPDX-License-Identifier: Apache-2.0
"""A server of AirSim's API in its own processes, for tests."""

import os
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# A scene may have to be painted first.
READY_S, END_S = 180.0, 30.0


@contextmanager
def airsim_server(scenario: Path, out: Path, domain: int, speed: float) -> Iterator[int]:
    """Serve the vehicles of a scenario; give the port."""
    with socket.create_server(('127.0.0.1', 0)) as free:
        number = free.getsockname()[1]
    command = ['rocsafe', 'airsim', str(scenario), '--out', str(out), '--port', str(number),
               '--speed', str(speed)]  # fmt: skip
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(domain)}
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        _await(process, number)
        yield number
        process.send_signal(signal.SIGINT)
        assert process.wait(END_S) == 128 + signal.SIGINT
        assert 'AirSim clients are served' in process.stdout.read()
    finally:
        process.kill()
        process.wait()


def _await(process: subprocess.Popen, port: int) -> None:
    end_s = time.monotonic() + READY_S
    while True:
        assert process.poll() is None, process.stdout.read()
        assert time.monotonic() < end_s, 'not ready'
        try:
            socket.create_connection(('127.0.0.1', port), 1.0).close()
        except OSError:
            time.sleep(0.2)
        else:
            return

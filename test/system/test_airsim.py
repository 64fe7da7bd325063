# SPDX-License-Identifier: Apache-2.0
"""A script of AirSim's API flies a simulated vehicle: whole processes, and the real client."""

import os
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import msgpack
import pytest
from test.system.airsim_server import airsim_server

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

pytestmark = [pytest.mark.system, pytest.mark.all]

SMALL = Path(__file__).with_name('small.yaml')
CALL_S = 60.0
# A Python with the package cosysairsim, for the real client.
CLIENT = os.environ.get('ROCSAFE_AIRSIM_PYTHON', '')
SCRIPT = """
import sys
import cosysairsim as airsim
client = airsim.MultirotorClient(port=int(sys.argv[1]))
client.confirmConnection()
client.enableApiControl(True)
client.armDisarm(True)
client.takeoffAsync().join()
client.moveToPositionAsync(5, -5, -12, 5).join()
(image,) = client.simGetImages([airsim.ImageRequest('0', airsim.ImageType.Scene, False, False)])
assert len(image.image_data_uint8) == image.width * image.height * 3
before = client.simGetCameraInfo('0').fov
client.simSetCameraFov('0', 25.0)
assert abs(client.simGetCameraInfo('0').fov - 25.0) < 1e-6
(closer,) = client.simGetImages([airsim.ImageRequest('0', airsim.ImageType.Scene, False, False)])
assert closer.image_data_uint8 != image.image_data_uint8
client.simSetCameraFov('0', before)
rotors = client.getRotorStates().rotors
assert len(rotors) == 4 and 15.0 < sum(one['thrust'] for one in rotors) < 25.0
place = client.simGetVehiclePose().position
assert abs(place.x_val - 5) < 0.5 and abs(place.y_val + 5) < 0.5 and abs(place.z_val + 12) < 0.5
client.landAsync().join()
assert client.getMultirotorState().landed_state == airsim.LandedState.Landed
"""


class Client:
    """The least that speaks the protocol."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(('127.0.0.1', port), CALL_S)
        self._unpacker = msgpack.Unpacker(raw=False)
        self._number = 0

    def call(self, method: str, *arguments):
        """Return the result of a call; raises `RuntimeError` with the refusal."""
        self._number += 1
        self._socket.sendall(msgpack.packb([0, self._number, method, list(arguments)]))
        while True:
            for kind, number, error, result in self._unpacker:
                assert (kind, number) == (1, self._number)
                if error is not None:
                    raise RuntimeError(error)
                return result
            data = self._socket.recv(65536)
            assert data, 'the server has closed the connection'
            self._unpacker.feed(data)


@pytest.fixture
def port(tmp_path, ros_domain_id) -> Iterator[int]:
    """Return the port at which the vehicles of a small scenario are served."""
    with airsim_server(SMALL, tmp_path, ros_domain_id, 5.0) as number:
        yield number


def test_a_script_flies_photographs_and_lands(port):
    """By the protocol alone; what is not served is refused by name."""
    client = Client(port)
    first = client.call('listVehicles')[0]
    with pytest.raises(RuntimeError, match='enableApiControl first'):
        client.call('takeoff', 20.0, '')
    client.call('enableApiControl', True, '')
    assert client.call('takeoff', 20.0, '') is True
    yaw = {'is_rate': True, 'yaw_or_rate': 0.0}
    assert client.call('moveToPosition', 8.0, 4.0, -10.0, 5.0, 3e38, 0, yaw, -1, 1, '') is True
    pose = client.call('simGetVehiclePose', first)['position']
    assert [pose[key] for key in ('x_val', 'y_val', 'z_val')] == pytest.approx(
        [8.0, 4.0, -10.0], abs=0.5
    )
    request = {'camera_name': '0', 'image_type': 0, 'pixels_as_float': False, 'compress': True}
    (image,) = client.call('simGetImages', [request], '')
    assert image['image_data_uint8'].startswith(b'\x89PNG')
    assert client.call('getRadSensorData', '', '')['dose_rate_usvh'] > 0.0
    with pytest.raises(RuntimeError, match='not served here'):
        client.call('moveByMotorPWMs', 1, 1, 1, 1, 1, '')
    assert client.call('land', 60.0, '') is True
    assert client.call('getMultirotorState', '')['landed_state'] == 0


@pytest.mark.skipif(not CLIENT, reason='ROCSAFE_AIRSIM_PYTHON names no Python with cosysairsim')
def test_the_real_client_flies(port):
    """Cosys-AirSim's package, unmodified."""
    done = subprocess.run(
        [CLIENT, '-c', SCRIPT, str(port)], capture_output=True, text=True, timeout=200, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr

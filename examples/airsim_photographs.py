# SPDX-License-Identifier: Apache-2.0
"""Fly a square with AirSim's client; photograph the ground and read the dose rate at each corner.

rocsafe airsim config/scenarios/derailment_engine.yaml
python examples/airsim_photographs.py --folder pictures

The second command runs where the client is: ``pip install cosysairsim``.
"""

import argparse
from pathlib import Path

import cosysairsim as airsim


def main() -> None:
    """Take off, fly, photograph, land."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').splitlines()[0])
    parser.add_argument('--folder', type=Path, default=Path('pictures'))
    parser.add_argument('--port', type=int, default=41451)
    parser.add_argument('--side', type=float, default=20.0, help='of the square, metres')
    parser.add_argument('--height', type=float, default=15.0, help='above home, metres')
    arguments = parser.parse_args()
    client = airsim.MultirotorClient(port=arguments.port)
    client.confirmConnection()
    client.enableApiControl(True)
    client.takeoffAsync().join()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    side = arguments.side
    # North, east, down in metres from where the vehicle stood.
    for number, (north, east) in enumerate(((0, 0), (side, 0), (side, side), (0, side))):
        client.moveToPositionAsync(north, east, -arguments.height, 5).join()
        picture = client.simGetImage('0', airsim.ImageType.Scene)
        (arguments.folder / f'corner_{number}.png').write_bytes(picture)
        # A method that only this server has: the client has no function for it.
        reading = client.client.call('getRadSensorData', '', '')
        print(f'{north:5.0f} m north, {east:5.0f} m east: {reading["dose_rate_usvh"]:.3f} uSv/h')
    client.goHomeAsync().join()
    client.enableApiControl(False)


if __name__ == '__main__':
    main()

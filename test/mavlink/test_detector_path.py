# SPDX-License-Identifier: Apache-2.0
"""A detector on a vehicle, end to end: from its bytes to a reading with the vehicle's place.

The copter speaks MAVLink over UDP to the bridge, the bridge publishes fixes and the bytes of
TUNNEL messages, and the adapter makes readings of them; or of a serial port beside the bridge.
"""

import math
import os
import pty
import time

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.parameter import Parameter
from test.fakes.fake_autopilot import HOME
from test.mavlink.airspace import Airspace
from test.mavlink.operator_post import Ground

from rocsafe_interfaces.msg import RadiationReading
from rocsafe_radiation.detector_node import DetectorNode
from rocsafe_ros.interfaces import topics


class Tunnel:
    """A detector whose lines the autopilot passes on."""

    def __init__(self, copter):
        self._copter = copter
        self.options = {'tunnel': True}

    def say(self, line):
        """Send bytes, in two messages as they happen to be cut."""
        for piece in (line[:2], line[2:]):
            payload = list(piece.ljust(128, b'\0'))
            self._copter._say('TUNNEL', payload_type=0, payload_length=len(piece), payload=payload)

    def close(self):
        """Do nothing."""


class Serial:
    """A detector on a serial port of the computer."""

    def __init__(self, _copter):
        self._master, self._slave = pty.openpty()
        self.options = {'serial': os.ttyname(self._slave)}

    def say(self, line):
        """Send bytes."""
        os.write(self._master, line)

    def close(self):
        """Unplug it."""
        os.close(self._master)
        os.close(self._slave)


@pytest.mark.parametrize('kind', [Tunnel, Serial], ids=['tunnel', 'serial port'])
def test_line_of_a_detector_becomes_a_reading_where_the_vehicle_is(ros, tmp_path, kind):
    """Value, time and place; bytes of another device that come the same way are no lines."""
    air = Airspace(rate=1.0)
    ground = Ground(ros, air, tmp_path)
    detector = kind(air.copters[1])
    adapter = DetectorNode(
        context=ros.context,
        namespace='/rav1',
        parameter_overrides=[Parameter(name, value=v) for name, v in detector.options.items()],
    )
    ros.executor.add_node(adapter)
    try:
        readings, fixes = ground.listen(topics.RADIATION), ground.listen(topics.FIX)
        ground.until(lambda: fixes and fixes[-1].status.status >= 0)
        told_s = []

        def is_placed():
            if not told_s or time.time() - told_s[-1] > 0.5:
                told_s.append(time.time())
                other = list(b'9.9\n'.ljust(128, b'\0'))
                air.copters[1]._say('TUNNEL', payload_type=200, payload_length=4, payload=other)
                detector.say(b'0.25\n')
            return any(math.isfinite(reading.position.latitude) for reading in readings)

        ground.until(is_placed)
        reading = next(r for r in readings if math.isfinite(r.position.latitude))
        assert {r.dose_rate_usvh for r in readings} == {0.25}
        assert reading.radiation_type == RadiationReading.RADIATION_TYPE_GAMMA
        assert reading.header.frame_id == 'rav1/radiation_sensor'
        assert reading.position.latitude == pytest.approx(HOME[0], abs=1e-5)
        assert reading.position.longitude == pytest.approx(HOME[1], abs=1e-5)
        assert reading.position.altitude == pytest.approx(fixes[-1].altitude, abs=1.0)
        stamp_s = reading.header.stamp.sec + reading.header.stamp.nanosec / 1e9
        assert told_s[0] - 1.0 <= stamp_s <= told_s[-1] + 1.0
    finally:
        ros.executor.remove_node(adapter)
        adapter.destroy_node()
        detector.close()
        ground.close()
        air.close()

# SPDX-License-Identifier: Apache-2.0
"""Numbers of the streams of random values of a vehicle: no two errors share one."""

from enum import IntEnum


class Stream(IntEnum):
    """What the values are drawn for; the order is that of all recorded runs."""

    GPS_WANDER = 0
    GPS_WHITE = 1
    SWAY = 2
    ATTITUDE = 3
    SWAY_WANDER = 4
    ORIENTATION = 5
    GYROSCOPE_WHITE = 6
    GYROSCOPE_DRIFT = 7
    ACCELEROMETER_WHITE = 8
    ACCELEROMETER_DRIFT = 9
    BAROMETER_WHITE = 10
    BAROMETER_DRIFT = 11
    MAGNETOMETER_WHITE = 12
    MAGNETOMETER_DRIFT = 13
    RANGE_WHITE = 14
    RANGE_DRIFT = 15

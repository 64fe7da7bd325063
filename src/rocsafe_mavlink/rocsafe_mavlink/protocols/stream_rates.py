# SPDX-License-Identifier: Apache-2.0
"""Rates of the messages of a vehicle, and when to ask for one again.

Rates are kept per channel and are lost when an autopilot restarts: then only heartbeats come. So
each message is watched, and asked for when three of it in a row are missing.
"""

import math
from collections.abc import Mapping

# Message: its number and how many a second.
POSITION = 'GLOBAL_POSITION_INT'
WANTED: Mapping[str, tuple[int, float]] = {
    'GLOBAL_POSITION_INT': (33, 10.0),
    'ATTITUDE': (30, 5.0),
    'GPS_RAW_INT': (24, 2.0),
    'EKF_STATUS_REPORT': (193, 2.0),
    'ESTIMATOR_STATUS': (230, 2.0),
    'SYS_STATUS': (1, 2.0),
    'MISSION_CURRENT': (42, 2.0),
    'EXTENDED_SYS_STATE': (245, 2.0),
    'HOME_POSITION': (242, 1.0),
    'POSITION_TARGET_GLOBAL_INT': (87, 2.0),
    'ADSB_VEHICLE': (246, 2.0),
    'WIND': (168, 1.0),
    'WIND_COV': (231, 1.0),
}
# Messages that a vehicle sends only while it has such data.
OCCASIONAL = frozenset({'POSITION_TARGET_GLOBAL_INT', 'ADSB_VEHICLE', 'WIND', 'WIND_COV'})
MISSING_PERIODS = 3.0
# An answer takes time; messages that a vehicle does not have are asked for rarely.
ASK_AGAIN_S = 5.0
ASK_OCCASIONAL_AGAIN_S = 60.0
# Between two questions to one vehicle, so that its commands find room.
PACE_S = 0.3


class StreamRates:
    """Watches the messages of one vehicle.

    Parameters
    ----------
    position_rate_hz
        Positions a second; None: as in `WANTED`.
    """

    def __init__(self, position_rate_hz: float | None = None) -> None:
        number, rate_hz = WANTED[POSITION]
        own = {POSITION: (number, position_rate_hz or rate_hz)}
        self._wanted = {**WANTED, **own}
        self._heard_s: dict[str, float] = {}
        self._asked_s: dict[str, float] = {}
        self._last_ask_s = -math.inf

    def hear(self, name: str, now_s: float) -> None:
        """Note that a message came."""
        if name in WANTED:
            self._heard_s[name] = now_s

    def due(self, now_s: float, unsent: frozenset[str] = frozenset()) -> tuple[int, float] | None:
        """Return number and rate of a message to ask for now, None if there is none.

        `unsent` are messages that this kind of autopilot does not have.
        """
        if now_s - self._last_ask_s < PACE_S:
            return None
        for name, (number, rate_hz) in self._wanted.items():
            if name in unsent:
                continue
            silent_s = now_s - self._heard_s.get(name, -math.inf)
            again_s = ASK_OCCASIONAL_AGAIN_S if name in OCCASIONAL else ASK_AGAIN_S
            is_asked = now_s - self._asked_s.get(name, -math.inf) < again_s
            if silent_s > MISSING_PERIODS / rate_hz and not is_asked:
                self._asked_s[name] = self._last_ask_s = now_s
                return number, rate_hz
        return None

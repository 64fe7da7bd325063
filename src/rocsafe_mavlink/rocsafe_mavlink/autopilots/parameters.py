# SPDX-License-Identifier: Apache-2.0
"""Parameters of autopilots, read only: each is requested by all of its names, in SI units.

Each kind of vehicle has its own: a number that lets an ArduCopter return lets a Rover drive on.
ArduPilot 4.7 renamed and rescaled many. A parameter that has two names is asked for by both, and
the unit follows from the name that answered.
"""

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum

from rocsafe_mavlink.autopilots.ardupilot import COPTER, ROVER
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER
from rocsafe_mavlink.wire.dialect import Message, addressed

# The message that tells one.
PARAMETER = 'PARAM_VALUE'
ASK_AGAIN_S = 1.0
# Another station may change a parameter; not every autopilot tells it to all.
REFRESH_S = 30.0
LARGEST_ASK_COUNT = 5
# MAV_PARAM_TYPE of integers, whose bits PX4 copies into the float of its message.
_INTEGER_FORMATS: Mapping[int, str] = {1: '<B', 2: '<b', 3: '<H', 4: '<h', 5: '<I', 6: '<i'}


class Parameter(Enum):
    """Parameters that are read, by their meaning."""

    CRUISE_SPEED_MPS = 'cruise speed'
    ACCELERATION_MPS2 = 'acceleration'
    WAYPOINT_RADIUS_M = 'waypoint radius'
    LINK_LOSS_SWITCH = 'link-loss failsafe'
    LINK_LOSS_ACTION = 'link-loss action'
    LOW_BATTERY_ACTION = 'low-battery action'
    FENCE_ENABLED = 'fence'
    FENCE_TYPES = 'kinds of fence'
    FENCE_ACTION = 'action at the fence'
    FENCE_RADIUS_M = 'radius of the fence'
    FENCE_HEIGHT_M = 'height of the fence'
    YAW_BEHAVIOUR = 'heading on the way'
    STATION = 'station that may command'
    LINK_LOSS_EXCEPTIONS = 'exceptions from the link-loss action'
    RETURN_HEIGHT_M = 'height of the return'
    ARMING_CHECKS = 'checks before arming'
    RADIO_LOSS_ACTION = 'radio-loss action'
    RALLY_LIMIT_M = 'furthest rally point'
    RALLY_INCLUDES_HOME = 'home as a rally point'
    PATH_PLANNER = 'path planner'
    RETURN_KIND = 'kind of return'
    RETURN_END = 'end of the return'
    RETURN_POINTS = 'places of its tracks that it keeps'
    MISSION_RESTART = 'mission after a hold'
    MISSION_END = 'end of the mission'


_Spellings = Mapping[Parameter, tuple[tuple[str, float], ...]]
_ARDUPILOT: _Spellings = {
    Parameter.LOW_BATTERY_ACTION: (('BATT_FS_LOW_ACT', 1.0),),
    Parameter.FENCE_ENABLED: (('FENCE_ENABLE', 1.0),),
    Parameter.FENCE_TYPES: (('FENCE_TYPE', 1.0),),
    Parameter.FENCE_ACTION: (('FENCE_ACTION', 1.0),),
    Parameter.FENCE_RADIUS_M: (('FENCE_RADIUS', 1.0),),
    Parameter.STATION: (('MAV_GCS_SYSID', 1.0), ('SYSID_MYGCS', 1.0)),
    # The newer one names what is left out, the older one what is checked.
    Parameter.ARMING_CHECKS: (('ARMING_SKIPCHK', 1.0), ('ARMING_CHECK', 1.0)),
    Parameter.RADIO_LOSS_ACTION: (('FS_THR_ENABLE', 1.0),),
    Parameter.RALLY_LIMIT_M: (('RALLY_LIMIT_KM', 1000.0),),
    Parameter.RALLY_INCLUDES_HOME: (('RALLY_INCL_HOME', 1.0),),
    Parameter.PATH_PLANNER: (('OA_TYPE', 1.0),),
    Parameter.MISSION_RESTART: (('MIS_RESTART', 1.0),),
}
# Names of each parameter by the name of the kind, the newest first, with the factor from their
# unit to SI.
SPELLINGS: Mapping[str, _Spellings] = {
    COPTER.name: {
        **_ARDUPILOT,
        Parameter.CRUISE_SPEED_MPS: (('WP_SPD', 1.0), ('WPNAV_SPEED', 0.01)),
        Parameter.ACCELERATION_MPS2: (('WP_ACC', 1.0), ('WPNAV_ACCEL', 0.01)),
        Parameter.WAYPOINT_RADIUS_M: (('WP_RADIUS_M', 1.0), ('WPNAV_RADIUS', 0.01)),
        Parameter.LINK_LOSS_ACTION: (('FS_GCS_ENABLE', 1.0),),
        Parameter.LINK_LOSS_EXCEPTIONS: (('FS_OPTIONS', 1.0),),
        Parameter.FENCE_HEIGHT_M: (('FENCE_ALT_MAX', 1.0),),
        Parameter.YAW_BEHAVIOUR: (('WP_YAW_BEHAVIOR', 1.0),),
        Parameter.RETURN_HEIGHT_M: (('RTL_ALT_M', 1.0), ('RTL_ALT', 0.01)),
        Parameter.RETURN_END: (('RTL_ALT_FINAL_M', 1.0), ('RTL_ALT_FINAL', 0.01)),
    },
    ROVER.name: {
        **_ARDUPILOT,
        Parameter.CRUISE_SPEED_MPS: (('WP_SPEED', 1.0),),
        Parameter.WAYPOINT_RADIUS_M: (('WP_RADIUS', 1.0),),
        Parameter.LINK_LOSS_SWITCH: (('FS_GCS_ENABLE', 1.0),),
        Parameter.LINK_LOSS_ACTION: (('FS_ACTION', 1.0),),
        Parameter.RETURN_POINTS: (('SRTL_POINTS', 1.0),),
        Parameter.MISSION_END: (('MIS_DONE_BEHAVE', 1.0),),
    },
    MULTICOPTER.name: {
        Parameter.CRUISE_SPEED_MPS: (('MPC_XY_CRUISE', 1.0),),
        Parameter.ACCELERATION_MPS2: (('MPC_ACC_HOR', 1.0),),
        Parameter.WAYPOINT_RADIUS_M: (('NAV_ACC_RAD', 1.0),),
        Parameter.LINK_LOSS_ACTION: (('NAV_DLL_ACT', 1.0),),
        Parameter.LOW_BATTERY_ACTION: (('COM_LOW_BAT_ACT', 1.0),),
        # Its fence is on where its action is not 0.
        Parameter.FENCE_ENABLED: (('GF_ACTION', 1.0),),
        Parameter.FENCE_ACTION: (('GF_ACTION', 1.0),),
        Parameter.LINK_LOSS_EXCEPTIONS: (('COM_DLL_EXCEPT', 1.0),),
        Parameter.RETURN_HEIGHT_M: (('RTL_RETURN_ALT', 1.0),),
        Parameter.RETURN_END: (('RTL_LAND_DELAY', 1.0),),
        Parameter.RADIO_LOSS_ACTION: (('NAV_RCL_ACT', 1.0),),
        Parameter.RETURN_KIND: (('RTL_TYPE', 1.0),),
        Parameter.FENCE_RADIUS_M: (('GF_MAX_HOR_DIST', 1.0),),
        Parameter.FENCE_HEIGHT_M: (('GF_MAX_VER_DIST', 1.0),),
    },
}


@dataclass(frozen=True, slots=True, kw_only=True)
class ParameterReader:
    """Asks for every parameter that a kind of autopilot has: ``(state, message or tick)``.

    Attributes
    ----------
    kind
        Name of the kind of autopilot.
    target
        (system, component).
    found
        Value by name, in the unit that goes with the name.
    asks
        Rounds of questions so far.
    asked_s
        Steady time of the last round.
    """

    kind: str
    target: tuple[int, int]
    found: Mapping[str, float]
    asks: int = 0
    asked_s: float = -math.inf

    @property
    def is_over(self) -> bool:
        """Whether everything is known or was asked for often enough."""
        return not self._missing() or self.asks > LARGEST_ASK_COUNT

    def value(self, parameter: Parameter) -> float:
        """Return a parameter in SI units; NaN if it was not answered."""
        for spelling, factor in SPELLINGS[self.kind].get(parameter, ()):
            if spelling in self.found:
                return self.found[spelling] * factor
        return math.nan

    def spelling(self, parameter: Parameter) -> str:
        """Return the vehicle's name for a parameter; the newest one if it has not answered."""
        spellings = SPELLINGS[self.kind].get(parameter, ())
        known = (name for name, _ in spellings if name in self.found)
        return next(known, spellings[0][0] if spellings else parameter.value)

    def on_message(self, message: Message) -> 'ParameterReader':
        """Take a message; only a PARAM_VALUE that was asked for changes anything."""
        if message.name != PARAMETER or message['param_id'] not in self._names():
            return self
        value = decoded_value(self.kind, message)
        if not math.isfinite(value):
            return self
        return replace(self, found={**self.found, message['param_id']: value})

    def on_tick(self, now_s: float) -> tuple['ParameterReader', list[Message]]:
        """Ask for what is missing, once in a while, and later for what may have changed."""
        since_s = now_s - self.asked_s
        if since_s < ASK_AGAIN_S or (since_s < REFRESH_S and self.is_over):
            return self, []
        names = (*(self.found if self.is_over else ()), *self._missing())
        asked = replace(self, asks=self.asks + 1, asked_s=now_s)
        return asked, [self._question(name) for name in names]

    def _names(self) -> set[str]:
        spellings = SPELLINGS[self.kind].values()
        return {name for ways in spellings for name, _ in ways}

    def _missing(self) -> list[str]:
        missing = (
            name
            for ways in SPELLINGS[self.kind].values()
            if not any(spelling in self.found for spelling, _ in ways)
            for name, _ in ways
        )
        return list(dict.fromkeys(missing))

    def _question(self, name: str) -> Message:
        return addressed('PARAM_REQUEST_READ', self.target, param_id=name, param_index=-1)


def decoded_value(kind: str, message: Message) -> float:
    """Return the value of a PARAM_VALUE: ArduPilot casts integers, PX4 copies their bits."""
    value, integer = float(message['param_value']), int(message['param_type'])
    if kind != MULTICOPTER.name or integer not in _INTEGER_FORMATS:
        return value
    layout = _INTEGER_FORMATS[integer]
    raw = struct.pack('<f', value)[: struct.calcsize(layout)]
    return float(struct.unpack(layout, raw)[0])

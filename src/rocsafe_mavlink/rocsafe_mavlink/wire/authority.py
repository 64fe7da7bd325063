# SPDX-License-Identifier: Apache-2.0
"""Messages and commands that may be sent to an autopilot; all others are refused.

Ending a flight by force, rebooting and writing parameters are not among them.
"""

import math
from collections.abc import Mapping

from rocsafe_mavlink.errors import NotAllowedError
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.rate_limit import RateLimit

LARGEST_COMMANDS_PER_S = 10.0
NAV_RETURN_TO_LAUNCH, NAV_LAND, NAV_TAKEOFF, CONDITION_YAW = 20, 21, 22, 115
DO_SET_MODE, DO_CHANGE_SPEED, DO_REPOSITION, DO_PAUSE_CONTINUE = 176, 178, 192, 193
DO_SET_CAM_TRIGG_DIST, DO_DIGICAM_CONTROL, DO_SET_MISSION_CURRENT = 206, 203, 224
MISSION_START, COMPONENT_ARM_DISARM = 300, 400
SET_MESSAGE_INTERVAL, REQUEST_MESSAGE, IMAGE_START_CAPTURE = 511, 512, 2000
COMMANDS: Mapping[int, str] = {
    NAV_RETURN_TO_LAUNCH: 'return to launch',
    NAV_LAND: 'land',
    NAV_TAKEOFF: 'take off',
    DO_SET_MODE: 'set mode',
    DO_CHANGE_SPEED: 'change speed',
    DO_REPOSITION: 'go to',
    DO_PAUSE_CONTINUE: 'pause or continue',
    DO_DIGICAM_CONTROL: 'photograph',
    DO_SET_CAM_TRIGG_DIST: 'photograph by distance',
    DO_SET_MISSION_CURRENT: 'set current item',
    MISSION_START: 'start mission',
    COMPONENT_ARM_DISARM: 'arm or disarm',
    SET_MESSAGE_INTERVAL: 'set message interval',
    REQUEST_MESSAGE: 'request message',
    IMAGE_START_CAPTURE: 'photograph',
}
MESSAGES = frozenset(
    {
        'HEARTBEAT',
        'COMMAND_LONG',
        'COMMAND_INT',
        'MISSION_COUNT',
        'MISSION_ITEM_INT',
        'MISSION_REQUEST_LIST',
        'MISSION_REQUEST_INT',
        'MISSION_ACK',
        'MISSION_CLEAR_ALL',
        'PARAM_REQUEST_READ',
    }
)
_COMMAND_MESSAGES = ('COMMAND_LONG', 'COMMAND_INT')
# In these an unused parameter may be NaN, which means "leave it as it is".
_NAN_ALLOWED = frozenset({NAV_LAND, DO_REPOSITION})


class Authority:
    """Lets permitted messages pass, and at most ten commands a second to each system."""

    def __init__(self) -> None:
        self._rates: dict[int, RateLimit] = {}

    def require(self, message: Message, now_s: float) -> None:
        """Check a message that is about to be sent.

        Raises
        ------
        NotAllowedError
            Naming the message and the rule that it breaks.
        """
        if message.name not in MESSAGES:
            raise NotAllowedError(f'{message.name} is not among the messages that may be sent')
        if message.name in _COMMAND_MESSAGES:
            self._require_command(message, now_s)
        else:
            _require_finite(message)

    def _require_command(self, message: Message, now_s: float) -> None:
        number = int(message['command'])
        if number not in COMMANDS:
            raise NotAllowedError(f'command {number} is not among those that may be sent')
        if number == COMPONENT_ARM_DISARM and message.fields.get('param2'):
            raise NotAllowedError(f'{COMMANDS[number]}: force is not allowed')
        if number not in _NAN_ALLOWED:
            _require_finite(message)
        system = int(message.fields.get('target_system', 0))
        rate = self._rates.setdefault(system, RateLimit(LARGEST_COMMANDS_PER_S))
        if not rate.take(now_s):
            raise NotAllowedError(
                f'{COMMANDS[number]}: more than {LARGEST_COMMANDS_PER_S:g} commands a second'
            )


def _require_finite(message: Message) -> None:
    for name, value in message.fields.items():
        if isinstance(value, float) and not math.isfinite(value):
            raise NotAllowedError(f'{message.name}.{name} = {value} must be a finite number')

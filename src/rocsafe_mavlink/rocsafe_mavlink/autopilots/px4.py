# SPDX-License-Identifier: Apache-2.0
"""PX4's multicopters, as flown in its simulator SIH of August 2025 (before version 1.17)."""

from rocsafe_mavlink.autopilots.autopilot import Autopilot, FlightState, Verb

PX4 = 12
_AUTO, _OFFBOARD = 4, 6


def custom_mode(main: int, sub: int = 0) -> int:
    """Return PX4's custom mode of a main and a sub mode."""
    return sub << 24 | main << 16


TAKEOFF, HOLD, MISSION, RETURN, LAND = (custom_mode(_AUTO, sub) for sub in (2, 3, 4, 5, 6))
OFFBOARD = custom_mode(_OFFBOARD)

MULTICOPTER = Autopilot(
    name='PX4 multicopter',
    number=PX4,
    is_tested=True,
    has_home_item=False,
    mode_names={
        custom_mode(1): 'MANUAL',
        custom_mode(2): 'ALTCTL',
        custom_mode(3): 'POSCTL',
        custom_mode(5): 'ACRO',
        custom_mode(7): 'STABILIZED',
        custom_mode(3, 1): 'ORBIT',
        custom_mode(3, 2): 'POSCTL.SLOW',
        custom_mode(8): 'RATTITUDE',
        custom_mode(_AUTO, 1): 'AUTO.READY',
        custom_mode(_AUTO, 8): 'AUTO.FOLLOW_TARGET',
        custom_mode(_AUTO, 9): 'AUTO.PRECLAND',
        custom_mode(_AUTO, 10): 'AUTO.VTOL_TAKEOFF',
        TAKEOFF: 'AUTO.TAKEOFF',
        HOLD: 'AUTO.LOITER',
        MISSION: 'AUTO.MISSION',
        RETURN: 'AUTO.RTL',
        LAND: 'AUTO.LAND',
        OFFBOARD: 'OFFBOARD',
    },
    modes={
        Verb.GUIDED: OFFBOARD,
        Verb.MISSION: MISSION,
        Verb.HOLD: HOLD,
        Verb.RETURN: RETURN,
        Verb.LAND: LAND,
    },
    states={
        TAKEOFF: FlightState.TAKING_OFF,
        HOLD: FlightState.HOLDING,
        RETURN: FlightState.RETURNING,
        LAND: FlightState.LANDING,
    },
    is_mode_packed=True,
    arms_in=Verb.MISSION,
    pauses_missions=False,
    repositions_itself=True,
    flies_to_takeoff=True,
    turns_at_waypoints=True,
    starts_anywhere=True,
    unsent=frozenset({'EKF_STATUS_REPORT', 'WIND'}),
)

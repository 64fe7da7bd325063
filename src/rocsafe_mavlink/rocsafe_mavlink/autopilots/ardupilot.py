# SPDX-License-Identifier: Apache-2.0
"""ArduPilot's multicopters and rovers: modes of 4.x, measured on ArduCopter and Rover 4.7."""

from rocsafe_mavlink.autopilots.autopilot import Autopilot, FlightState, Verb

ARDUPILOT = 3
AUTO, GUIDED, LOITER, RTL, LAND, BRAKE = 3, 4, 5, 6, 9, 17

COPTER = Autopilot(
    name='ArduPilot Copter',
    number=ARDUPILOT,
    is_tested=True,
    has_home_item=True,
    mode_names={
        0: 'STABILIZE',
        1: 'ACRO',
        2: 'ALT_HOLD',
        AUTO: 'AUTO',
        GUIDED: 'GUIDED',
        LOITER: 'LOITER',
        RTL: 'RTL',
        7: 'CIRCLE',
        LAND: 'LAND',
        11: 'DRIFT',
        13: 'SPORT',
        14: 'FLIP',
        15: 'AUTOTUNE',
        16: 'POSHOLD',
        BRAKE: 'BRAKE',
        18: 'THROW',
        19: 'AVOID_ADSB',
        20: 'GUIDED_NOGPS',
        21: 'SMART_RTL',
        22: 'FLOWHOLD',
        23: 'FOLLOW',
        24: 'ZIGZAG',
        25: 'SYSTEMID',
        26: 'AUTOROTATE',
        27: 'AUTO_RTL',
        28: 'TURTLE',
    },
    modes={
        Verb.GUIDED: GUIDED,
        Verb.MISSION: AUTO,
        # Not LOITER: it follows the throttle stick, which may be at its lowest position.
        Verb.HOLD: BRAKE,
        Verb.RETURN: RTL,
        Verb.LAND: LAND,
    },
    states={
        LOITER: FlightState.HOLDING,
        16: FlightState.HOLDING,
        BRAKE: FlightState.HOLDING,
        RTL: FlightState.RETURNING,
        21: FlightState.RETURNING,
        27: FlightState.RETURNING,
        LAND: FlightState.LANDING,
    },
    is_mode_packed=False,
    # It refuses to arm in AUTO; in other modes its pre-arm bit is too optimistic.
    arms_in=Verb.GUIDED,
    pauses_missions=True,
    repositions_itself=False,
    flies_to_takeoff=False,
    turns_at_waypoints=False,
    starts_anywhere=False,
    unsent=frozenset({'ESTIMATOR_STATUS', 'WIND_COV'}),
)

ROVER_HOLD, ROVER_LOITER, ROVER_AUTO, ROVER_RTL, ROVER_SMART_RTL, ROVER_GUIDED = (
    4,
    5,
    10,
    11,
    12,
    15,
)

ROVER = Autopilot(
    name='ArduPilot Rover',
    number=ARDUPILOT,
    is_tested=True,
    has_home_item=True,
    mode_names={
        0: 'MANUAL',
        1: 'ACRO',
        3: 'STEERING',
        ROVER_HOLD: 'HOLD',
        ROVER_LOITER: 'LOITER',
        6: 'FOLLOW',
        7: 'SIMPLE',
        8: 'DOCK',
        9: 'CIRCLE',
        ROVER_AUTO: 'AUTO',
        ROVER_RTL: 'RTL',
        ROVER_SMART_RTL: 'SMART_RTL',
        ROVER_GUIDED: 'GUIDED',
        16: 'INITIALISING',
    },
    modes={
        Verb.GUIDED: ROVER_GUIDED,
        Verb.MISSION: ROVER_AUTO,
        Verb.HOLD: ROVER_HOLD,
        # Back on its own tracks: RTL drives straight home, through whatever stands there.
        Verb.RETURN: ROVER_SMART_RTL,
        Verb.LAND: ROVER_HOLD,
    },
    states={
        ROVER_HOLD: FlightState.HOLDING,
        ROVER_LOITER: FlightState.HOLDING,
        ROVER_RTL: FlightState.RETURNING,
        ROVER_SMART_RTL: FlightState.RETURNING,
    },
    is_mode_packed=False,
    arms_in=Verb.HOLD,
    pauses_missions=False,
    repositions_itself=False,
    flies_to_takeoff=False,
    turns_at_waypoints=False,
    starts_anywhere=False,
    unsent=frozenset({'ESTIMATOR_STATUS', 'WIND_COV', 'WIND'}),
    drives=True,
)

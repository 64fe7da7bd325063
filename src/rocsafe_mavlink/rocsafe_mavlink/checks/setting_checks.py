# SPDX-License-Identifier: Apache-2.0
"""Checks of the failsafe settings of a vehicle."""

import math

from rocsafe_mavlink.autopilots.ardupilot import COPTER, ROVER
from rocsafe_mavlink.autopilots.parameters import SPELLINGS, Parameter, ParameterReader
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER
from rocsafe_mavlink.checks.check import NOT_READ, Check, CheckVerdict
from rocsafe_mavlink.plan.flight_limits import FlightLimits, VehicleSettings

# Link-loss actions that bring a vehicle home: FS_GCS_ENABLE 1 (RTL), 3 and 4 (SmartRTL, else RTL
# or landing), 6 (landing sequence of the mission, else RTL); FS_ACTION 3 and 4 (SmartRTL, else RTL
# or standing; 1 drives straight home, through what stands there); NAV_DLL_ACT 2 (return).
RETURNING = {
    COPTER.name: frozenset({1.0, 3.0, 4.0, 6.0}),
    ROVER.name: frozenset({3.0, 4.0}),
    MULTICOPTER.name: frozenset({2.0}),
}
# FS_GCS_ENABLE 1 of a Rover: its action is taken; 2: its mission goes on.
SWITCHED_ON = 1.0
# Bits by which a vehicle goes on with its mission without a link: of FS_OPTIONS, COM_DLL_EXCEPT.
GOES_ON_BIT = {COPTER.name: 2, MULTICOPTER.name: 1}
# FENCE_ACTION 1 to 5 (return, land, brake and their combinations), of a Rover 1 to 6 (return,
# hold, stopped motors), GF_ACTION 2 (hold), 3 (return), 5 (land). GF_ACTION 4 terminates the
# flight: the motors stop, and the vehicle falls.
ANSWERING = {
    COPTER.name: frozenset({1.0, 2.0, 3.0, 4.0, 5.0}),
    ROVER.name: frozenset({1.0, 2.0, 3.0, 4.0, 5.0, 6.0}),
    MULTICOPTER.name: frozenset({2.0, 3.0, 5.0}),
}
FALLING = {MULTICOPTER.name: frozenset({4.0})}
# Ends of a return that land: RTL_ALT_FINAL 0; RTL_LAND_DELAY, where -1 waits for ever.
_LANDS = {
    COPTER.name: (0.0, 0.0),
    ROVER.name: (0.0, 0.0),
    MULTICOPTER.name: (0.0, math.inf),
}
# System that QGroundControl and Mission Planner have unless somebody changes it.
USUAL_STATION = 255


def setting_checks(known: VehicleSettings, limits: FlightLimits) -> list[Check]:
    """Return the checks of what the vehicle does by itself when something goes wrong."""
    reader, station = known.parameters, known.station
    must_return = limits.must_return_on_link_loss
    bad = CheckVerdict.FAIL if must_return else CheckVerdict.WARN
    if reader is None:
        return [Check('settings', bad, NOT_READ, 'read')]
    twin, limit = f'another one speaks as system {station}', 'nobody but us: set source_system'
    alone = Check('station', bad, twin, f'{limit}, or it hides that this bridge is silent')
    return [
        *([alone] if known.has_twin else []),
        *_link_loss_checks(reader, station, is_required=must_return),
        _setting(reader, Parameter.LOW_BATTERY_ACTION),
        _setting(reader, Parameter.RADIO_LOSS_ACTION),
        *_fence_action_checks(reader),
        *_return_checks(reader, limits),
        *_arming_checks(reader),
        *_heading_checks(reader),
        *_mission_checks(reader),
    ]


def _heading_checks(reader: ParameterReader) -> list[Check]:
    """Return the check that it keeps the heading of its mission, not that of its way."""
    if Parameter.YAW_BEHAVIOUR not in SPELLINGS[reader.kind]:
        return []
    text = setting_text(reader, Parameter.YAW_BEHAVIOUR)
    verdict = (
        CheckVerdict.PASS if reader.value(Parameter.YAW_BEHAVIOUR) == 0.0 else CheckVerdict.WARN
    )
    limit = '0, or photographs lie turned'
    return [Check(Parameter.YAW_BEHAVIOUR.value, verdict, text, limit)]


def _mission_checks(reader: ParameterReader) -> list[Check]:
    """Return the checks that mission and return go on and end as the bridge expects it."""
    fail, warn = CheckVerdict.FAIL, CheckVerdict.WARN
    checks = []
    for parameter, good, bad, limit in (
        (Parameter.MISSION_RESTART, (0.0, 0.0), fail, '0, or a held route begins anew'),
        (Parameter.MISSION_END, (0.0, 1.0), fail, '0 or 1, or nobody switches it off'),
        (Parameter.RETURN_POINTS, (1.0, math.inf), fail, '1 or more, or it cannot return'),
        (Parameter.RETURN_END, _LANDS[reader.kind], warn, 'one that lands'),
    ):
        if parameter not in SPELLINGS[reader.kind]:
            continue
        value = reader.value(parameter)
        # Old or reduced firmware does not answer; the check says so.
        otherwise = warn if math.isnan(value) and reader.is_over else bad
        verdict = CheckVerdict.PASS if good[0] <= value <= good[1] else otherwise
        checks.append(_judged(reader, parameter, verdict, limit))
    return checks


def _link_loss_checks(reader: ParameterReader, station: int, *, is_required: bool) -> list[Check]:
    """Return the checks that the vehicle comes back if this bridge falls silent."""
    bad = CheckVerdict.FAIL if is_required else CheckVerdict.WARN
    action = reader.value(Parameter.LINK_LOSS_ACTION)
    checks = [
        _judged(
            reader,
            Parameter.LINK_LOSS_ACTION,
            CheckVerdict.PASS if action in RETURNING[reader.kind] else bad,
            'one that returns' if is_required else 'one that returns, or chosen otherwise',
        )
    ]
    exceptions = reader.value(Parameter.LINK_LOSS_EXCEPTIONS)
    if Parameter.LINK_LOSS_SWITCH in SPELLINGS[reader.kind]:
        is_on = reader.value(Parameter.LINK_LOSS_SWITCH) == SWITCHED_ON
        verdict = CheckVerdict.PASS if is_on else bad
        checks.append(_judged(reader, Parameter.LINK_LOSS_SWITCH, verdict, '1, or it drives on'))
    if math.isfinite(exceptions) and int(exceptions) & GOES_ON_BIT[reader.kind]:
        limit = f'without bit {GOES_ON_BIT[reader.kind]}, by which its mission goes on'
        checks.append(_judged(reader, Parameter.LINK_LOSS_EXCEPTIONS, bad, limit))
    heard = reader.value(Parameter.STATION)
    if math.isfinite(heard) and station >= 0:
        is_ours, is_usual = heard == station, heard == USUAL_STATION
        verdict = bad if not is_ours else CheckVerdict.WARN if is_usual else CheckVerdict.PASS
        limit = f'{station}, our own, or the vehicle does not notice that this bridge is silent'
        if is_ours and is_usual:
            limit = 'one that no other station has: a station with 255 hides a silent bridge'
        checks.append(_judged(reader, Parameter.STATION, verdict, limit))
    return checks


def _fence_action_checks(reader: ParameterReader) -> list[Check]:
    """Return the checks that a breach of the fence is answered, and not by stopped motors."""
    is_separate = SPELLINGS[reader.kind][Parameter.FENCE_ENABLED][0][0] != 'GF_ACTION'
    checks = [_setting(reader, Parameter.FENCE_ENABLED)] if is_separate else []
    action = reader.value(Parameter.FENCE_ACTION)
    verdict = CheckVerdict.PASS if action in ANSWERING[reader.kind] else CheckVerdict.WARN
    if action in FALLING.get(reader.kind, ()):
        verdict = CheckVerdict.FAIL
    limit = 'one that turns back, stops or lands'
    return [*checks, _judged(reader, Parameter.FENCE_ACTION, verdict, limit)]


def _return_checks(reader: ParameterReader, limits: FlightLimits) -> list[Check]:
    """Return the check of the height at which the vehicle comes home by itself."""
    if Parameter.RETURN_HEIGHT_M not in SPELLINGS[reader.kind]:
        return []
    height_m = reader.value(Parameter.RETURN_HEIGHT_M)
    # 0: it comes home at the height at which it is.
    is_good = height_m == 0.0 or limits.lowest_m <= height_m <= limits.max_height_agl_m
    verdict = CheckVerdict.PASS if is_good else CheckVerdict.WARN
    limit = f'{limits.lowest_m:g} to {limits.max_height_agl_m:g} m'
    return [_judged(reader, Parameter.RETURN_HEIGHT_M, verdict, limit)]


def _arming_checks(reader: ParameterReader) -> list[Check]:
    """Return the check that an ArduPilot's own checks before arming are all on."""
    if Parameter.ARMING_CHECKS not in SPELLINGS[reader.kind]:
        return []
    complete = 0.0 if reader.spelling(Parameter.ARMING_CHECKS) == 'ARMING_SKIPCHK' else 1.0
    is_all = reader.value(Parameter.ARMING_CHECKS) == complete
    verdict = CheckVerdict.PASS if is_all else CheckVerdict.WARN
    return [_judged(reader, Parameter.ARMING_CHECKS, verdict, f'{complete:g}: all of them')]


def _setting(reader: ParameterReader, parameter: Parameter) -> Check:
    value = reader.value(parameter)
    is_on = math.isfinite(value) and value != 0.0
    verdict = CheckVerdict.PASS if is_on else CheckVerdict.WARN
    return _judged(reader, parameter, verdict, 'on, or chosen to be off')


def _judged(
    reader: ParameterReader, parameter: Parameter, verdict: CheckVerdict, limit: str
) -> Check:
    return Check(parameter.value, verdict, setting_text(reader, parameter), limit)


def setting_text(reader: ParameterReader, parameter: Parameter) -> str:
    """Return the value of a parameter by the vehicle's own name for it."""
    value, spelling = reader.value(parameter), reader.spelling(parameter)
    if math.isfinite(value):
        return f'{spelling} = {value:g}'
    return f'{spelling} not answered' if reader.is_over else NOT_READ

# SPDX-License-Identifier: Apache-2.0
"""Updates of the known state of a vehicle by its messages.

`reduce` is a pure function, so that a recorded flight gives the same states every time.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from rocsafe_geo.angle import wrap_rad, yaw_of_heading_rad
from rocsafe_geo.position import distance_m
from rocsafe_mavlink.knowledge.events import Event, EventKind, events_between
from rocsafe_mavlink.knowledge.fix import LARGEST_SPEED_MPS, separation_m
from rocsafe_mavlink.knowledge.telemetry import (
    GROUND_ROVER,
    Aim,
    Attitude,
    Battery,
    Gps,
    Home,
    Landed,
    MissionPhase,
    Motion,
    SystemStatus,
    VehicleTelemetry,
)
from rocsafe_mavlink.knowledge.traffic import with_aircraft
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.units import (
    UNKNOWN_16,
    deg_of_e7,
    enu_of_ned_cmps,
    m_of_mm,
    position_of_e7,
    yaw_of_centidegrees,
)

ARMED_FLAG = 0x80
PREARM_BIT = 1 << 28
# MAV_AUTOPILOT of a component without autopilot: a camera, a ground station.
NO_AUTOPILOT = 8
# Autopilot time that goes back by more means a restart; by less, a late message.
REBOOT_AFTER_S = 2.0
UNKNOWN_SATELLITES = 255
# POSITION_TARGET_TYPEMASK: latitude and longitude mean nothing.
POSITION_IGNORED = 3
Reducer = Callable[[VehicleTelemetry, Message, float], VehicleTelemetry]


def reduce(
    vehicle: VehicleTelemetry, message: Message, now_s: float, given_separation_m: float = math.nan
) -> tuple[VehicleTelemetry, list[Event]]:
    """Return what is known after a message, and the events.

    Messages of other senders change nothing.

    Parameters
    ----------
    now_s
        Steady time of arrival, seconds.
    given_separation_m
        Height of the geoid above the ellipsoid where the receiver does not tell, metres; NaN if
        not known.
    """
    if (message.system, message.component) != (vehicle.system, vehicle.component):
        return vehicle, []
    if message.name == 'STATUSTEXT':
        return vehicle, [Event(EventKind.TEXT, str(message['text']), int(message['severity']))]
    events = []
    if _has_rebooted(vehicle, message):
        # The time of its last heartbeat is kept: its silence counts from there.
        vehicle = VehicleTelemetry(
            system=vehicle.system, component=vehicle.component, heartbeat_s=vehicle.heartbeat_s
        )
        events.append(Event(EventKind.REBOOTED))
    reducer = _REDUCERS.get(message.name)
    after = vehicle if reducer is None else reducer(vehicle, message, now_s)
    if message.name == 'GPS_RAW_INT':
        after = _with_geoid(after, message, given_separation_m)
    return after, events + events_between(vehicle, after)


def _has_rebooted(vehicle: VehicleTelemetry, message: Message) -> bool:
    if message.name == 'HEARTBEAT':
        was_up = vehicle.autopilot is not None and vehicle.status > SystemStatus.CALIBRATING
        return was_up and message['system_status'] in (SystemStatus.UNINIT, SystemStatus.BOOT)
    if message.name == 'GLOBAL_POSITION_INT' and vehicle.motion is not None:
        return bool(vehicle.motion.boot_s - message['time_boot_ms'] / 1000.0 > REBOOT_AFTER_S)
    return False


def _heartbeat(vehicle: VehicleTelemetry, message: Message, now_s: float) -> VehicleTelemetry:
    if message['autopilot'] == NO_AUTOPILOT:
        return vehicle
    is_armed = bool(message['base_mode'] & ARMED_FLAG)
    mission = vehicle.mission
    if is_armed and not vehicle.is_armed:
        mission = replace(mission, reached=-1)
    heard = replace(
        vehicle,
        heartbeat_s=now_s,
        autopilot=message['autopilot'],
        vehicle_type=message['type'],
        custom_mode=message['custom_mode'],
        status=message['system_status'],
        is_armed=is_armed,
        mission=mission,
        # In another mode it flies elsewhere.
        aim=vehicle.aim if message['custom_mode'] == vehicle.custom_mode else None,
    )
    if heard.vehicle_type != GROUND_ROVER:
        return heard
    # It tells no landed state: it counts as in the air, which is under way, while it may drive.
    landed = Landed.IN_AIR if is_armed else Landed.ON_GROUND
    return replace(heard, landed=landed, has_flown=heard.has_flown or is_armed)


def _position(vehicle: VehicleTelemetry, message: Message, now_s: float) -> VehicleTelemetry:
    boot_s = message['time_boot_ms'] / 1000.0
    last = vehicle.motion
    if last is not None and boot_s < last.boot_s:
        # Overtaken on the way: a newer position is known already.
        return vehicle
    altitude_m = m_of_mm(message['alt'])
    motion = Motion(
        position=position_of_e7(
            message['lat'], message['lon'], altitude_m + vehicle.geoid_separation_m
        ),
        altitude_msl_m=altitude_m,
        height_above_home_m=m_of_mm(message['relative_alt']),
        velocity_enu_mps=enu_of_ned_cmps(message['vx'], message['vy'], message['vz']),
        yaw_rad=yaw_of_centidegrees(message['hdg']),
        boot_s=boot_s,
        heard_s=now_s,
    )
    jumped_s = now_s if _is_jump(last, motion) else vehicle.jumped_s
    return replace(vehicle, motion=motion, jumped_s=jumped_s)


def _is_jump(last: Motion | None, motion: Motion) -> bool:
    if last is None:
        return False
    # Positions are rounded: shorter times count as a fifth of a second.
    passed_s = max(motion.boot_s - last.boot_s, 0.2)
    return distance_m(last.position, motion.position) > LARGEST_SPEED_MPS * passed_s


def _gps(vehicle: VehicleTelemetry, message: Message, now_s: float) -> VehicleTelemetry:
    last = vehicle.gps
    is_new = message['time_usec'] != last.time_us
    satellites = message['satellites_visible']
    gps = Gps(
        fix_type=message['fix_type'],
        satellites=-1 if satellites == UNKNOWN_SATELLITES else satellites,
        time_us=message['time_usec'],
        changed_s=now_s if is_new else last.changed_s,
        horizontal_std_m=_accuracy_m(message['h_acc']),
        vertical_std_m=_accuracy_m(message['v_acc']),
    )
    return replace(vehicle, gps=gps)


def _accuracy_m(accuracy_mm: int) -> float:
    return m_of_mm(accuracy_mm) if accuracy_mm else math.nan


def _with_geoid(vehicle: VehicleTelemetry, message: Message, given_m: float) -> VehicleTelemetry:
    if vehicle.is_armed and math.isfinite(vehicle.geoid_separation_m):
        # Kept in flight: the track would step where the source changes.
        return vehicle
    found_m = separation_m(m_of_mm(message['alt']), m_of_mm(message['alt_ellipsoid']), given_m)
    return replace(vehicle, geoid_separation_m=found_m)


def _sys_status(vehicle: VehicleTelemetry, message: Message, _now_s: float) -> VehicleTelemetry:
    charge, current = message['battery_remaining'], message['current_battery']
    voltage = message['voltage_battery']
    battery = Battery(
        fraction=math.nan if charge < 0 else charge / 100.0,
        voltage_v=math.nan if voltage == UNKNOWN_16 else voltage / 1000.0,
        current_a=math.nan if current < 0 else current / 100.0,
    )
    is_ok = bool(message['onboard_control_sensors_health'] & PREARM_BIT)
    return replace(vehicle, battery=battery, is_prearm_ok=is_ok)


def _ekf(vehicle: VehicleTelemetry, message: Message, _now_s: float) -> VehicleTelemetry:
    return replace(vehicle, ekf_flags=message['flags'])


def _attitude(vehicle: VehicleTelemetry, message: Message, _now_s: float) -> VehicleTelemetry:
    # From forward, right, down to forward, left, up.
    attitude = Attitude(
        roll_rad=message['roll'],
        pitch_rad=-message['pitch'],
        yaw_rad=wrap_rad(yaw_of_heading_rad(message['yaw'])),
    )
    return replace(vehicle, attitude=attitude)


def _home(vehicle: VehicleTelemetry, message: Message, _now_s: float) -> VehicleTelemetry:
    home = Home(
        latitude_deg=deg_of_e7(message['latitude']),
        longitude_deg=deg_of_e7(message['longitude']),
        altitude_msl_m=m_of_mm(message['altitude']),
    )
    return replace(vehicle, home=home)


def _landed(vehicle: VehicleTelemetry, message: Message, _now_s: float) -> VehicleTelemetry:
    if vehicle.vehicle_type == GROUND_ROVER:
        return vehicle
    value = message['landed_state']
    landed = Landed(value) if value in set(Landed) else Landed.UNDEFINED
    is_in_air = vehicle.is_armed and landed in (Landed.IN_AIR, Landed.TAKEOFF, Landed.LANDING)
    return replace(vehicle, landed=landed, has_flown=vehicle.has_flown or is_in_air)


def _mission(vehicle: VehicleTelemetry, message: Message, _now_s: float) -> VehicleTelemetry:
    value = message['mission_state']
    phase = MissionPhase(value) if value in set(MissionPhase) else MissionPhase.UNKNOWN
    # Older autopilots do not tell the number of items.
    total = message.fields.get('total', 0)
    mission = replace(vehicle.mission, current=message['seq'], phase=phase, total=total)
    return replace(vehicle, mission=mission)


def _reached(vehicle: VehicleTelemetry, message: Message, _now_s: float) -> VehicleTelemetry:
    reached = max(vehicle.mission.reached, message['seq'])
    return replace(vehicle, mission=replace(vehicle.mission, reached=reached))


def _aim(vehicle: VehicleTelemetry, message: Message, _now_s: float) -> VehicleTelemetry:
    if message['type_mask'] & POSITION_IGNORED:
        return vehicle
    aim = Aim(
        latitude_deg=deg_of_e7(message['lat_int']),
        longitude_deg=deg_of_e7(message['lon_int']),
        altitude_msl_m=float(message['alt']),
    )
    return replace(vehicle, aim=aim, tells_aim=True)


def _fence(vehicle: VehicleTelemetry, message: Message, _now_s: float) -> VehicleTelemetry:
    return replace(vehicle, is_fence_breached=bool(message['breach_status']))


def _wind(vehicle: VehicleTelemetry, message: Message, now_s: float) -> VehicleTelemetry:
    if message.name == 'WIND':
        speed_mps = message['speed']
    else:
        speed_mps = math.hypot(message['wind_x'], message['wind_y'])
    return replace(vehicle, wind=vehicle.wind.after(float(speed_mps), now_s))


_REDUCERS: Mapping[str, Reducer] = {
    'ADSB_VEHICLE': with_aircraft,
    'ATTITUDE': _attitude,
    'EKF_STATUS_REPORT': _ekf,
    'ESTIMATOR_STATUS': _ekf,
    'EXTENDED_SYS_STATE': _landed,
    'FENCE_STATUS': _fence,
    'GLOBAL_POSITION_INT': _position,
    'GPS_RAW_INT': _gps,
    'HEARTBEAT': _heartbeat,
    'HOME_POSITION': _home,
    'MISSION_CURRENT': _mission,
    'MISSION_ITEM_REACHED': _reached,
    'POSITION_TARGET_GLOBAL_INT': _aim,
    'SYS_STATUS': _sys_status,
    'WIND': _wind,
    'WIND_COV': _wind,
}

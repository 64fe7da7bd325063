# SPDX-License-Identifier: Apache-2.0
"""What an ArduCopter says, in order, with the numbers that were recorded from one."""

from rocsafe_mavlink.knowledge.reducer import reduce
from rocsafe_mavlink.knowledge.telemetry import VehicleTelemetry
from rocsafe_mavlink.wire.dialect import Message

EKF_GOOD, EKF_LOST = 831, 37
PREARM = 1 << 28


def said(name, **fields):
    """Return a message of system 1, component 1."""
    return Message(name, fields, 1, 1)


def heartbeat(mode=4, *, armed=False, status=3):
    """Return a heartbeat of a quadrotor."""
    return said(
        'HEARTBEAT',
        type=2,
        autopilot=3,
        base_mode=0x80 if armed else 0,
        custom_mode=mode,
        system_status=status,
    )


def position(boot_s=50.0, **changes):
    """Return a position at the recorded home, 488 m above the sea."""
    fields = {
        'time_boot_ms': round(boot_s * 1000),
        'lat': 473977420,
        'lon': 85455940,
        'alt': 488000,
        'relative_alt': 0,
        'vx': 100,
        'vy': -200,
        'vz': 50,
        'hdg': 9000,
    }
    return said('GLOBAL_POSITION_INT', **{**fields, **changes})


def gps(time_us=1_000_000, **changes):
    """Return a good fix without an ellipsoidal altitude."""
    fields = {
        'time_usec': time_us,
        'fix_type': 6,
        'alt': 488000,
        'alt_ellipsoid': 488000,
        'satellites_visible': 10,
        'h_acc': 300,
        'v_acc': 500,
    }
    return said('GPS_RAW_INT', **{**fields, **changes})


def landed(state):
    """Return EXTENDED_SYS_STATE."""
    return said('EXTENDED_SYS_STATE', landed_state=state)


def mission(current, phase=3):
    """Return MISSION_CURRENT."""
    return said('MISSION_CURRENT', seq=current, mission_state=phase)


def after(*messages, vehicle=None, now_s=100.0, **options):
    """Return a vehicle after messages that all came at `now_s`."""
    state = VehicleTelemetry(system=1, component=1) if vehicle is None else vehicle
    for message in messages:
        state, _ = reduce(state, message, now_s, **options)
    return state


def ready(**options):
    """Return a vehicle that stands ready in GUIDED."""
    return after(
        heartbeat(),
        gps(),
        said('EKF_STATUS_REPORT', flags=EKF_GOOD),
        said(
            'SYS_STATUS',
            onboard_control_sensors_health=PREARM,
            battery_remaining=80,
            voltage_battery=12600,
            current_battery=2800,
        ),
        said('HOME_POSITION', latitude=473977420, longitude=85455940, altitude=488000),
        landed(1),
        mission(0, 2),
        position(),
        **options,
    )

# SPDX-License-Identifier: Apache-2.0
"""Orders to the light of a scene, out of messages."""

from rocsafe_interfaces.srv import SetLight
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_scene.scene.moving_sun import LightOrder, MovingSun
from rocsafe_scene.scene.sunlight import Air


def light_of(request: SetLight.Request, now_ns: int) -> LightOrder:
    """Return the light that is asked for at a simulated time.

    Raises
    ------
    ValueError
        If a value is out of range.
    """
    air = Air(fog=request.fog, wetness=request.wetness)
    if request.sun_as_scenario:
        return LightOrder(air=air)
    sun = MovingSun(
        sun_ns=ns_of_stamp(request.sun_time),
        from_ns=now_ns,
        speed=request.sun_speed,
        step_s=request.sun_step_s,
    )
    return LightOrder(sun=sun, air=air)

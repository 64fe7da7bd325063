# SPDX-License-Identifier: Apache-2.0
"""Every service and action of ROCSAFE: name, type, scope.

Names are relative as in `rocsafe_ros.interfaces.topics`. `make docs` writes docs/interfaces.md
from both.
"""

from std_srvs.srv import SetBool, Trigger

from rocsafe_interfaces.action import DriveRoute, FlyRoute, PlanGroundRoute, PlanSurvey
from rocsafe_interfaces.srv import (
    FleetCommand,
    GoTo,
    Lease,
    Look,
    Move,
    Preflight,
    PushFence,
    PushRally,
    QueryRadiationField,
    Resume,
    SetFieldOfView,
    SetHome,
    SetLight,
    SetSpeed,
    SetWind,
    SuggestViewpoints,
)
from rocsafe_ros.interfaces.interface_spec import CallSpec, Scope


def _call(name: str, call_type: type, kind: str, scope: Scope, note: str) -> CallSpec:
    return CallSpec(name=name, call_type=call_type, kind=kind, scope=scope, note=note)


FLY_ROUTE = _call('fly_route', FlyRoute, 'action', Scope.VEHICLE, 'fly, photograph, return, land')
DRIVE_ROUTE = _call(
    'drive_route', DriveRoute, 'action', Scope.VEHICLE, 'drive to evidence, photograph it, return'
)
HOLD = _call('hold', Trigger, 'service', Scope.VEHICLE, 'stand still in the air')
RESUME = _call('resume', Resume, 'service', Scope.VEHICLE, 'go on after hold')
RETURN_HOME = _call('return_home', Trigger, 'service', Scope.VEHICLE, 'give up the route')
LAND = _call('land', Trigger, 'service', Scope.VEHICLE, 'land where it is')
LEASE = _call('lease', Lease, 'service', Scope.VEHICLE, 'take, renew or give back the control')
PREFLIGHT = _call('preflight', Preflight, 'service', Scope.VEHICLE, 'checks of a real vehicle')
GO_TO = _call('go_to', GoTo, 'service', Scope.VEHICLE, 'fly to a point and stay there')
LOOK = _call(
    'camera/look', Look, 'service', Scope.VEHICLE, 'an image now; simulated vehicles only'
)
SET_FOV = _call(
    'camera/set_fov',
    SetFieldOfView,
    'service',
    Scope.VEHICLE,
    'of looks and streams; simulated only',
)
MOVE = _call('move', Move, 'service', Scope.VEHICLE, 'fly freely; simulated vehicles only')
SET_WIND = _call('set_wind', SetWind, 'service', Scope.VEHICLE, 'wind of simulated vehicles only')
SET_LIGHT = _call('set_light', SetLight, 'service', Scope.VEHICLE, 'sun and fog of a drawn scene')
SET_SCENE_LIGHT = _call(
    'scene/set_light', SetLight, 'service', Scope.FLEET, 'sun and fog of the live view'
)
SET_SPEED = _call('set_speed', SetSpeed, 'service', Scope.VEHICLE, 'speed over ground')
PUSH_FENCE = _call('geofence/push', PushFence, 'service', Scope.VEHICLE, 'replace the fence')
PUSH_RALLY = _call('rallypoint/push', PushRally, 'service', Scope.VEHICLE, 'replace rally points')
SET_HOME = _call(
    'set_home', SetHome, 'service', Scope.VEHICLE, 'before take-off; simulated vehicles only'
)
PLAN_SURVEY = _call('plan_survey', PlanSurvey, 'action', Scope.FLEET, 'region to routes')
PLAN_GROUND_ROUTE = _call(
    'plan_ground_route', PlanGroundRoute, 'action', Scope.FLEET, 'evidence to a drive and back'
)
QUERY_FIELD = _call(
    'radiation_field/query', QueryRadiationField, 'service', Scope.FLEET, 'dose rates at points'
)
SUGGEST_VIEWPOINTS = _call(
    'hazard/suggest_viewpoints', SuggestViewpoints, 'service', Scope.FLEET, 'where to measure next'
)
SUGGEST_GAS_VIEWPOINTS = _call(
    'hazard/suggest_gas_viewpoints',
    SuggestViewpoints,
    'service',
    Scope.FLEET,
    'where to measure gas next',
)
WORLD_RUN = _call('world/run', SetBool, 'service', Scope.FLEET, 'start or pause simulated time')
FLEET_HOLD = _call('fleet/hold', FleetCommand, 'service', Scope.FLEET, 'hold of all vehicles')
FLEET_RESUME = _call('fleet/resume', FleetCommand, 'service', Scope.FLEET, 'all go on after hold')
FLEET_RETURN_HOME = _call(
    'fleet/return_home', FleetCommand, 'service', Scope.FLEET, 'all give up their routes'
)
FLEET_LAND = _call('fleet/land', FleetCommand, 'service', Scope.FLEET, 'all land where they are')
REPLAN = _call('mission/replan', Trigger, 'service', Scope.FLEET, 'plan the rest anew')
SAVE_MOSAIC = _call('mosaic/save', Trigger, 'service', Scope.FLEET, 'write the map now')

CALLS = tuple(value for value in tuple(globals().values()) if isinstance(value, CallSpec))
"""All of the above, in their order."""

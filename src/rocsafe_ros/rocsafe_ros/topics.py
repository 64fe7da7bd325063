# SPDX-License-Identifier: Apache-2.0
"""Every topic, service and action of ROCSAFE: name, type, quality of service, rate.

Names are relative. A name of vehicle scope is in the namespace of a vehicle (``rav1/fix``), a
name of fleet scope in that above. `make docs` writes docs/interfaces.md from this module.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum
from typing import Any, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rcl_interfaces.msg import Log
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import (
    BatteryState,
    CameraInfo,
    CompressedImage,
    FluidPressure,
    Image,
    Imu,
    MagneticField,
    NavSatFix,
    Range,
)
from std_msgs.msg import Float64, String, UInt8MultiArray
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from rocsafe_interfaces.action import DriveRoute, FlyRoute, PlanGroundRoute, PlanSurvey
from rocsafe_interfaces.msg import (
    AccumulatedDose,
    AgentAdvice,
    AgentReport,
    AgentState,
    Control,
    Decision,
    DoseAlarm,
    DoseRate,
    EvidencePointArray,
    FleetPacket,
    GasReading,
    GeoPoint,
    GeotaggedImage,
    GimbalCommand,
    GimbalState,
    GroundRoute,
    HazardSourceArray,
    MissionState,
    Mosaic,
    ParticleReading,
    RadiationReading,
    Region,
    ReleaseEstimateArray,
    ShotReceipt,
    StepDone,
    SurveyPlan,
    Traffic,
    VehicleEvent,
    VehicleState,
    WindReading,
)
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
    SetHome,
    SetLight,
    SetSpeed,
    SetWind,
    SuggestViewpoints,
)
from rocsafe_ros.vehicle_scope import VehicleScopeNode

# One minute of one vehicle's readings at 10 Hz, for a subscriber that falls behind.
STREAM_DEPTH = 600
# Measurements that pass at full speed during the discovery of a subscriber; more would only fill
# an operator's `ros2 topic echo` with history.
MEASUREMENTS_KEPT = 50
# Images are large; a subscriber that was away for longer finds them in the image store.
PICTURES_KEPT = 8
# States that a recorder which falls behind does not miss: at full speed several come at once.
STATES_KEPT = 10
# All decisions of a mission, so that a late subscriber gets all of them.
DECISIONS_KEPT = 500
# Topics of a further camera have its name instead of this one.
FIRST_CAMERA = 'camera'
# A vehicle without a heartbeat for this long is taken for lost.
HEARTBEAT_LEASE_S = 2.0


class Scope(Enum):
    """The namespace that a name is relative to: of a vehicle or of the fleet."""

    VEHICLE = 'vehicle'
    FLEET = 'fleet'


def _stream() -> QoSProfile:
    return QoSProfile(depth=STREAM_DEPTH, reliability=ReliabilityPolicy.RELIABLE)


def _newest() -> QoSProfile:
    """Return a stream of orders each of which replaces the ones before: none is followed late."""
    return QoSProfile(depth=STATES_KEPT, reliability=ReliabilityPolicy.RELIABLE)


def _kept(depth: int = MEASUREMENTS_KEPT) -> QoSProfile:
    """Return a stream whose last `depth` messages also reach late subscribers.

    A recorder or field that is started again, or discovers a vehicle late, misses nothing.
    Subscribers that do not ask for transient local messages are served as by any stream.
    """
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )


def _pictures() -> QoSProfile:
    return QoSProfile(depth=PICTURES_KEPT, reliability=ReliabilityPolicy.RELIABLE)


def _radio() -> QoSProfile:
    """Return a stream whose lost messages are not sent again: who sends repairs that itself."""
    return QoSProfile(depth=MEASUREMENTS_KEPT, reliability=ReliabilityPolicy.BEST_EFFORT)


def _latched() -> QoSProfile:
    return _kept(1)


def _heartbeat() -> QoSProfile:
    profile = _kept(STATES_KEPT)
    profile.liveliness = LivelinessPolicy.AUTOMATIC
    profile.liveliness_lease_duration = Duration(seconds=HEARTBEAT_LEASE_S)
    profile.deadline = Duration(seconds=HEARTBEAT_LEASE_S)
    return profile


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicSpec:
    """One topic.

    Attributes
    ----------
    name
        Name relative to the namespace of `scope`.
    message_type
        Class of its messages.
    qos
        Quality of service offered by its publisher.
    rate
        Its rate, as text for readers.
    note
        Its meaning, as text for readers.
    is_state
        Whether a message makes all earlier ones out of date for whoever acts on it. A publisher
        may keep more of them, for those who record.
    """

    name: str
    message_type: type
    qos: QoSProfile
    scope: Scope
    rate: str
    note: str
    is_state: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class CallSpec:
    """One service or action: `kind` is ``'service'`` or ``'action'``."""

    name: str
    call_type: type
    kind: str
    scope: Scope
    note: str


CameraSpec = TypeVar('CameraSpec', TopicSpec, CallSpec)


def _vehicle(name: str, message_type: type, qos: QoSProfile, rate: str, note: str) -> TopicSpec:
    return _topic(Scope.VEHICLE, name, message_type, qos, rate, note)


def _fleet(name: str, message_type: type, qos: QoSProfile, rate: str, note: str) -> TopicSpec:
    return _topic(Scope.FLEET, name, message_type, qos, rate, note)


def _topic(
    scope: Scope, name: str, message_type: type, qos: QoSProfile, rate: str, note: str
) -> TopicSpec:
    return TopicSpec(
        name=name, message_type=message_type, qos=qos, scope=scope, rate=rate, note=note,
        is_state=qos.depth in (1, STATES_KEPT),
    )  # fmt: skip


FIX = _vehicle('fix', NavSatFix, _kept(), '5 Hz', 'position, altitude above the ellipsoid')
GROUND_TRUTH_FIX = _vehicle(
    'ground_truth/fix', NavSatFix, _kept(), 'as fix', 'true position, simulated vehicles only'
)
VELOCITY = _vehicle('velocity', TwistStamped, _kept(), 'as fix', 'east, north, up, m/s')
ODOM = _vehicle('odom', Odometry, _kept(), 'as fix', 'ENU about the mission origin')
BATTERY_STATE = _vehicle('battery_state', BatteryState, _kept(), '1 Hz', 'charge left')
STATE = _vehicle('state', VehicleState, _heartbeat(), '1 Hz and on change', 'state and heartbeat')
IMU = _vehicle('imu', Imu, _stream(), 'as asked', 'body axes; simulated vehicles, if asked for')
BAROMETER = _vehicle('barometer', FluidPressure, _stream(), 'as asked', 'as imu: pressure, Pa')
MAGNETOMETER = _vehicle(
    'magnetometer', MagneticField, _stream(), 'as asked', 'as imu: field along the body axes, T'
)
RANGE = _vehicle('range', Range, _stream(), 'as asked', 'as imu: distance along its beam, m')
RADIATION = _vehicle('radiation', RadiationReading, _kept(), 'as fix', 'gamma dose rate, uSv/h')
GAS = _vehicle('gas', GasReading, _kept(), 'each window', 'a reading of each gas sensor')
BIO = _vehicle('bio', ParticleReading, _kept(), 'each window', 'counts of particles, trigger')
ANEMOMETER = _vehicle(
    'anemometer', WindReading, _kept(), 'each window', 'where the air goes to, m/s'
)
DETECTOR_BYTES = _vehicle(
    'detector/bytes', UInt8MultiArray, _kept(), 'as sent', 'of MAVLink TUNNEL, real ones only'
)
DOSE_RATE = _vehicle(
    'dose_rate', DoseRate, _kept(), 'each reading', 'the same in Sv/h, as radiation_msgs has it'
)
ACCUMULATED_DOSE = _vehicle(
    'accumulated_dose', AccumulatedDose, _kept(), 'each reading', 'dose since the first reading'
)
DOSE_ALARM = _vehicle(
    'dose_alarm', DoseAlarm, _kept(), 'on change', 'level of dose rate or dose reached or left'
)
CAMERA_IMAGE = _vehicle(
    'camera/image_raw', Image, _pictures(), 'each shot, or streamed', 'only while somebody listens'
)
CAMERA_IMAGE_COMPRESSED = _vehicle(
    'camera/image_raw/compressed',
    CompressedImage,
    _kept(PICTURES_KEPT),
    'each shot, or streamed',
    'JPEG, for viewers',
)
CAMERA_INFO = _vehicle(
    'camera/camera_info', CameraInfo, _kept(PICTURES_KEPT), 'as the pictures', 'intrinsics'
)
CAMERA_DEPTH = _vehicle(
    'camera/depth', Image, _pictures(), 'as image_raw', 'metres, 32FC1; engine only, while heard'
)
CAMERA_LABELS = _vehicle(
    'camera/labels',
    Image,
    _pictures(),
    'as image_raw',
    'instances, mono16; engine only, while heard',
)
CAMERA_LABEL_TABLE = _vehicle(
    'camera/label_table',
    String,
    _latched(),
    'once',
    'JSON: number, name, class, colour; place and yaw of what stands',
)
CAMERA_POSE = _vehicle(
    'camera/pose', PoseStamped, _pictures(), 'as image_raw', 'true, of the optical frame'
)
CMD_VEL = _vehicle(
    'cmd_vel',
    TwistStamped,
    _newest(),
    'by a program',
    'see move; simulated vehicles only',
)
GIMBAL_COMMAND = _vehicle(
    'camera/gimbal/command', GimbalCommand, _stream(), 'by the operator', 'where to point it'
)
GIMBAL_STATE = _vehicle(
    'camera/gimbal/state', GimbalState, _kept(), '1 Hz and on change', 'where it points'
)
SHOT = _vehicle(
    'camera/shot', GeotaggedImage, _stream(), 'each shot, until its receipt', 'photograph and pose'
)
PATH = _vehicle('path', Path, _latched(), '1 Hz while watched, else 0.1 Hz', 'whole flown track')
ROUTE_MARKERS = _vehicle('route_markers', MarkerArray, _latched(), 'on change', 'planned route')
REL_ALT = _vehicle(
    'rel_alt', Float64, _stream(), 'as fix', 'height above home, real vehicles only'
)
HEADING = _vehicle('heading', Float64, _stream(), 'as fix', 'degrees, real vehicles only')
HOME = _vehicle('home', GeoPoint, _latched(), 'on change', 'where it returns')
CONTROL = _vehicle('control', Control, _latched(), 'on change', 'who may give it orders')
PREDICTED_FIX = _vehicle(
    'predicted_fix', NavSatFix, _kept(), '1 Hz while silent', 'where it should be, real ones only'
)
TRAFFIC = _vehicle(
    'traffic', Traffic, _kept(), 'as heard', 'other aircraft heard, real vehicles only'
)
EVENTS = _vehicle(
    'events', VehicleEvent, _kept(), 'on change', 'what happened, real vehicles only'
)

REGION = _fleet('region', Region, _latched(), 'on change', 'what the operator drew')
PLAN = _fleet('plan', SurveyPlan, _latched(), 'on change', 'routes of all vehicles, with bound')
MISSION_STATE = _fleet(
    'mission/state', MissionState, _kept(STATES_KEPT), '2 Hz', 'phase and progress'
)
DECISIONS = _fleet(
    'decisions', Decision, _kept(DECISIONS_KEPT), 'on change', 'what was decided, by whom, why'
)
RECEIPTS = _fleet('shots/receipts', ShotReceipt, _kept(), 'each shot', 'photograph is stored')
HAZARD_SOURCES = _fleet('hazard/sources', HazardSourceArray, _latched(), 'on change', 'estimates')
DOSE_MAP = _fleet('hazard/dose_map', OccupancyGrid, _latched(), 'on change', 'dose rate, log')
CORDONS = _fleet(
    'hazard/cordons', MarkerArray, _latched(), 'on change', 'ground above levels of dose rate'
)
BELIEF_MAP = _fleet(
    'hazard/belief', OccupancyGrid, _latched(), 'on change', 'probability of a source, percent'
)
FLEET_DELTA = _fleet(
    'fleet/delta', FleetPacket, _radio(), '1 Hz an agent and on change', 'packets between agents'
)
AGENTS = _fleet(
    'fleet/agents', AgentState, _kept(), '1 Hz an agent', 'what each agent knows of its fleet'
)
EVIDENCE = _fleet(
    'evidence', EvidencePointArray, _latched(), 'on change', 'where a ground vehicle is sent'
)
GROUND_ROUTE = _fleet(
    'ground/route', GroundRoute, _latched(), 'on change', 'drive of a ground vehicle, with bound'
)
GROUND_PATH = _fleet('ground/path', Path, _latched(), 'on change', 'the same, poses for Nav2')
GROUND_COSTS = _fleet(
    'ground/costs', OccupancyGrid, _latched(), 'on change', 'where it can drive; dose rate, log'
)
AGENT_REPORTS = _fleet(
    'hazard/reports', AgentReport, _kept(), 'as told', 'what people say of the agent'
)
AGENT = _fleet(
    'hazard/agent', AgentAdvice, _latched(), 'on change', 'which agent, procedures that fit'
)
RELEASES = _fleet(
    'hazard/release', ReleaseEstimateArray, _latched(), 'on change', 'estimated releases of gas'
)
PLUME = _fleet('hazard/plume', OccupancyGrid, _latched(), 'on change', 'concentration, log ppm')
THREAT_ZONES = _fleet(
    'hazard/threat_zones', MarkerArray, _latched(), 'on change', 'ground above response levels'
)
MOSAIC = _fleet('mosaic', Mosaic, _latched(), 'on change', 'map: preview and file')
DRAWINGS = _fleet(
    'drawings',
    MarkerArray,
    _latched(),
    'on change',
    'lines, points and texts of clients of AirSim',
)
SCENE_VIEW = _fleet(
    'scene/view', CompressedImage, _stream(), '5 Hz while heard', 'live view: rocsafe scene show'
)
SCENE_MARKERS = _fleet('scene/markers', MarkerArray, _latched(), 'once', 'simulated objects')
STEP_DONE = _fleet('sim/step_done', StepDone, _stream(), 'each step', 'lock-step of time')
CLOCK = _fleet('/clock', Clock, _stream(), 'each step', 'simulated time')
TF = _fleet('/tf', TFMessage, _stream(), 'as odom', 'frames that move, see ros.md')
# Many publish here, each once: a subscriber that kept one message would have one of them.
TF_STATIC = _fleet('/tf_static', TFMessage, _kept(), 'once', 'frames that are fixed')
ROSOUT = _fleet('/rosout', Log, _stream(), 'on change', 'log of all nodes')
DIAGNOSTICS = _fleet('/diagnostics', DiagnosticArray, _stream(), '1 Hz', 'health of the nodes')

TOPICS = tuple(value for value in tuple(globals().values()) if isinstance(value, TopicSpec))
"""All of the above, in their order."""

FROM_ANYBODY = (CMD_VEL, GIMBAL_COMMAND, DRAWINGS, AGENT_REPORTS)
"""What people and programs beside a mission publish to it; all else it hears from its own only."""


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


def name_of(spec: TopicSpec | CallSpec, vehicle: str = '') -> str:
    """Return the relative name of `spec`, below `vehicle` if one is named.

    Raises
    ------
    ValueError
        If a vehicle is named for a name of fleet scope.
    """
    if not vehicle:
        return spec.name
    if spec.scope is not Scope.VEHICLE:
        raise ValueError(f'{spec.name} belongs to the fleet, not to vehicle {vehicle!r}')
    return f'{vehicle}/{spec.name}'


def of_camera(spec: CameraSpec, camera: str) -> CameraSpec:
    """Return the topic or service of `camera` that corresponds to `spec` of the first camera.

    Raises
    ------
    ValueError
        If `spec` is not of a camera.
    """
    first, _, rest = spec.name.partition('/')
    if first != FIRST_CAMERA or not rest:
        raise ValueError(f'{spec.name} is not of a camera: must begin with {FIRST_CAMERA}/')
    return replace(spec, name=f'{camera}/{rest}')


def _name_from(node: Node, spec: TopicSpec, vehicle: str) -> str:
    """Return the name under which `node` reaches `spec`."""
    name = name_of(spec, vehicle)
    if spec.scope is Scope.FLEET and isinstance(node, VehicleScopeNode):
        return name if name.startswith('/') else f'{node.fleet_namespace}/{name}'
    return name


def create_publisher(node: Node, spec: TopicSpec, vehicle: str = '') -> Publisher:
    """Publish `spec` from `node`; name `vehicle` if the node is outside of its namespace."""
    return node.create_publisher(spec.message_type, _name_from(node, spec, vehicle), spec.qos)


def create_subscription(
    node: Node,
    spec: TopicSpec,
    callback: Callable[[Any], None],
    vehicle: str = '',
    *,
    is_recording: bool = False,
) -> Subscription:
    """Subscribe `node` to every message of `spec`: nothing is lost up to the depth of its queue.

    Of a state it gets the newest. The deadline of a heartbeat is offered but not requested, so a
    slow simulation is no fault. With `is_recording` the callback gets the serialised bytes, of a
    state every message.
    """
    qos = QoSProfile(
        depth=1 if spec.is_state and not is_recording else STREAM_DEPTH,
        reliability=spec.qos.reliability,
        durability=spec.qos.durability,
    )
    return node.create_subscription(
        spec.message_type, _name_from(node, spec, vehicle), callback, qos, raw=is_recording
    )

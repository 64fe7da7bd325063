# SPDX-License-Identifier: Apache-2.0
"""Every topic of ROCSAFE: name, type, quality of service, rate.

Services and actions are in `rocsafe_ros.interfaces.calls`.
Names are relative. A name of vehicle scope is in the namespace of a vehicle (``rav1/fix``), a
name of fleet scope in that above. `make docs` writes docs/interfaces.md from this module.
"""

from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rcl_interfaces.msg import Log
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
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
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

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
from rocsafe_ros.interfaces.interface_spec import Scope, TopicSpec, name_of
from rocsafe_ros.interfaces.qos import (
    DECISIONS_KEPT,
    PICTURES_KEPT,
    STATES_KEPT,
    STREAM_DEPTH,
    heartbeat,
    kept,
    latched,
    newest,
    pictures,
    radio,
    stream,
)
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode


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


FIX = _vehicle('fix', NavSatFix, kept(), '5 Hz', 'position, altitude above the ellipsoid')
GROUND_TRUTH_FIX = _vehicle(
    'ground_truth/fix', NavSatFix, kept(), 'as fix', 'true position, simulated vehicles only'
)
VELOCITY = _vehicle('velocity', TwistStamped, kept(), 'as fix', 'east, north, up, m/s')
ODOM = _vehicle('odom', Odometry, kept(), 'as fix', 'ENU about the mission origin')
BATTERY_STATE = _vehicle('battery_state', BatteryState, kept(), '1 Hz', 'charge left')
STATE = _vehicle('state', VehicleState, heartbeat(), '1 Hz and on change', 'state and heartbeat')
IMU = _vehicle('imu', Imu, stream(), 'as asked', 'body axes; simulated vehicles, if asked for')
BAROMETER = _vehicle('barometer', FluidPressure, stream(), 'as asked', 'as imu: pressure, Pa')
MAGNETOMETER = _vehicle(
    'magnetometer', MagneticField, stream(), 'as asked', 'as imu: field along the body axes, T'
)
RANGE = _vehicle('range', Range, stream(), 'as asked', 'as imu: distance along its beam, m')
RADIATION = _vehicle('radiation', RadiationReading, kept(), 'as fix', 'gamma dose rate, uSv/h')
GAS = _vehicle('gas', GasReading, kept(), 'each window', 'a reading of each gas sensor')
BIO = _vehicle('bio', ParticleReading, kept(), 'each window', 'counts of particles, trigger')
ANEMOMETER = _vehicle(
    'anemometer', WindReading, kept(), 'each window', 'where the air goes to, m/s'
)
DETECTOR_BYTES = _vehicle(
    'detector/bytes', UInt8MultiArray, kept(), 'as sent', 'of MAVLink TUNNEL, real ones only'
)
DOSE_RATE = _vehicle(
    'dose_rate', DoseRate, kept(), 'each reading', 'the same in Sv/h, as radiation_msgs has it'
)
ACCUMULATED_DOSE = _vehicle(
    'accumulated_dose', AccumulatedDose, kept(), 'up to 1 Hz', 'dose since the first reading'
)
DOSE_ALARM = _vehicle(
    'dose_alarm', DoseAlarm, kept(), 'on change', 'level of dose rate or dose reached or left'
)
CAMERA_IMAGE = _vehicle(
    'camera/image_raw', Image, pictures(), 'each shot, or streamed', 'only while somebody listens'
)
CAMERA_IMAGE_COMPRESSED = _vehicle(
    'camera/image_raw/compressed',
    CompressedImage,
    kept(PICTURES_KEPT),
    'each shot, or streamed',
    'JPEG, for viewers',
)
CAMERA_INFO = _vehicle(
    'camera/camera_info', CameraInfo, kept(PICTURES_KEPT), 'as the pictures', 'intrinsics'
)
CAMERA_DEPTH = _vehicle(
    'camera/depth', Image, pictures(), 'as image_raw', 'metres, 32FC1; engine only, while heard'
)
CAMERA_LABELS = _vehicle(
    'camera/labels',
    Image,
    pictures(),
    'as image_raw',
    'instances, mono16; engine only, while heard',
)
CAMERA_LABEL_TABLE = _vehicle(
    'camera/label_table',
    String,
    latched(),
    'once',
    'JSON: number, name, class, colour; place and yaw of what stands',
)
CAMERA_POSE = _vehicle(
    'camera/pose', PoseStamped, pictures(), 'as image_raw', 'true, of the optical frame'
)
CMD_VEL = _vehicle(
    'cmd_vel',
    TwistStamped,
    newest(),
    'by a program',
    'see move; simulated vehicles only',
)
GIMBAL_COMMAND = _vehicle(
    'camera/gimbal/command', GimbalCommand, stream(), 'by the operator', 'where to point it'
)
GIMBAL_STATE = _vehicle(
    'camera/gimbal/state', GimbalState, kept(), '1 Hz and on change', 'where it points'
)
SHOT = _vehicle(
    'camera/shot', GeotaggedImage, stream(), 'each shot, until its receipt', 'photograph and pose'
)
PATH = _vehicle('path', Path, latched(), '1 Hz while watched, else 0.1 Hz', 'whole flown track')
ROUTE_MARKERS = _vehicle('route_markers', MarkerArray, latched(), 'on change', 'planned route')
REL_ALT = _vehicle('rel_alt', Float64, stream(), 'as fix', 'height above home, real vehicles only')
HEADING = _vehicle('heading', Float64, stream(), 'as fix', 'degrees, real vehicles only')
HOME = _vehicle('home', GeoPoint, latched(), 'on change', 'where it returns')
CONTROL = _vehicle('control', Control, latched(), 'on change', 'who may give it orders')
PREDICTED_FIX = _vehicle(
    'predicted_fix', NavSatFix, kept(), '1 Hz while silent', 'where it should be, real ones only'
)
TRAFFIC = _vehicle(
    'traffic', Traffic, kept(), 'as heard', 'other aircraft heard, real vehicles only'
)
EVENTS = _vehicle('events', VehicleEvent, kept(), 'on change', 'what happened, real vehicles only')

REGION = _fleet('region', Region, latched(), 'on change', 'what the operator drew')
PLAN = _fleet('plan', SurveyPlan, latched(), 'on change', 'routes of all vehicles, with bound')
MISSION_STATE = _fleet(
    'mission/state', MissionState, kept(STATES_KEPT), '2 Hz', 'phase and progress'
)
DECISIONS = _fleet(
    'decisions', Decision, kept(DECISIONS_KEPT), 'on change', 'what was decided, by whom, why'
)
RECEIPTS = _fleet('shots/receipts', ShotReceipt, kept(), 'each shot', 'photograph is stored')
HAZARD_SOURCES = _fleet('hazard/sources', HazardSourceArray, latched(), 'on change', 'estimates')
DOSE_MAP = _fleet('hazard/dose_map', OccupancyGrid, latched(), 'on change', 'dose rate, log')
CORDONS = _fleet(
    'hazard/cordons', MarkerArray, latched(), 'on change', 'ground above levels of dose rate'
)
BELIEF_MAP = _fleet(
    'hazard/belief', OccupancyGrid, latched(), 'on change', 'probability of a source, percent'
)
FLEET_DELTA = _fleet(
    'fleet/delta', FleetPacket, radio(), '1 Hz an agent and on change', 'packets between agents'
)
AGENTS = _fleet(
    'fleet/agents', AgentState, kept(), '1 Hz an agent', 'what each agent knows of its fleet'
)
EVIDENCE = _fleet(
    'evidence', EvidencePointArray, latched(), 'on change', 'where a ground vehicle is sent'
)
GROUND_ROUTE = _fleet(
    'ground/route', GroundRoute, latched(), 'on change', 'drive of a ground vehicle, with bound'
)
GROUND_PATH = _fleet('ground/path', Path, latched(), 'on change', 'the same, poses for Nav2')
GROUND_COSTS = _fleet(
    'ground/costs', OccupancyGrid, latched(), 'on change', 'where it can drive; dose rate, log'
)
# Kept messages would be heard only from publishers that keep theirs: `ros2 topic pub` does not.
AGENT_REPORTS = _fleet(
    'hazard/reports', AgentReport, stream(), 'as told', 'what people say of the agent'
)
AGENT = _fleet(
    'hazard/agent', AgentAdvice, latched(), 'on change', 'which agent, procedures that fit'
)
RELEASES = _fleet(
    'hazard/release', ReleaseEstimateArray, latched(), 'on change', 'estimated releases of gas'
)
PLUME = _fleet('hazard/plume', OccupancyGrid, latched(), 'on change', 'concentration, log ppm')
THREAT_ZONES = _fleet(
    'hazard/threat_zones', MarkerArray, latched(), 'on change', 'ground above response levels'
)
MOSAIC = _fleet('mosaic', Mosaic, latched(), 'on change', 'map: preview and file')
DRAWINGS = _fleet(
    'drawings',
    MarkerArray,
    latched(),
    'on change',
    'lines, points and texts of clients of AirSim',
)
SCENE_VIEW = _fleet(
    'scene/view', CompressedImage, stream(), '5 Hz while heard', 'live view: rocsafe scene show'
)
SCENE_MARKERS = _fleet('scene/markers', MarkerArray, latched(), 'once', 'simulated objects')
STEP_DONE = _fleet('sim/step_done', StepDone, stream(), 'each step', 'lock-step of time')
CLOCK = _fleet('/clock', Clock, stream(), 'each step', 'simulated time')
TF = _fleet('/tf', TFMessage, stream(), 'as odom', 'frames that move, see ros.md')
# Many publish here, each once: a subscriber that kept one message would have one of them.
TF_STATIC = _fleet('/tf_static', TFMessage, kept(), 'once', 'frames that are fixed')
ROSOUT = _fleet('/rosout', Log, stream(), 'on change', 'log of all nodes')
DIAGNOSTICS = _fleet('/diagnostics', DiagnosticArray, stream(), '1 Hz', 'health of the nodes')

TOPICS = tuple(value for value in tuple(globals().values()) if isinstance(value, TopicSpec))
"""All of the above, in their order."""

FROM_ANYBODY = (CMD_VEL, GIMBAL_COMMAND, DRAWINGS, AGENT_REPORTS)
"""What people and programs beside a mission publish to it; all else it hears from its own only."""


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

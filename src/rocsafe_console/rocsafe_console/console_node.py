# SPDX-License-Identifier: Apache-2.0
"""The node of the console: hears a mission into the picture, and sends orders to vehicles.

It publishes nothing. It is not part of a mission: it finds the vehicles of its ROS domain by their
topic `state`, and goes on when a mission ends and another one begins.
"""

import time
from collections import deque
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from nav_msgs.msg import OccupancyGrid
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import CompressedImage
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from rocsafe_console import conversions, gas_conversions
from rocsafe_console.drive_conversions import drive_of
from rocsafe_console.drives_node import Offer
from rocsafe_console.evidence.desk import Desk
from rocsafe_console.orders.order_book import Order
from rocsafe_console.orders_node import Finish, Orders
from rocsafe_console.picture.alarms import ERROR, WARN
from rocsafe_console.picture.live import Live
from rocsafe_console.picture.map_image import DOSE, PLUME, Scale, corners_of, png_of
from rocsafe_console.picture.video import SCENE
from rocsafe_geo.frame import LocalFrame
from rocsafe_interfaces.msg import (
    AccumulatedDose,
    AgentState,
    Decision,
    DoseAlarm,
    GasReading,
    MissionState,
    Mosaic,
    ShotReceipt,
    SurveyPlan,
    VehicleEvent,
    VehicleState,
    WindReading,
)
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.interface_spec import TopicSpec, name_of

STATE_TYPE = 'rocsafe_interfaces/msg/VehicleState'
# What only a ground vehicle offers.
DRIVE_TYPE = 'rocsafe_interfaces/action/DriveRoute_FeedbackMessage'
LOOK_S = 0.5
POSTED_S = 0.02
TELL_AGAIN_S = 10.0


class ConsoleNode(Node):
    """Hears the mission of this ROS domain.

    Parameters
    ----------
    live
        Written here, under its lock.
    desk
        Learns which mission the orders of people belong to.
    """

    def __init__(self, live: Live, desk: Desk, **node_options: Any) -> None:
        super().__init__('console', start_parameter_services=False, **node_options)
        self._live = live
        self._desk = desk
        self._frame: LocalFrame | None = None
        # What lies in the frame of the mission and may be heard before it, by section.
        self._placed: dict[str, Callable[[LocalFrame], None]] = {}
        self._vehicles: set[str] = set()
        self._ground: set[str] = set()
        self._cameras: dict[str, Subscription] = {}
        self._posted: deque[Callable[[], None]] = deque()
        self.orders = Orders(self)
        for spec, heard in (
            (topics.MISSION_STATE, self._on_mission),
            (topics.DECISIONS, self._on_decision),
            (topics.AGENTS, self._on_agent),
            (topics.HAZARD_SOURCES, self._on_section('sources', conversions.sources_of)),
            (topics.REGION, self._on_section('region', conversions.region_of)),
            (topics.PLAN, self._on_plan),
            (topics.GROUND_ROUTE, self._on_section('drive', drive_of)),
            (topics.RELEASES, self._on_section('releases', gas_conversions.releases_of)),
            (topics.DOSE_MAP, self._on_grid('dose_map', DOSE)),
            (topics.PLUME, self._on_grid('plume', PLUME)),
            (topics.CORDONS, self._on_lines('cordons', conversions.cordons_of)),
            (topics.THREAT_ZONES, self._on_lines('zones', gas_conversions.threat_zones_of)),
            (topics.MOSAIC, self._on_mosaic),
            (topics.RECEIPTS, self._on_receipt),
            (topics.TF_STATIC, self._on_frames),
        ):
            self._hear(spec, heard)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(LOOK_S, self._look, clock=steady)
        self.create_timer(POSTED_S, self._do_posted, clock=steady)

    def post(self, task: Callable[[], None]) -> None:
        """Do `task` in the thread of this node, soon; may be called from any thread."""
        self._posted.append(task)

    def send_order(self, order: Order, names: tuple[str, ...], finish: Finish) -> None:
        """Send an order, and give `finish` one result of each vehicle; from any thread."""
        self.post(lambda: self.orders.send(order, names, finish))

    def plan_drive(self, order: Order, finish: Offer) -> None:
        """Plan the drive of an order, and give it to `finish`; from any thread."""
        self.post(lambda: self._plan_drive(order, finish))

    def _plan_drive(self, order: Order, finish: Offer) -> None:
        (name,) = order.revisions
        if name not in self._ground:
            finish(None, f'{name} does not drive')
            return
        with self._live.lock:
            vehicle = self._live.picture.vehicles.get(name)
        if vehicle is None:
            finish(None, f'{name} is not part of this mission')
            return
        self.orders.drives.plan(order, vehicle, finish)

    def destroy_node(self) -> None:
        """Destroy the node and its clients of actions."""
        self.orders.drives.close()
        super().destroy_node()

    def _do_posted(self) -> None:
        while self._posted:
            self._posted.popleft()()

    # Vehicles.

    def _look(self) -> None:
        """Subscribe to vehicles that are new in the domain."""
        for full, types in self.get_topic_names_and_types():
            name = full.strip('/').removesuffix('/state')
            if STATE_TYPE in types and '/' not in name and name not in self._vehicles:
                self._vehicles.add(name)
                self._watch(name)
            if DRIVE_TYPE in types and (driver := full.split('/')[1]) not in self._ground:
                self._ground.add(driver)
                self.orders.drives.add(driver)

        self._look_through_cameras()

    def _look_through_cameras(self) -> None:
        """Listen to the cameras that somebody looks at, and to no others."""
        with self._live.lock:
            wanted = self._live.video.wanted
        for name in self._cameras.keys() - wanted:
            self.destroy_subscription(self._cameras.pop(name))
        for name in wanted - self._cameras.keys():
            spec, vehicle = topics.CAMERA_IMAGE_COMPRESSED, name
            if name == SCENE:
                spec, vehicle = topics.SCENE_VIEW, ''
            self._cameras[name] = self._hear(spec, partial(self._on_camera, name), vehicle)

    def _on_camera(self, name: str, message: CompressedImage) -> None:
        stamp_s = conversions.seconds_of(message.header.stamp)
        with self._live.lock:
            # What DDS keeps for late subscribers is as old as its stamp.
            taken_s = self._live.picture.clock.wall_of(stamp_s, time.time())
            self._live.video.put(name, bytes(message.data), taken_s)

    def _watch(self, name: str) -> None:
        self.orders.add(name)
        for spec, heard in (
            (topics.STATE, self._on_state),
            (topics.FIX, self._on_fix),
            (topics.RADIATION, self._on_radiation),
            (topics.ACCUMULATED_DOSE, self._on_dose),
            (topics.DOSE_ALARM, self._on_alarm),
            (topics.EVENTS, self._on_event),
            (topics.CONTROL, self._on_control),
            (topics.HOME, self._on_home),
            (topics.ANEMOMETER, self._on_wind),
            (topics.GAS, self._on_gas),
        ):
            self._hear(spec, partial(heard, name), name)

    def _hear(
        self, spec: TopicSpec, heard: Callable[[Any], None], vehicle: str = ''
    ) -> Subscription:
        """Subscribe to what others publish: a message that cannot be shown ends nothing."""
        topic = name_of(spec, vehicle)
        return topics.create_subscription(
            self, spec, lambda message: self._show(topic, partial(heard, message)), vehicle
        )

    def _show(self, what: str, show: Callable[[], None]) -> None:
        try:
            show()
        except (ValueError, LookupError, TypeError, ArithmeticError) as error:
            text = f'{what}: cannot be shown: {error}'
            self.get_logger().warning(text, throttle_duration_sec=TELL_AGAIN_S)

    def _on_state(self, name: str, message: VehicleState) -> None:
        report = conversions.report_of(message, is_ground=name in self._ground)
        with self._live.lock:
            self._live.picture.on_report(report, time.time())

    def _on_fix(self, name: str, message: Any) -> None:
        place = (message.latitude, message.longitude, message.altitude)
        stamp_s = conversions.seconds_of(message.header.stamp)
        with self._live.lock:
            self._live.picture.on_fix(name, place, stamp_s, time.time())

    def _on_radiation(self, name: str, message: Any) -> None:
        reading = conversions.reading_of(name, message)
        with self._live.lock:
            self._live.picture.on_reading(reading, time.time())

    def _on_gas(self, name: str, message: GasReading) -> None:
        reading = gas_conversions.gas_of(name, message)
        with self._live.lock:
            self._live.picture.on_gas(reading, time.time())

    def _on_dose(self, name: str, message: AccumulatedDose) -> None:
        stamp_s = conversions.seconds_of(message.header.stamp)
        with self._live.lock:
            self._live.picture.on_dose(
                name, message.dose_usv, stamp_s, time.time(), is_lower_limit=message.is_lower_limit
            )

    def _on_alarm(self, name: str, message: DoseAlarm) -> None:
        if message.triggered:
            severity = ERROR if message.turns_back else WARN
            self._alarm(severity, name, conversions.alarm_text(name, message))

    def _on_event(self, name: str, message: VehicleEvent) -> None:
        if message.severity >= VehicleEvent.WARN:
            severity = ERROR if message.severity == VehicleEvent.ERROR else WARN
            self._alarm(severity, name, f'{name}: {message.text}')

    def _alarm(self, severity: str, name: str, text: str) -> None:
        with self._live.lock:
            self._live.picture.alarm(time.time(), severity, name, text)

    def _on_control(self, name: str, message: Any) -> None:
        with self._live.lock:
            self._live.picture.on_holder(name, conversions.holder_of(message), time.time())

    def _on_home(self, name: str, message: Any) -> None:
        with self._live.lock:
            self._live.picture.on_home(name, conversions.home_of(message))

    def _on_wind(self, name: str, message: WindReading) -> None:
        self._put('wind', conversions.wind_of(name, message))

    # The mission.

    def _on_mission(self, message: MissionState) -> None:
        mission = conversions.mission_of(message)
        with self._live.lock:
            before = self._live.picture.mission
            if before is not None and before.mission_id != mission.mission_id:
                self._live.begin()
            self._live.picture.on_mission(mission, time.time())
        if before is None or before.mission_id != mission.mission_id:
            self._desk.on_mission(mission.mission_id)

    def _on_decision(self, message: Decision) -> None:
        decision = conversions.decision_of(message)
        with self._live.lock:
            self._live.picture.on_decision(decision, time.time())

    def _on_agent(self, message: AgentState) -> None:
        stamp_s = conversions.seconds_of(message.header.stamp)
        with self._live.lock:
            self._live.picture.on_agent(message.vehicle, message.heard, stamp_s, time.time())

    def _on_plan(self, message: SurveyPlan) -> None:
        with self._live.lock:
            self._live.picture.on_plan(conversions.plan_of(message))

    def _on_section(self, name: str, convert: Callable[[Any], Any]) -> Callable[[Any], None]:
        def on_message(message: Any) -> None:
            self._put(name, convert(message))

        return on_message

    def _put(self, name: str, value: Any) -> None:
        """Set a section; what has a stamp is as old as that, however late it was heard."""
        if isinstance(value, dict) and 'stamp_s' in value:
            value = {**value, 'heard_s': self._made_s(value['stamp_s'])}
        with self._live.lock:
            self._live.picture.sections.put(name, value)

    def _made_s(self, stamp_s: float) -> float:
        """Return when a stamp was made by the clock on the wall, seconds; -infinity: long ago."""
        with self._live.lock:
            return self._live.picture.clock.wall_of(stamp_s, time.time())

    def _on_receipt(self, message: ShotReceipt) -> None:
        if message.status == ShotReceipt.REJECTED:
            text = f'{message.vehicle}: photograph {message.shot_id} rejected: {message.reason}'
            self._alarm(WARN, message.vehicle, text)
            return
        with self._live.lock:
            self._live.note_photograph(message.shot_id, Path(message.path))
        stamp_s = conversions.seconds_of(message.header.stamp)
        newest = {'shot_id': message.shot_id, 'vehicle': message.vehicle, 'stamp_s': stamp_s}
        self._put('photograph', newest)

    def _on_mosaic(self, message: Mosaic) -> None:
        with self._live.lock:
            self._live.images['mosaic'] = bytes(message.preview.data)
        self._put('mosaic', conversions.mosaic_of(message))

    def _on_frames(self, message: TFMessage) -> None:
        frame = conversions.frame_of(message)
        if frame is not None:
            self._frame = frame
            for name, draw in self._placed.items():
                self._show(name, partial(draw, frame))

    def _on_grid(self, name: str, scale: Scale) -> Callable[[OccupancyGrid], None]:
        def on_message(message: OccupancyGrid) -> None:
            self._place(name, lambda frame: self._put_grid(name, scale, message, frame))

        return on_message

    def _put_grid(
        self, name: str, scale: Scale, message: OccupancyGrid, frame: LocalFrame
    ) -> None:
        if not message.data:
            self._put(name, None)
            return
        grid = conversions.grid_of(message)
        value = {
            'stamp_s': conversions.seconds_of(message.header.stamp),
            'corners': corners_of(grid, frame),
        }
        picture = png_of(grid, scale)
        with self._live.lock:
            self._live.images[name] = picture
        self._put(name, value)

    def _on_lines(
        self, name: str, convert: Callable[[MarkerArray, LocalFrame], Any]
    ) -> Callable[[MarkerArray], None]:
        def on_message(message: MarkerArray) -> None:
            self._place(name, lambda frame: self._put(name, convert(message, frame)))
            self._put(f'{name}_heard_s', self._made_s(conversions.oldest_s(message)))

        return on_message

    def _place(self, name: str, draw: Callable[[LocalFrame], None]) -> None:
        """Draw what lies in the frame of the mission, now or when the frame is known."""
        self._placed[name] = draw
        if self._frame is not None:
            draw(self._frame)

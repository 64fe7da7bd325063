# SPDX-License-Identifier: Apache-2.0
"""The node that shows simulated vehicles to a ground station, with its topics."""

import socket

from rocsafe_mavlink.wire.dialect import decode
from rocsafe_mavlink.wire.framing import scan

DEADLINE_S = 30.0


def test_a_simulated_vehicle_is_shown_and_a_real_one_is_not(ros):
    """Position and mission reach the station; a real vehicle has a link of its own."""
    from rclpy.node import Node
    from rclpy.parameter import Parameter
    from sensor_msgs.msg import NavSatFix, NavSatStatus

    from rocsafe_interfaces.msg import GeoPoint, Route, SurveyPlan, VehicleState, Viewpoint
    from rocsafe_mavlink.view_node import ViewNode
    from rocsafe_ros.interfaces import topics

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind(('127.0.0.1', 0))
        station.setblocking(False)
        endpoint = f'udpout://127.0.0.1:{station.getsockname()[1]}'
        view = ViewNode(
            context=ros.context, parameter_overrides=[Parameter('endpoint', value=endpoint)]
        )
        world = Node('world', context=ros.context)
        real, simulated = (Node('rav', namespace=n, context=ros.context) for n in ('rav1', 'rav2'))
        for node in (view, world, real, simulated):
            ros.executor.add_node(node)
        states = [
            (topics.create_publisher(node, topics.STATE), node is simulated)
            for node in (real, simulated)
        ]
        fixes = topics.create_publisher(simulated, topics.FIX)
        plans = topics.create_publisher(world, topics.PLAN)
        place = GeoPoint(latitude=53.28, longitude=-9.06, altitude=98.0)
        home = GeoPoint(latitude=53.28, longitude=-9.06, altitude=66.0)
        route = Route(vehicle='rav2', home=home, viewpoints=[Viewpoint(position=place)])
        plans.publish(SurveyPlan(routes=[route]))
        heard = []

        def publish():
            for publisher, is_simulated in states:
                publisher.publish(
                    VehicleState(is_simulated=is_simulated, state=VehicleState.FLYING)
                )
            fix = NavSatFix(latitude=53.2805, longitude=-9.0605, altitude=98.5)
            fix.status.status = NavSatStatus.STATUS_FIX
            fixes.publish(fix)

        def has_heard():
            try:
                data = station.recv(512)
            except BlockingIOError:
                return False
            for frame in scan(data, is_whole=True).frames:
                heard.append(decode(frame.message_id, frame.payload, frame.system, 1))
            found = {message.name: message for message in heard}
            mission = found.get('MISSION_CURRENT')
            return 'GLOBAL_POSITION_INT' in found and mission is not None and mission['total'] == 3

        simulated.create_timer(0.2, publish)
        ros.spin_until(has_heard, DEADLINE_S)
        assert {message.system for message in heard} == {1}
        position = next(one for one in heard if one.name == 'GLOBAL_POSITION_INT')
        assert position['lat'] == 532_805_000
        view.destroy_node()

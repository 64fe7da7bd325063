# SPDX-License-Identifier: Apache-2.0
"""The node ``estimator`` tells releases from readings, and where to measure next."""

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

import numpy as np
from rclpy.node import Node
from rclpy.parameter import Parameter

from rocsafe_dispersion.agents.agent_table import agent
from rocsafe_dispersion.estimator_node import EstimatorNode
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.msg import GasReading, GeoPoint, ParticleReading, WindReading
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_ros.conversions import stamp_of_ns
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.parameters import ParameterError

from .airs import EASTWARDS, LAYER, SPEED_MPS

DEADLINE_S = 120.0
ORIGIN = GeoPosition(53.28, -9.06, 60.0)
FRAME = LocalFrame(ORIGIN)
RELEASE = Release(place_m=(-20.0, 5.0), height_m=1.0, rate_g_s=5.0)
PLACES = [(float(e), float(n), 3.0) for e in range(-40, 41, 16) for n in range(-40, 41, 16)]
WINDOW_NS = 5_000_000_000


def parameters(**values):
    """Return the parameters of a node."""
    given = {
        'vehicles': ['rav1'],
        'origin_latitude_deg': ORIGIN.latitude_deg,
        'origin_longitude_deg': ORIGIN.longitude_deg,
        'origin_altitude_m': ORIGIN.altitude_m,
        'dilution': 1.0,
        'intake_delay_s': 0.0,
        'period_s': 0.2,
    }
    return [Parameter(name, value=value) for name, value in (given | values).items()]


def readings():
    """Return gas and wind at all places, as messages."""
    plume = SteadyPlume(release=RELEASE, travel=similarity_travel(LAYER, 1.0), wind=EASTWARDS)
    grams = plume.concentrations_g_m3(np.array(PLACES))
    generator = np.random.default_rng(1)
    for number, (place, value) in enumerate(zip(PLACES, grams, strict=True), 1):
        position = FRAME.position_of(np.array(place))
        point = GeoPoint(
            latitude=position.latitude_deg,
            longitude=position.longitude_deg,
            altitude=position.altitude_m,
        )
        ppm = agent('isobutylene').ppm(float(value)) + 0.02 * generator.standard_normal()
        gas = GasReading(
            sensor='pid_10_6_ev', unit='ppm', calibration_gas='isobutylene', raw=ppm,
            corrected=ppm, std=0.02, limit=0.1, window_s=1.0, position=point,
        )  # fmt: skip
        wind = WindReading(towards_east_mps=SPEED_MPS, std_mps=0.5, position=point)
        for message in (gas, wind):
            message.header.stamp = stamp_of_ns(number * WINDOW_NS)
        yield gas, wind


def test_releases_zones_and_places_to_measure_come_from_readings(ros, tmp_path):
    """And a node that is started again has the readings."""
    overrides = parameters(spool_directory=str(tmp_path))
    node = EstimatorNode(context=ros.context, parameter_overrides=overrides)
    drone = Node('drone', context=ros.context)
    gas = topics.create_publisher(drone, topics.GAS, 'rav1')
    wind = topics.create_publisher(drone, topics.ANEMOMETER, 'rav1')
    heard, zones, plumes = [], [], []
    for spec, found in (
        (topics.RELEASES, heard),
        (topics.THREAT_ZONES, zones),
        (topics.PLUME, plumes),
    ):
        topics.create_subscription(drone, spec, found.append)
    for each in (node, drone):
        ros.executor.add_node(each)
    ros.spin_until(
        lambda: gas.get_subscription_count() and wind.get_subscription_count(), DEADLINE_S
    )
    for one, other in readings():
        wind.publish(other)
        gas.publish(one)

    def is_whole():
        return bool(heard) and heard[-1].reading_count == len(PLACES)

    ros.spin_until(is_whole, DEADLINE_S)
    assert len(heard[-1].releases) == 1
    release = heard[-1].releases[0]
    place = FRAME.enu_of(
        GeoPosition(release.position.latitude, release.position.longitude, ORIGIN.altitude_m)
    )
    miss = place[:2] - RELEASE.place_m
    covariance = np.reshape(release.position_covariance, (2, 2))
    # Quantile 0.95 of chi-square with two degrees of freedom.
    assert miss @ np.linalg.solve(covariance, miss) < 5.991
    assert np.hypot(*miss) < 25.0
    assert heard[-1].rate_unit == 'g/s'
    assert release.rate_low < RELEASE.rate_g_s < release.rate_high
    # Estimates of fewer readings may have come before, with nothing in their maps.
    ros.spin_until(lambda: bool(plumes and len(plumes[-1].data) and zones), DEADLINE_S)
    assert max(plumes[-1].data) > 0
    # The wind turns, a quarter of an hour later: the zones follow without a reading of gas.
    *_, (_, turned) = readings()
    turned.header.stamp = stamp_of_ns(900_000_000_000)
    turned.towards_east_mps, turned.towards_north_mps = 0.0, SPEED_MPS
    wind.publish(turned)
    ros.spin_until(lambda: heard[-1].wind_towards_north_mps > 0.9 * SPEED_MPS, DEADLINE_S)
    # Zones of the estimate before may come first.
    ros.spin_until(lambda: zones[-1].markers[0].header.stamp == turned.header.stamp, DEADLINE_S)
    client = drone.create_client(SuggestViewpoints, calls.SUGGEST_GAS_VIEWPOINTS.name)
    ros.spin_until(client.service_is_ready, DEADLINE_S)
    answers = []

    def is_answered():
        answer = client.call_async(SuggestViewpoints.Request(count=4))
        ros.spin_until(answer.done, DEADLINE_S)
        answers.append(answer.result())
        return answers[-1].status != SuggestViewpoints.Response.NOT_YET

    while not is_answered():
        ros.executor.spin_once(timeout_sec=0.1)
    assert answers[-1].is_enough or len(answers[-1].viewpoints) == 4
    ros.executor.remove_node(node)
    node.destroy_node()
    heard.clear()
    again = EstimatorNode(context=ros.context, parameter_overrides=overrides)
    ros.executor.add_node(again)
    ros.spin_until(is_whole, DEADLINE_S)
    for each in (again, drone):
        ros.executor.remove_node(each)
        each.destroy_node()


def test_counts_of_particles_make_an_estimate(ros):
    """Of which the message names the unit; nothing is asked of windows that counted nothing."""
    node = EstimatorNode(context=ros.context, parameter_overrides=parameters(agent='particles'))
    drone = Node('drone', context=ros.context)
    bio = topics.create_publisher(drone, topics.BIO, 'rav1')
    wind = topics.create_publisher(drone, topics.ANEMOMETER, 'rav1')
    heard = []
    topics.create_subscription(drone, topics.RELEASES, heard.append)
    for each in (node, drone):
        ros.executor.add_node(each)
    ros.spin_until(
        lambda: bio.get_subscription_count() and wind.get_subscription_count(), DEADLINE_S
    )
    for number, (one, other) in enumerate(readings()):
        wind.publish(other)
        message = ParticleReading(
            window_s=1.0, total=120 * (number > 0), fluorescent=number % 5,
            particles_per_l=10_000.0 * (number > 0), position=one.position,
        )  # fmt: skip
        message.header.stamp = one.header.stamp
        bio.publish(message)
    ros.spin_until(lambda: bool(heard) and heard[-1].reading_count == len(PLACES) - 1, DEADLINE_S)
    assert heard[-1].agent == 'particles'
    assert heard[-1].sensor == 'particle_counter'
    assert heard[-1].rate_unit == 'particles/s'
    assert 'particles/s may be' in heard[-1].verdict
    for each in (node, drone):
        ros.executor.remove_node(each)
        each.destroy_node()


@pytest.mark.parametrize(
    ('wrong', 'named'),
    [
        ({'stability': 'G'}, 'stability'),
        ({'agent': 'water'}, 'water'),
        ({'region_m': -1.0}, 'reg'),
    ],
)
def test_wrong_parameters_are_refused_in_one_line(ros, wrong, named):
    """By name."""
    with pytest.raises(ParameterError, match=named):
        EstimatorNode(context=ros.context, parameter_overrides=parameters(**wrong))

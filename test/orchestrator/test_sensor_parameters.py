# SPDX-License-Identifier: Apache-2.0
"""Sensors of a scenario reach the simulated vehicles as they are written."""

from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_geo.storage.value_file import read_values, values_of
from rocsafe_orchestrator.parameters.node_parameters import write_parameters
from rocsafe_orchestrator.recording.recorded_topics import recorded_topics
from rocsafe_scenario.blocks.simulation import (
    ImuBlock,
    SensorsBlock,
    SimulationBlock,
    sensor_parameters,
)
from rocsafe_sim.sensors.sensor_settings import (
    BarometerSettings,
    ImuSettings,
    MagnetometerSettings,
    RangefinderSettings,
    SensorRig,
)


def test_nothing_is_written_of_sensors_that_nobody_asks_for():
    """The parameters of older missions stay as they were."""
    assert sensor_parameters(SimulationBlock().sensors) == {}


def test_an_empty_block_is_the_default_sensor():
    """What is left out is as the vehicle has it: all defaults are its own."""
    every = SensorsBlock(imu={}, barometer={}, magnetometer={}, range={})
    rig = values_of(sensor_parameters(every)['sensors_file'], SensorRig, 'sensors')
    assert rig == SensorRig(
        imu=ImuSettings(),
        barometer=BarometerSettings(),
        magnetometer=MagnetometerSettings(),
        range=RangefinderSettings(),
    )


def test_vehicles_understand_what_is_written(tmp_path: Path):
    """Through the files of a run; sensors that are left out are not there."""
    asked = SensorsBlock(imu=ImuBlock(rate_hz=200.0), range={'pitch_deg': 0.0, 'max_m': 40.0})
    write_parameters(tmp_path / 'rav1.yaml', '/rav1/rav', sensor_parameters(asked))
    assert 'sensors_file' in (tmp_path / 'rav1.yaml').read_text()
    rig = read_values(tmp_path / 'rav1-sensors.yaml', SensorRig)
    assert rig == SensorRig(
        imu=ImuSettings(rate_hz=200.0),
        range=RangefinderSettings(pitch_deg=0.0, max_m=40.0),
    )


def test_samples_are_not_recorded():
    """Hundreds in a second would fill a recording with what seed and flight tell."""
    names = {spec.name for spec, _ in recorded_topics(['rav1'])}
    assert not names & {'imu', 'barometer', 'magnetometer', 'range'}

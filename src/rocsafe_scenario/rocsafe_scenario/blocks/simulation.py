# SPDX-License-Identifier: Apache-2.0
"""The blocks of a scenario's simulated vehicles and of their sensors.

A sensor that is left out is not there. Of one that is there, what is left out is as
docs/sensors.md says.
"""

from typing import Any, Literal

from pydantic import Field, model_validator

from rocsafe_scenario.blocks.block import Block

_FASTEST_HZ = 400.0


class _SensorBlock(Block):
    """Common settings of sensors: samples per simulated second."""

    rate_hz: float | None = Field(default=None, ge=0.01, le=_FASTEST_HZ)


class ImuBlock(_SensorBlock):
    """Gyroscopes, rad/s, and accelerometers, m/s^2; noise is a density, by sqrt(Hz)."""

    gyroscope_noise: float | None = Field(default=None, ge=0.0)
    gyroscope_drift_std_radps: float | None = Field(default=None, ge=0.0)
    accelerometer_noise: float | None = Field(default=None, ge=0.0)
    accelerometer_drift_std_mps2: float | None = Field(default=None, ge=0.0)


class BarometerBlock(_SensorBlock):
    """Pressure of the air."""

    noise_std_pa: float | None = Field(default=None, ge=0.0)
    drift_std_pa: float | None = Field(default=None, ge=0.0)
    sea_level_pressure_pa: float | None = Field(default=None, ge=80_000.0, le=120_000.0)


class MagnetometerBlock(_SensorBlock):
    """Magnetic field along three axes."""

    noise_std_ut: float | None = Field(default=None, ge=0.0)
    drift_std_ut: float | None = Field(default=None, ge=0.0)


class RangeBlock(_SensorBlock):
    """Distance along a beam, by default straight down."""

    noise_std_m: float | None = Field(default=None, ge=0.0)
    min_m: float = Field(default=0.1, ge=0.0, le=500.0)
    max_m: float = Field(default=12.0, ge=0.1, le=500.0)
    beam_deg: float | None = Field(default=None, ge=0.0, le=90.0)
    pitch_deg: float | None = Field(default=None, ge=-90.0, le=90.0)
    yaw_deg: float | None = Field(default=None, ge=-360.0, le=360.0)

    @model_validator(mode='after')
    def _has_a_span(self) -> 'RangeBlock':
        if self.min_m >= self.max_m:
            raise ValueError(f'min_m is {self.min_m:g}: must be below max_m, {self.max_m:g}')
        return self


class SensorsBlock(Block):
    """Sensors of motion, air, field and distance that every simulated vehicle has."""

    imu: ImuBlock | None = None
    barometer: BarometerBlock | None = None
    magnetometer: MagnetometerBlock | None = None
    range: RangeBlock | None = None


class SimulationBlock(Block):
    """How vehicles are simulated: one process each or all in one, and what they measure."""

    processes: Literal['per_vehicle', 'fleet'] = 'per_vehicle'
    fix_rate_hz: float = Field(default=5.0, gt=0.0, le=100.0)
    gps_horizontal_std_m: float = Field(default=0.02, ge=0.0, le=100.0)
    gps_vertical_std_m: float = Field(default=0.04, ge=0.0, le=100.0)
    tilt_std_deg: float = Field(default=0.5, ge=0.0, le=20.0)
    attitude_std_deg: float = Field(default=0.1, ge=0.0, le=20.0)
    collision_radius_m: float = Field(default=0.4, ge=0.0, le=10.0)
    sensors: SensorsBlock = SensorsBlock()


def sensor_parameters(sensors: SensorsBlock) -> dict[str, Any]:
    """Return the parameter of the sensors of a simulated vehicle; empty if it has none."""
    given = sensors.model_dump(exclude_none=True)
    return {'sensors_file': given} if given else {}

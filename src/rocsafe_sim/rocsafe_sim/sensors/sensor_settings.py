# SPDX-License-Identifier: Apache-2.0
"""Settings of the sensors, as the file of the parameter `sensors_file` has them.

Noise densities are those of data sheets: the standard deviation of a sample is the density times
the square root of the rate.
"""

from dataclasses import dataclass

from rocsafe_geo.limits import require_between, require_not_negative

FASTEST_HZ = 400.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuSettings:
    """Gyroscopes and accelerometers.

    Densities are those of an InvenSense MPU-6000 (data sheet PS-MPU-6000A-00, revision 3.4:
    0.005 deg/s/sqrt(Hz) and 400 ug/sqrt(Hz)). Drifts are what is left after a calibration at rest.

    Attributes
    ----------
    rate_hz
        Samples in a simulated second.
    gyroscope_noise
        Density of the white noise, rad/s/sqrt(Hz).
    gyroscope_drift_std_radps
        Standard deviation of the drift on each axis.
    accelerometer_noise
        Density of the white noise, m/s^2/sqrt(Hz).
    accelerometer_drift_std_mps2
        Standard deviation of the drift on each axis.
    """

    rate_hz: float = 100.0
    gyroscope_noise: float = 8.7e-5
    gyroscope_drift_std_radps: float = 1e-3
    accelerometer_noise: float = 3.9e-3
    accelerometer_drift_std_mps2: float = 0.05

    def __post_init__(self) -> None:
        _require_rate(self.rate_hz)
        for name in (
            'gyroscope_noise',
            'gyroscope_drift_std_radps',
            'accelerometer_noise',
            'accelerometer_drift_std_mps2',
        ):
            require_not_negative(name, getattr(self, name))


@dataclass(frozen=True, slots=True, kw_only=True)
class BarometerSettings:
    """A barometer.

    The noise is the resolution of a TE MS5611 at an oversampling of 1024 (data sheet:
    0.027 mbar); the drift is that of the air's pressure in settled weather.

    Attributes
    ----------
    rate_hz
        Samples in a simulated second.
    noise_std_pa
        Standard deviation of the white noise.
    drift_std_pa
        Standard deviation of the drift within hours.
    sea_level_pressure_pa
        Pressure at altitude 0.
    """

    rate_hz: float = 20.0
    noise_std_pa: float = 2.7
    drift_std_pa: float = 30.0
    sea_level_pressure_pa: float = 101_325.0

    def __post_init__(self) -> None:
        _require_rate(self.rate_hz)
        require_not_negative('noise_std_pa', self.noise_std_pa, 'Pa')
        require_not_negative('drift_std_pa', self.drift_std_pa, 'Pa')
        require_between(
            'sea_level_pressure_pa', self.sea_level_pressure_pa, 80_000.0, 120_000.0, 'Pa'
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class MagnetometerSettings:
    """A magnetometer with three axes.

    The noise is that of a Honeywell HMC5883L (data sheet: 2 mG); the drift is what is left of the
    vehicle's own field after calibration.

    Attributes
    ----------
    rate_hz
        Samples in a simulated second.
    noise_std_ut
        Standard deviation of the white noise, microtesla.
    drift_std_ut
        Standard deviation of the drift, microtesla.
    """

    rate_hz: float = 20.0
    noise_std_ut: float = 0.2
    drift_std_ut: float = 1.0

    def __post_init__(self) -> None:
        _require_rate(self.rate_hz)
        require_not_negative('noise_std_ut', self.noise_std_ut, 'uT')
        require_not_negative('drift_std_ut', self.drift_std_ut, 'uT')


@dataclass(frozen=True, slots=True, kw_only=True)
class RangefinderSettings:
    """A sensor of the distance along one beam.

    The noise, the limits and the width of the beam are those of a Benewake TFmini Plus (data
    sheet: 0.1 to 12 m, 3.6 deg, 0.05 m).

    Attributes
    ----------
    rate_hz
        Samples in a simulated second.
    noise_std_m
        Standard deviation of the white noise.
    min_m, max_m
        Distances between which it measures.
    beam_deg
        Full angle of the beam, stated in the messages; the distance is that on its axis.
    pitch_deg
        Angle of the beam above the horizon of a level vehicle: -90 is straight down.
    yaw_deg
        Angle of the beam from the nose, anticlockwise.
    """

    rate_hz: float = 10.0
    noise_std_m: float = 0.05
    min_m: float = 0.1
    max_m: float = 12.0
    beam_deg: float = 3.6
    pitch_deg: float = -90.0
    yaw_deg: float = 0.0

    def __post_init__(self) -> None:
        _require_rate(self.rate_hz)
        require_not_negative('noise_std_m', self.noise_std_m, 'm')
        require_between('max_m', self.max_m, 0.1, 500.0, 'm')
        require_between('min_m', self.min_m, 0.0, self.max_m, 'm')
        require_between('beam_deg', self.beam_deg, 0.0, 90.0, 'deg')
        require_between('pitch_deg', self.pitch_deg, -90.0, 90.0, 'deg')
        require_between('yaw_deg', self.yaw_deg, -360.0, 360.0, 'deg')


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorRig:
    """The sensors of a vehicle; None: it has no such sensor."""

    imu: ImuSettings | None = None
    barometer: BarometerSettings | None = None
    magnetometer: MagnetometerSettings | None = None
    range: RangefinderSettings | None = None


def _require_rate(rate_hz: float) -> None:
    require_between('rate_hz', rate_hz, 0.01, FASTEST_HZ)

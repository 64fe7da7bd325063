# SPDX-License-Identifier: Apache-2.0
"""What the gas detectors of a flight say about the agent, from the readings kept."""

from collections.abc import Iterable, Sequence
from statistics import median

from rocsafe_dispersion.detection.sensor_kinds import GAS_SENSORS
from rocsafe_dispersion.identification.sensor_report import SensorReport
from rocsafe_dispersion.mission_gas.gas_log import GasFlightReading
from rocsafe_geo.time_units import NS_PER_S

# Readings of several detectors are of the same air this long before and after the clearest one:
# slow detectors follow within it.
SAME_AIR_S = 60.0
# One reading alone may be noise: a reading counts as the median of so many.
SMOOTHED = 3


def flight_reports(readings: Iterable[GasFlightReading]) -> tuple[SensorReport, ...]:
    """Return the highest readings of one vehicle's detectors around the clearest of all.

    The clearest reading is the highest one in limits of detection. Without a reading above a
    limit all detectors are silent, which says nothing about the agent. Kinds of detectors that
    are not known are left out.
    """
    ways: dict[tuple[str, str], list[GasFlightReading]] = {}
    for reading in sorted(readings, key=lambda one: one.time_ns):
        if reading.sensor in GAS_SENSORS:
            ways.setdefault((reading.vehicle, reading.sensor), []).append(reading)
    if not ways:
        return ()
    smooth = {key: _smoothed(way) for key, way in ways.items()}
    vehicle, clearest = max(
        smooth, key=lambda key: max(v for _, v in smooth[key]) / GAS_SENSORS[key[1]].limit
    )
    peak_ns = max(smooth[vehicle, clearest], key=lambda pair: pair[1])[0]
    found = []
    for (owner, sensor), values in sorted(smooth.items()):
        near = [v for time, v in values if abs(time - peak_ns) <= SAME_AIR_S * NS_PER_S]
        if owner == vehicle and near:
            found.append(SensorReport(sensor=sensor, reading=max(0.0, *near)))
    return tuple(found)


def _smoothed(way: Sequence[GasFlightReading]) -> list[tuple[int, float]]:
    """Return times and running medians."""
    half = SMOOTHED // 2
    return [
        (one.time_ns, median(each.raw for each in way[max(0, at - half) : at + half + 1]))
        for at, one in enumerate(way)
    ]

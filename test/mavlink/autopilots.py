# SPDX-License-Identifier: Apache-2.0
"""The autopilots that a test flies with: the fake, and real ones where there are any."""

import pytest
from test.mavlink import px4_sih, sitl
from test.mavlink.airspace import Airspace


def _real(name, place, reason):
    """Return the parameter of a test for a real autopilot."""
    skip = pytest.mark.skipif(not place, reason=reason)
    return pytest.param(name, marks=[skip, pytest.mark.system, pytest.mark.all])


# First the fake, which is everywhere.
AUTOPILOTS = [
    'fake',
    _real('sitl', sitl.BINARY, 'ROCSAFE_SITL names no ArduPilot simulator'),
    _real('px4', px4_sih.BUILD, 'ROCSAFE_PX4 names no build of PX4'),
]


def make_airspace(kind, folder, systems=(1,), precaution='', rate=None):
    """Put copters of a kind of `AUTOPILOTS` into the air; `rate` is for the real ones.

    `precaution` names the failsafe that shall act.
    """
    if kind == 'sitl':
        return sitl.SitlAirspace(systems, folder, rate or 10.0, precaution)
    if kind == 'px4':
        return px4_sih.Px4Airspace(systems, folder, rate or px4_sih.SPEEDUP, precaution)
    air = Airspace(systems)
    for copter in air.copters.values():
        copter.parameters.update(sitl.PRECAUTIONS[precaution])
    return air

# SPDX-License-Identifier: Apache-2.0
"""Kinds of gas sensors.

All figures are typical ones of data sheets, from reference/dispersion.md section 2 (there
labelled as general knowledge); correction factors of the lamp are of the order of RAE Systems'
technical note 106, from memory. They describe kinds, not products: check those of your own.
"""

from rocsafe_dispersion.detection.gas_sensor import GasSensor

_KINDS = (
    # Reads isobutylene; response = 1 / correction factor.
    GasSensor(
        name='pid_10_6_ev',
        technology='photoionisation',
        responses={
            'isobutylene': 1.0,
            'acetone': 0.9,
            'ammonia': 0.1,
            'benzene': 1.9,
            'hydrogen_sulphide': 0.3,
            'ethylene_oxide': 0.08,
            'nitrogen_dioxide': 0.06,
            'arsine': 0.5,
            'bromine': 0.75,
        },
        lamp_ev=10.6,
        rise_s=1.5,
        fall_s=1.5,
        limit=0.1,
        noise=0.02,
        relative_noise=0.03,
        ceiling=10_000.0,
        drift=0.03,
    ),
    GasSensor(
        name='electrochemical_chlorine',
        technology='electrochemical',
        responses={'chlorine': 1.0, 'nitrogen_dioxide': 0.5, 'bromine': 0.9},
        rise_s=13.0,
        fall_s=20.0,
        limit=0.1,
        noise=0.03,
        relative_noise=0.03,
        ceiling=50.0,
        drift=0.05,
    ),
    GasSensor(
        name='electrochemical_ammonia',
        technology='electrochemical',
        responses={'ammonia': 1.0, 'hydrogen_sulphide': 0.1},
        rise_s=20.0,
        fall_s=26.0,
        limit=1.0,
        noise=0.3,
        relative_noise=0.03,
        ceiling=300.0,
        drift=0.5,
    ),
    GasSensor(
        name='electrochemical_hydrogen_sulphide',
        technology='electrochemical',
        responses={'hydrogen_sulphide': 1.0, 'sulphur_dioxide': 0.15},
        rise_s=10.0,
        fall_s=15.0,
        limit=0.3,
        noise=0.1,
        relative_noise=0.03,
        ceiling=200.0,
        drift=0.1,
    ),
    GasSensor(
        name='electrochemical_sulphur_dioxide',
        technology='electrochemical',
        responses={'sulphur_dioxide': 1.0, 'nitrogen_dioxide': -0.5, 'hydrogen_sulphide': 0.1},
        rise_s=10.0,
        fall_s=15.0,
        limit=0.2,
        noise=0.05,
        relative_noise=0.03,
        ceiling=100.0,
        drift=0.1,
    ),
    GasSensor(
        name='metal_oxide',
        technology='metal oxide',
        responses={
            'acetone': 1.0,
            'isobutylene': 0.8,
            'carbon_monoxide': 0.3,
            'methane': 0.05,
            'ammonia': 0.2,
            'hydrogen_sulphide': 0.5,
            'benzene': 0.5,
        },
        rise_s=2.0,
        fall_s=20.0,
        limit=0.5,
        noise=0.1,
        relative_noise=0.15,
        ceiling=1000.0,
        drift=0.3,
        drift_s=900.0,
    ),
    # Toxic industrial chemicals by ion mobility: bars, and a long clear-down after overload.
    GasSensor(
        name='ion_mobility',
        technology='ion mobility',
        unit='mg_m3',
        responses={
            'chlorine': 1.0,
            'sulphur_dioxide': 0.7,
            'hydrogen_cyanide': 0.7,
            'phosgene': 0.7,
            # Not toxic at these levels, but alarms all the same: cleaners and solvents.
            'ammonia': 0.3,
            'acetone': 0.01,
        },
        rise_s=5.0,
        fall_s=15.0,
        limit=0.1,
        noise=0.02,
        relative_noise=0.1,
        ceiling=20.0,
        overload=10.0,
        clear_down_s=120.0,
        bars=(0.1, 0.3, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0),
    ),
)
GAS_SENSORS = {kind.name: kind for kind in _KINDS}

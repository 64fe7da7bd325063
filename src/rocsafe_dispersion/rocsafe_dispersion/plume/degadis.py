# SPDX-License-Identifier: Apache-2.0
"""Dense gas near a steady release at the ground, by DEGADIS 2.1 where it is installed.

`degadisx` (MIT) is the extra ``dense`` of this package: a Python version of the model of the US
EPA (Spicer and Havens 1989, EPA-450/4-89-019). The gas mixes without heat, with the density that
it leaves with: its heat capacity is in no table here.
"""

import importlib.util
import math
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rocsafe_dispersion.plume.dense_gas import DenseRelease
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.stability import CLASSES, StabilityClass

MODULE = 'degadisx'
LABEL = 'DEGADIS 2.1, mean of 10 minutes over flat ground'
# Concentrations are means over the time of plumes, seconds; heights of the wind, metres.
AVERAGED_S, WIND_HEIGHT_M = 600.0, 10.0
# The deck is for a release without end.
LASTS_S, LEAST_SHARE = 60_230.0, 1e-6
_TABLE_ROWS = 21


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DenseProfile:
    """Cloud along the wind: distances, largest shares of gas in the air, half widths, (n,)."""

    distances_m: FloatArray
    shares: FloatArray
    widths_m: FloatArray

    def at(self, distances_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return shares and half widths at distances; nearer than its first one, those there."""
        logs = np.interp(distances_m, self.distances_m, np.log(self.shares))
        return np.exp(logs), np.interp(distances_m, self.distances_m, self.widths_m)


def degadis_profile(
    release: DenseRelease, molar_mass_g_mol: float, layer: SurfaceLayer, stability: StabilityClass
) -> DenseProfile | None:
    """Return the cloud of a release; None: it is not installed, or finds no solution."""
    if importlib.util.find_spec(MODULE) is None:
        return None
    model = importlib.import_module(MODULE)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, 'release.inp')
        lines = _deck(release, molar_mass_g_mol, layer, stability)
        path.write_text('\n'.join(lines) + '\n', encoding='ascii')
        try:
            found, _ = model.run_steady(path)
        except (ArithmeticError, LookupError, RuntimeError, ValueError):
            return None
    distances, shares, flat, sigma_y = (
        np.asarray(found.column(name), float) for name in ('dist', 'yc', 'b', 'sy')
    )
    return DenseProfile(
        distances_m=distances,
        shares=shares,
        # The half width of even gas with as much in it: a flat middle with Gaussian edges.
        widths_m=flat + math.sqrt(math.pi) / 2.0 * sigma_y,
    )


def _deck(
    release: DenseRelease, molar_mass_g_mol: float, layer: SurfaceLayer, stability: StabilityClass
) -> Iterator[str]:
    """Yield the lines of an input file of DEGADIS, whose order says what they are."""
    air_k, air = release.air_temperature_k, release.air_density_kg_m3
    dense, rate = release.density_kg_m3, release.volume_flow_m3_s * release.density_kg_m3
    obukhov = layer.obukhov_length_m
    yield from ('ROCSAFE', '', '', '')
    yield f'{release.wind_10m_mps:.6g} {WIND_HEIGHT_M:g} {layer.roughness_m:.6g}'
    yield f'{CLASSES.index(stability) + 1}'
    yield f'0 {AVERAGED_S:g}'
    yield f'2 {obukhov if math.isfinite(obukhov) else 0.0:.6g}'
    yield f'{air_k:.6g} 1 0.007 50'
    # Densities by a table; neither heat nor water comes from the ground.
    yield from (f'1 {air_k:.6g}', '0 0', '0 0', 'GAS')
    yield f'{molar_mass_g_mol:.6g} {release.temperature_k:.6g} {dense:.6g}'
    # Heat capacity, which the table makes needless; levels and height of contours.
    yield from ('1000 0', '0.01 0.001 0.5', f'{_TABLE_ROWS}')
    for share in np.linspace(0.0, 1.0, _TABLE_ROWS).tolist():
        mixed = share * dense + (1.0 - share) * air
        yield f'{share:.6g} {share * dense:.8g} {mixed:.8g} 0 {air_k:.6g}'
    yield from (f'{LEAST_SHARE:g}', '0', '4')
    radius_m = release.length_m / math.sqrt(math.pi)
    for time_s, now in ((0.0, 1.0), (LASTS_S, 1.0), (LASTS_S + 1.0, 0.0), (LASTS_S + 2.0, 0.0)):
        yield f'{time_s:g} {now * rate:.8g} {now * radius_m:.6g} 1 {release.temperature_k:.6g} 1'
    yield from ('T', '01-JAN-2026 00:00:00.00')

# SPDX-License-Identifier: Apache-2.0
"""What readings count: grams of a gas, or particles.

Estimation works with either: names that end in ``g_m3`` and ``g_s`` are of particles, in 1/m^3 and
1/s, where readings count these.
"""

from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.agents.agent_table import Agent
from rocsafe_geo.arrays import FloatArray

L_PER_M3 = 1000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Amount:
    """What readings count, and how it is told.

    Attributes
    ----------
    rate_unit
        Unit of rates.
    concentration_key
        End of names of concentrations in files.
    """

    rate_unit: str
    concentration_key: str

    @property
    def is_particles(self) -> bool:
        """Whether particles are counted."""
        return self == PARTICLES

    @property
    def shown_unit(self) -> str:
        """Unit in which maps and tables show concentrations."""
        return 'particles/l' if self.is_particles else 'ppm'

    def shown(self, agent: Agent) -> float:
        """Return what 1 of it in a cubic metre is in the unit of maps."""
        return 1.0 / L_PER_M3 if self.is_particles else agent.ppm(1.0)


GRAMS = Amount(rate_unit='g/s', concentration_key='g_m3')
PARTICLES = Amount(rate_unit='particles/s', concentration_key='per_m3')


def counted_per_m3(counts: FloatArray, litres: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return concentrations of particles and the noise of their counts, (n,), 1/m^3.

    The noise is that of Poisson's law for each count, or for what the median concentration makes
    where that is more: a count that is low by chance is no more precise than others.

    Parameters
    ----------
    counts : (n,)
        Particles counted in each reading.
    litres : (n,)
        Air that was counted in each reading, above 0, litres.
    """
    usual = float(np.median(counts / litres)) * litres
    noise = np.sqrt(np.maximum(np.maximum(counts, usual), 1.0))
    return L_PER_M3 * counts / litres, L_PER_M3 * noise / litres

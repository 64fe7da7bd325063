# SPDX-License-Identifier: Apache-2.0
"""Response levels of an agent as concentrations, each with its time of exposure."""

from dataclasses import dataclass

from rocsafe_dispersion.agents.agent_table import LEVELS, Agent
from rocsafe_geo.limits import require_positive

ERPG_MINUTES = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseLevel:
    """A published level.

    Attributes
    ----------
    name
        Its name, for instance ``AEGL-2``.
    minutes
        Time of exposure that it holds for; concentrations are averaged over it.
    ppm, g_m3
        The level, as a share of the volume and as a concentration at 20 degrees and 1013 hPa.
    """

    name: str
    minutes: float
    ppm: float
    g_m3: float

    def __post_init__(self) -> None:
        for name in ('minutes', 'ppm', 'g_m3'):
            require_positive(f'{self.name}: {name}', getattr(self, name))

    @property
    def label(self) -> str:
        """Name and time, for maps and tables."""
        return f'{self.name} ({self.minutes:g} min)'


def response_levels(agent: Agent, minutes: float = 60.0) -> list[ResponseLevel]:
    """Return the levels of an agent for a time of exposure: AEGL, or else ERPG at 60 minutes.

    An agent without published levels for this time has none: nothing is interpolated.
    """
    found = [
        ResponseLevel(name=f'AEGL-{level}', minutes=minutes, ppm=ppm, g_m3=agent.g_m3(ppm))
        for level in LEVELS
        if (ppm := agent.aegl_at_ppm(level, minutes)) is not None
    ]
    if found or agent.erpg_ppm is None or minutes != ERPG_MINUTES:
        return found
    return [
        ResponseLevel(name=f'ERPG-{level}', minutes=minutes, ppm=ppm, g_m3=agent.g_m3(ppm))
        for level, ppm in zip(LEVELS, agent.erpg_ppm, strict=True)
        if ppm > 0.0
    ]

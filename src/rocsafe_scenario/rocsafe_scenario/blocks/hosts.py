# SPDX-License-Identifier: Apache-2.0
"""The machines of a mission, and what runs on each."""

import ipaddress
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from rocsafe_scenario.blocks.block import Block

MOST_HOSTS = 16


def _ipv4(value: str) -> str:
    try:
        return str(ipaddress.IPv4Address(value))
    except ValueError:
        raise ValueError('must be an IPv4 address') from None


class HostBlock(Block):
    """A machine of the mission. `rocsafe run` is on the first, `rocsafe join` on the others.

    Vehicles that no host has, and all other processes, run on the first.
    """

    name: Annotated[str, Field(pattern=r'^[a-z][a-z0-9_]*$', max_length=32)]
    address: Annotated[str, AfterValidator(_ipv4)]
    vehicles: tuple[str, ...] = ()
    runs: tuple[Literal['world', 'radiation_field'], ...] = ()

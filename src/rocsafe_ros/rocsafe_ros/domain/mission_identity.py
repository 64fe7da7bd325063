# SPDX-License-Identifier: Apache-2.0
"""Identity of a mission, which its processes show to every node in the ROS domain."""

import os
import re
import secrets
from dataclasses import dataclass

from rocsafe_ros.interfaces import calls, topics

# Enclaves of the processes of missions begin so.
ROOT = '/rocsafe/'
# Simulated time belongs to one mission: it is reached under names that only its nodes know.
BOUND = (topics.CLOCK, topics.STEP_DONE, calls.WORLD_RUN)
TOKEN_BYTES = 16
# Names of ROS have no hyphen, and no two underscores in a row.
_ESCAPES = {'_': '_u', '-': '_d'}
_LETTERS = {escape: letter for letter, escape in _ESCAPES.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionIdentity:
    """A mission of the suite.

    DDS announces the enclave of a process before any of its topics, so a node can be told by its
    mission and not only by its name.

    Attributes
    ----------
    mission
        Name, for people: letters, digits, ``-`` and ``_``.
    token
        Hexadecimal number that no other mission has.
    """

    mission: str
    token: str

    def __post_init__(self) -> None:
        """Refuse what cannot be part of a name of ROS."""
        if not re.fullmatch('[A-Za-z0-9_-]+', self.mission):
            raise ValueError(f'mission = {self.mission!r}: must be letters, digits, - and _')
        if not re.fullmatch('[0-9a-f]+', self.token):
            raise ValueError(f'token = {self.token!r}: must be hexadecimal digits')

    @property
    def enclave(self) -> str:
        """Name of the enclave of its processes."""
        name = re.sub('[_-]', lambda found: _ESCAPES[found.group()], self.mission)
        return f'{ROOT}{name}/t{self.token}'

    @property
    def remapping_arguments(self) -> tuple[str, ...]:
        """ROS arguments that give simulated time names of its own."""
        # A leading underscore hides a topic from `ros2 topic list`.
        hidden = f'/_rocsafe_t{self.token}'
        names = [f'/{spec.name.lstrip("/")}' for spec in BOUND]
        return tuple(word for name in names for word in ('-r', f'{name}:={hidden}{name}'))

    @property
    def ros_arguments(self) -> tuple[str, ...]:
        """ROS arguments of its processes that make them part of it."""
        # With the security of DDS an enclave stands for a key, which the user has named.
        is_secured = os.environ.get('ROS_SECURITY_ENABLE') == 'true'
        enclave = () if is_secured else ('--enclave', self.enclave)
        return (*enclave, *self.remapping_arguments)


def new_identity(mission: str) -> MissionIdentity:
    """Return the identity of a mission that begins."""
    return MissionIdentity(mission=mission, token=secrets.token_hex(TOKEN_BYTES))


def identity_of(enclave: str) -> MissionIdentity | None:
    """Return the mission of a process by its enclave, None if it is of no mission."""
    match = re.fullmatch(f'{ROOT}([A-Za-z0-9_]+)/t([0-9a-f]+)', enclave)
    if match is None:
        return None
    name = re.sub('_[ud]', lambda found: _LETTERS[found.group()], match.group(1))
    return MissionIdentity(mission=name, token=match.group(2))

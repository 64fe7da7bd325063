# SPDX-License-Identifier: Apache-2.0
"""A DDS partition in which the processes of a mission hear each other, and nobody else.

A node of another hand that publishes or serves a name of a running mission, for instance a vehicle
of the same name, does not match the mission's subscriptions and clients: it is not heard and not
commanded. Everybody else may still listen to the mission and call its services.

The partition is named by the token of the mission. A profile for Fast DDS puts what the mission
publishes and serves into the common partition and into its own, and what it hears and asks into
its own alone, but for topics that others may publish to it (property ``partitions`` of Fast DDS;
DDS 1.4, 2.2.3.13).
"""

from collections.abc import Iterable, Iterator, MutableMapping
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier

from rocsafe_ros.domain.network import EMPTY, END, HEARTBEATS, OURS, PROFILES, RMW, profile_of

FILE = f'{OURS}mission.xml'
# The graph of ROS, and what nodes of all hands share. The first is named without a slash.
EVERYBODYS = (
    'ros_discovery_info', '/rosout', '/parameter_events', '/diagnostics', '/tf', '/tf_static',
)  # fmt: skip
# The middleware takes these profiles for the requests and replies of all services and clients.
SERVICE, CLIENT = 'service', 'client'
_BEGIN = '<!-- of the mission -->'
_PARTITIONS = (
    '<propertiesPolicy><properties><property><name>partitions</name><value>{}</value></property>'
    '</properties></propertiesPolicy>'
)


def keep_to_mission(
    environment: MutableMapping[str, str], folder: Path, token: str, open_topics: Iterable[str]
) -> bool:
    """Let the processes with `environment` hear and ask their own mission only.

    It has to be called before ROS is started.

    Parameters
    ----------
    environment
        Environment of the processes; the profile is added.
    folder
        Folder for the profile.
    token
        Token of the mission.
    open_topics
        Names of the topics, without a slash at the beginning, that others may publish to it,
        besides `EVERYBODYS`.

    Returns
    -------
    bool
        Whether it could be done: not with a profile of the user, nor with another middleware.
    """
    profile = profile_of(environment)
    if (profile and not profile.name.startswith(OURS)) or (
        get_rmw_implementation_identifier() != RMW
    ):
        return False
    # The profile may be that of the mission whose process starts this one.
    text = (profile.read_text(encoding='utf-8') if profile else EMPTY).removesuffix(END)
    text = text.partition(_BEGIN)[0]
    times = HEARTBEATS if HEARTBEATS in text else ''
    section = '\n'.join(_section(token, sorted(set(open_topics)), times))
    path = folder / FILE
    path.write_text(f'{text}{_BEGIN}\n{section}{END}', encoding='utf-8')
    environment.update(dict.fromkeys(PROFILES, str(path)))
    return True


def _section(token: str, open_topics: Iterable[str], times: str) -> Iterator[str]:
    own, both = _PARTITIONS.format(token), _PARTITIONS.format(f';{token}')
    default = 'is_default_profile="true"'
    yield f'<data_writer profile_name="mission_writer" {default}>{times}{both}</data_writer>'
    yield f'<data_reader profile_name="mission_reader" {default}>{own}</data_reader>'
    yield f'<data_reader profile_name="{SERVICE}">{both}</data_reader>'
    yield f'<data_writer profile_name="{CLIENT}">{times}{own}</data_writer>'
    for topic in (*EVERYBODYS, *(f'/{name}' for name in open_topics)):
        yield f'<data_reader profile_name="{topic}">{both}</data_reader>'

# SPDX-License-Identifier: Apache-2.0
"""A DDS partition in which the processes of a mission hear each other, and nobody else.

A node of another hand that publishes or serves a name of a running mission, for instance a vehicle
of the same name, does not match the mission's subscriptions and clients: it is not heard and not
commanded. Everybody else may still listen to the mission and call its services.

The partition is named by the token of the mission. A profile for Fast DDS puts every publisher and
subscription of the mission into the common partition and into that of the mission; what hears its
own names, and what asks its own servers, is in that of the mission alone (property ``partitions``
of Fast DDS; DDS 1.4, 2.2.3.13).
"""

from collections.abc import Iterable, Iterator, MutableMapping
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier

from rocsafe_ros.domain.network import EMPTY, END, HEARTBEATS, OURS, PROFILES, RMW, profile_of

FILE = f'{OURS}mission.xml'
# Names of an action's services and topics below its own.
ACTION_SERVICES, ACTION_TOPICS = ('send_goal', 'cancel_goal', 'get_result'), ('feedback', 'status')
_BEGIN = '<!-- of the mission -->'
_PARTITIONS = (
    '<propertiesPolicy><properties><property><name>partitions</name><value>{}</value></property>'
    '</properties></propertiesPolicy>'
)


def keep_own_names(
    environment: MutableMapping[str, str],
    folder: Path,
    token: str,
    names: Iterable[tuple[str, str]],
) -> bool:
    """Let the processes with `environment` hear some names from their own mission only.

    It has to be called before ROS is started.

    Parameters
    ----------
    environment
        Environment of the processes; the profile is added.
    folder
        Folder for the profile.
    token
        Token of the mission.
    names
        Kind (``'topic'``, ``'service'`` or ``'action'``) and name, without a slash at its
        beginning, of what only the mission's own processes may publish or serve.

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
    section = '\n'.join(sorted(set(_section(token, names, times))))
    path = folder / FILE
    path.write_text(f'{text}{_BEGIN}\n{section}{END}', encoding='utf-8')
    environment.update(dict.fromkeys(PROFILES, str(path)))
    return True


def _section(token: str, names: Iterable[tuple[str, str]], times: str) -> Iterator[str]:
    own, both = _PARTITIONS.format(token), _PARTITIONS.format(f';{token}')
    default = 'is_default_profile="true"'
    yield f'<data_writer profile_name="mission_writer" {default}>{times}{both}</data_writer>'
    yield f'<data_reader profile_name="mission_reader" {default}>{both}</data_reader>'
    for kind, name in names:
        is_action = kind == 'action'
        topics = [f'{name}/_action/{part}' for part in ACTION_TOPICS] if is_action else [name]
        services = [f'{name}/_action/{part}' for part in ACTION_SERVICES] if is_action else [name]
        for topic in topics if kind != 'service' else ():
            yield f'<data_reader profile_name="/{topic}">{own}</data_reader>'
        for service in services if kind != 'topic' else ():
            request, reply = f'rq/{service}Request', f'rr/{service}Reply'
            yield f'<data_writer profile_name="{request}">{times}{own}</data_writer>'
            yield f'<data_reader profile_name="{reply}">{own}</data_reader>'

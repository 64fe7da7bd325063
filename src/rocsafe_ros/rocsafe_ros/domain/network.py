# SPDX-License-Identifier: Apache-2.0
"""The network interfaces to which DDS is bound, and its transport.

Without a profile every participant listens on all interfaces, whatever the range of discovery is.
A profile for Fast DDS names those that are used, and the hosts that are asked for participants
where there is no multicast. It has to be set before ROS is started.

Processes talk by UDP alone, also within a machine. In shared memory a process that is killed can
leave a segment half made, a lock or the port of a dead participant: others that open it wait for
ever, end by a signal, or find each other seconds late. A socket ends with its process.
"""

import hashlib
import ipaddress
import os
import socket
from collections.abc import MutableMapping
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier

from rocsafe_ros.parameters import ParameterError

# Addresses or names of interfaces, separated by commas.
INTERFACES = 'ROCSAFE_INTERFACES'
# IPv4 addresses of hosts, separated by commas, that are asked for participants one by one. Of two
# hosts one must ask.
PEERS = 'ROCSAFE_PEERS'
RANGE, LOOPBACK_RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST'
LOOPBACK = '127.0.0.1'
# Fast DDS 2 and 3 have different names for it.
PROFILES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
RMW = 'rmw_fastrtps_cpp'
# Transports of Fast DDS where no profile says others.
TRANSPORTS, UDP = 'FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4'
# Files of our profiles begin so.
OURS = 'rocsafe_dds_'
EMPTY = """\
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com">
  <profiles>"""
END = """
  </profiles>
</dds>
"""
_PROFILE = (
    EMPTY
    + """
    <transport_descriptors>
      <transport_descriptor>
        <transport_id>udp</transport_id>
        <type>UDPv4</type>
        <receiveBufferSize>{buffer}</receiveBufferSize>
        <interfaceWhiteList>{interfaces}</interfaceWhiteList>
        <maxInitialPeersRange>{most}</maxInitialPeersRange>
      </transport_descriptor>
    </transport_descriptors>
    <participant profile_name="rocsafe" is_default_profile="true">
      <rtps>
        <userTransports>
          <transport_id>udp</transport_id>
        </userTransports>
        <useBuiltinTransports>false</useBuiltinTransports>{peers}
      </rtps>
    </participant>{writers}"""
    + END
)
# A unicast address for discovery in place of the multicast group. A participant announces itself
# to each port of each peer: by default every 3 s, which fills a radio.
_PEERS = """
        <builtin>
          <discovery_config>
            <leaseDuration><sec>30</sec></leaseDuration>
            <leaseAnnouncement><sec>8</sec></leaseAnnouncement>
          </discovery_config>
          <metatrafficUnicastLocatorList><locator><udpv4/></locator></metatrafficUnicastLocatorList>
          <initialPeersList>{peers}</initialPeersList>
        </builtin>"""
# Over a network packets are lost. A reader asks for them when it hears a heartbeat: by default
# every 3 s, while the messages behind a lost one wait.
HEARTBEATS = '<times><heartbeatPeriod><nanosec>100000000</nanosec></heartbeatPeriod></times>'
_WRITERS = f"""
    <data_writer profile_name="rocsafe_writer" is_default_profile="true">
      {HEARTBEATS}
    </data_writer>"""
_PEER = '<locator><udpv4><address>{address}</address></udpv4></locator>'
# Participants of a host that are found: each is a process, and has ports of its own.
MOST_PARTICIPANTS = 32
# A photograph comes at once, in packets of 64 KiB. The kernel gives at most its `rmem_max`; what
# does not fit is sent again.
RECEIVE_BUFFER = 4 * 1024 * 1024


def bind_interfaces(environment: MutableMapping[str, str]) -> None:
    """Bind DDS to the interfaces that `environment` names, by a profile that is added to it.

    These are loopback and those of ``ROCSAFE_INTERFACES``; without that variable, loopback alone
    where discovery is limited to this machine, else all. A profile of the user is left as it is.
    Processes that inherit the environment are bound to the same. None uses shared memory.

    Raises
    ------
    ParameterError
        If there is no such interface, or it cannot be done: nothing is bound to less than asked.
    """
    named, peers = _listed(environment, INTERFACES), _listed(environment, PEERS)
    if profile := profile_of(environment):
        if named and not profile.name.startswith(OURS):
            raise ParameterError(f'{INTERFACES} and {PROFILES[0]} are both set: set one of them')
        return
    if not _has_way_to(LOOPBACK):
        raise ParameterError(f'{LOOPBACK} cannot be reached: bring up interface lo')
    leave_shared_memory(environment)
    if not named and environment.get(RANGE) != LOOPBACK_RANGE:
        return
    if get_rmw_implementation_identifier() != RMW:
        if named:
            raise ParameterError(f'{INTERFACES} is for {RMW} only')
        return
    text = _PROFILE.format(
        interfaces=''.join(map(_element, [LOOPBACK, *named])),
        buffer=RECEIVE_BUFFER,
        most=MOST_PARTICIPANTS,
        peers=_asked(peers) if peers else '',
        writers=_WRITERS if peers else '',
    )
    environment.update(dict.fromkeys(PROFILES, str(_written(text))))
    # The range for this machine alone would open sockets beside those of the profile; that of a
    # subnet would use the multicast group.
    environment[RANGE] = 'SYSTEM_DEFAULT' if peers else 'SUBNET'


def profile_of(environment: MutableMapping[str, str]) -> Path | None:
    """Return the file of the profile for Fast DDS that `environment` names, None without one."""
    named = next((environment[name] for name in PROFILES if environment.get(name)), '')
    return Path(named) if named else None


def leave_shared_memory(environment: MutableMapping[str, str]) -> None:
    """Let DDS talk by UDP alone, unless the user has chosen transports."""
    if not any(environment.get(name) for name in (TRANSPORTS, *PROFILES)):
        environment[TRANSPORTS] = UDP


def _listed(environment: MutableMapping[str, str], variable: str) -> list[str]:
    return [one.strip() for one in environment.get(variable, '').split(',') if one.strip()]


def _asked(peers: list[str]) -> str:
    """Return the part of the profile that asks hosts, this one included, for participants."""
    for peer in peers:
        try:
            ipaddress.IPv4Address(peer)
        except ValueError:
            raise ParameterError(f'{PEERS}: {peer!r} is no IPv4 address') from None
    return _PEERS.format(peers=''.join(_PEER.format(address=one) for one in (LOOPBACK, *peers)))


def _element(interface: str) -> str:
    """Return the element of the profile for an address or a name."""
    try:
        address = ipaddress.ip_address(interface)
    except ValueError:
        known = [name for _, name in socket.if_nameindex()]
        if interface not in known:
            raise ParameterError(
                f'{INTERFACES}: {interface!r} is no address and none of {", ".join(known)}'
            ) from None
        return f'<interface>{interface}</interface>'
    if address.version != 4 or not _is_ours(interface):
        raise ParameterError(f'{INTERFACES}: {interface} is no IPv4 address of this machine')
    return f'<address>{interface}</address>'


def _is_ours(address: str) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((address, 0))
        except OSError:
            return False
    return not ipaddress.ip_address(address).is_unspecified


def _has_way_to(address: str) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((address, 9))  # nothing is sent
        except OSError:
            return False
    return True


def _written(profile: str) -> Path:
    """Return a file with `profile`, named by its content."""
    folder = Path(os.environ.get('XDG_CACHE_HOME') or Path.home() / '.cache') / 'rocsafe'
    name = f'{OURS}{hashlib.sha256(profile.encode()).hexdigest()[:16]}.xml'
    path = folder / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        part = path.with_name(f'{name}.{os.getpid()}.part')
        part.write_text(profile, encoding='utf-8')
        part.replace(path)
    except OSError as error:
        raise ParameterError(f'{path}: {error.strerror}') from error
    return path

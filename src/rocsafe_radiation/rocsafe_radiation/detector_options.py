# SPDX-License-Identifier: Apache-2.0
"""Options of the node ``detector``."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rocsafe_geo.option import option
from rocsafe_radiation.acquisition.acquisition import AcquisitionOptions
from rocsafe_radiation.acquisition.line_format import LineFormat, read_format
from rocsafe_radiation.acquisition.line_source import DatagramSource, LineSource, SerialSource


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorOptions:
    """Options of the adapter of a real detector."""

    serial: str = option('', 'serial port of its lines; or udp, or tunnel')
    baud: int = option(9600, 'baud rate of the serial port', 50)
    udp: str = option('', 'HOST:PORT where its datagrams come in')
    allow_lan: bool = option(False, 'take datagrams from beyond this machine')
    tunnel: bool = option(False, 'its lines come in MAVLink TUNNEL messages')
    format: str = option('dose_rate', 'name of the format of its lines')
    format_file: str = option('', 'YAML file of formats, docs/radiation.md; empty: built in')
    silent_after_s: float = option(5.0, 'silence after which it counts as dead, seconds')
    delay_s: float = option(
        0.0, 'time from the end of a window to the arrival of its line, seconds'
    )
    reconnect_tries: int = option(100, 'tries in a row to open its port', 1)

    def __post_init__(self) -> None:
        if [bool(self.serial), bool(self.udp), self.tunnel].count(True) != 1:
            raise ValueError('must have one of serial, udp and tunnel')

    @property
    def acquisition(self) -> AcquisitionOptions:
        """How lines become measurements."""
        return AcquisitionOptions(silent_after_s=self.silent_after_s, delay_s=self.delay_s)

    def line_format(self) -> LineFormat:
        """Return the format of the lines; raises ValueError as `read_format`."""
        return read_format(self.format, Path(self.format_file) if self.format_file else None)

    def source(self, tell: Callable[[str], None]) -> LineSource | None:
        """Return where the bytes come from; None: from the bridge.

        Raises
        ------
        ValueError
            If the port is wrong.
        """
        if self.serial:
            return SerialSource(self.serial, self.baud, self.reconnect_tries, tell)
        if self.tunnel:
            return None
        host, _, port = self.udp.rpartition(':')
        if not host or not port.isdecimal() or not int(port) < 65_536:
            raise ValueError(f'udp is {self.udp!r}: must be HOST:PORT')
        return DatagramSource(host.strip('[]'), int(port), allow_lan=self.allow_lan)

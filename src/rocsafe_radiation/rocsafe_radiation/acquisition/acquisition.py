# SPDX-License-Identifier: Apache-2.0
"""From the bytes of a detector and the places of its vehicle to dated and placed measurements.

Pure: bytes, places and times come in as arguments. The clock of a detector is compared with
ours by the line that came with the least delay; without a clock a line is dated by its arrival.
"""

import math
from bisect import bisect_left
from collections import Counter, deque
from dataclasses import dataclass

from rocsafe_radiation.acquisition.line_format import LineError, LineFormat, LineMeasurement

Coordinates = tuple[float, float, float]
NOWHERE: Coordinates = (math.nan, math.nan, math.nan)
LARGEST_LINE = 1024
LONGEST_SHOWN = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class AcquisitionOptions:
    """Options of the acquisition.

    Attributes
    ----------
    silent_after_s
        Without a good line for so long, the detector counts as silent.
    delay_s
        Time that a line needs from the end of its window to its arrival, seconds.
    largest_place_gap_s
        Two places that are further apart in time do not tell the place between them.
    place_wait_s
        A measurement waits so long for the next place.
    places_kept
        Number of places that are kept.
    clock_samples
        Lines among which the one with the least delay is searched.
    clock_jump_s
        A clock of the detector that goes back by more was set, or started, anew.
    """

    silent_after_s: float = 5.0
    delay_s: float = 0.0
    largest_place_gap_s: float = 2.0
    place_wait_s: float = 1.0
    places_kept: int = 1200
    clock_samples: int = 60
    clock_jump_s: float = 1.0

    def __post_init__(self) -> None:
        for name in ('silent_after_s', 'place_wait_s', 'largest_place_gap_s'):
            if not 0.0 < getattr(self, name) < math.inf:
                raise ValueError(f'{name} is {getattr(self, name)} s: must be above 0')
        if not 0.0 <= self.delay_s <= 60.0:
            raise ValueError(f'delay_s is {self.delay_s} s: must be within 0 and 60')


@dataclass(frozen=True, slots=True, kw_only=True)
class AcquiredMeasurement:
    """A measurement with `time_s`, the end of its window by our clock, and where that was."""

    measurement: LineMeasurement
    time_s: float
    place: Coordinates


@dataclass(frozen=True, slots=True, kw_only=True)
class AcquisitionHealth:
    """How a detector is doing.

    Attributes
    ----------
    is_silent
        Whether no good line came for too long.
    silent_s
        Time since the last good line, or since the start.
    measured
        Number of good lines.
    bad
        Number of bad lines, by kind of fault.
    last_bad
        Fault and text of the last bad line; empty: there was none.
    clock_offset_s
        Our clock less that of the detector; NaN: it tells no time.
    unplaced
        Number of measurements without a place.
    """

    is_silent: bool
    silent_s: float
    measured: int
    bad: dict[str, int]
    last_bad: str
    clock_offset_s: float
    unplaced: int


class Acquisition:
    """Reads the lines of one detector.

    Parameters
    ----------
    line_format
        Format of the lines.
    options
        See there.
    now_s
        Time of the start by our clock, seconds since 1970.
    """

    def __init__(self, line_format: LineFormat, options: AcquisitionOptions, now_s: float) -> None:
        self._format = line_format
        self._options = options
        self._rest = b''
        self._bad: Counter[str] = Counter()
        self._last_bad = ''
        self._heard_s = now_s
        self._measured = self._unplaced = 0
        self._clocks: deque[tuple[float, float]] = deque(maxlen=options.clock_samples)
        self._places: deque[tuple[float, Coordinates]] = deque(maxlen=options.places_kept)
        self._waiting: list[tuple[LineMeasurement, float, float]] = []

    def add_bytes(self, data: bytes, arrived_s: float) -> None:
        """Take bytes that came at `arrived_s` by our clock; a line may come in pieces."""
        *lines, self._rest = (self._rest + data).split(b'\n')
        if len(self._rest) > LARGEST_LINE:
            self._count_bad('too long', self._rest)
            self._rest = b''
        for line in lines:
            self._add_line(line, arrived_s)

    def add_place(self, time_s: float, place: Coordinates) -> None:
        """Take where the vehicle was at `time_s` by our clock: degrees and metres."""
        if not self._places or time_s > self._places[-1][0]:
            self._places.append((time_s, place))

    def finished(self, now_s: float) -> list[AcquiredMeasurement]:
        """Return the measurements whose place is known, or will not be known any more."""
        done, waiting = [], []
        for measurement, time_s, arrived_s in self._waiting:
            middle_s = time_s - 0.5 * measurement.window_s
            is_known = bool(self._places) and self._places[-1][0] >= middle_s
            if is_known or now_s - arrived_s >= self._options.place_wait_s:
                place = self._place_at(middle_s)
                self._unplaced += place is NOWHERE
                done.append(
                    AcquiredMeasurement(measurement=measurement, time_s=time_s, place=place)
                )
            else:
                waiting.append((measurement, time_s, arrived_s))
        self._waiting = waiting
        return done

    def health(self, now_s: float) -> AcquisitionHealth:
        """Return how the detector is doing."""
        silent_s = max(0.0, now_s - self._heard_s)
        return AcquisitionHealth(
            is_silent=silent_s > self._options.silent_after_s,
            silent_s=silent_s,
            measured=self._measured,
            bad=dict(self._bad),
            last_bad=self._last_bad,
            clock_offset_s=self._clock_offset_s(),
            unplaced=self._unplaced,
        )

    def _add_line(self, line: bytes, arrived_s: float) -> None:
        try:
            measurement = self._format.measurement(_text_of(line))
        except LineError as error:
            self._count_bad(str(error), line)
            return
        if measurement is None:
            return
        self._measured += 1
        self._heard_s = arrived_s
        time_s = self._time_of(measurement, arrived_s)
        self._waiting.append((measurement, time_s, arrived_s))

    def _count_bad(self, fault: str, line: bytes) -> None:
        kind = fault.partition(':')[0]
        self._bad[kind] += 1
        shown = line[:LONGEST_SHOWN].decode('ascii', 'backslashreplace')
        self._last_bad = f'{fault}, in {shown!r}'

    def _time_of(self, measurement: LineMeasurement, arrived_s: float) -> float:
        """Return the end of the window by our clock."""
        clock_s = measurement.clock_s
        if clock_s is None:
            return arrived_s - self._options.delay_s
        if self._clocks and clock_s < self._clocks[-1][0] - self._options.clock_jump_s:
            self._clocks.clear()
        self._clocks.append((clock_s, arrived_s - self._options.delay_s))
        return clock_s + self._clock_offset_s()

    def _clock_offset_s(self) -> float:
        return min((ours_s - clock_s for clock_s, ours_s in self._clocks), default=math.nan)

    def _place_at(self, time_s: float) -> Coordinates:
        """Return where the vehicle was at `time_s`, between two places that are near in time."""
        times = [known_s for known_s, _ in self._places]
        after = bisect_left(times, time_s)
        if after < len(times) and times[after] == time_s:
            return self._places[after][1]
        if not 0 < after < len(times):
            return NOWHERE
        (early_s, early), (late_s, late) = self._places[after - 1], self._places[after]
        if late_s - early_s > self._options.largest_place_gap_s:
            return NOWHERE
        share = (time_s - early_s) / (late_s - early_s)
        latitude, longitude, altitude = (
            a + share * (b - a) for a, b in zip(early, late, strict=True)
        )
        return latitude, longitude, altitude


def _text_of(line: bytes) -> str:
    try:
        return line.decode('ascii')
    except UnicodeDecodeError:
        raise LineError('no text: bytes beyond ASCII') from None

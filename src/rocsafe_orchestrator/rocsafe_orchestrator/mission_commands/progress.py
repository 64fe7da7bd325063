# SPDX-License-Identifier: Apache-2.0
"""Progress of a mission on the console: a live table on a terminal, plain lines elsewhere."""

import math
from collections.abc import Callable
from types import TracebackType
from typing import Protocol

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from rocsafe_orchestrator.mission.status import DosePeak, FlightState, RunStatus, VehicleStatus
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_view.formats import clock

# Wall time between two plain lines of the same phase.
PLAIN_PERIOD_S = 10.0

_STATE_STYLES = {
    FlightState.FLYING: 'green',
    FlightState.TAKING_OFF: 'green',
    FlightState.RETURNING: 'cyan',
    FlightState.LANDING: 'cyan',
    FlightState.LANDED: 'blue',
    FlightState.HOLDING: 'yellow',
    FlightState.LOST: 'bold red',
    FlightState.CRASHED: 'bold red',
    FlightState.WAITING: 'magenta',
}
_PHASE_STYLES = {
    Phase.COMPLETE: 'bold green',
    Phase.FAILED: 'bold red',
    Phase.CANCELLED: 'bold yellow',
}


class Display(Protocol):
    """Shows the progress of a run."""

    def __enter__(self) -> 'Display':
        """Start to display."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Restore the console."""

    def show(self, status: RunStatus) -> None:
        """Show `status`; called several times a second."""

    def say(self, text: str) -> None:
        """Print one line."""


def make_display(console: Console, title: str, *, is_quiet: bool) -> Display:
    """Return the display that suits `console`."""
    if is_quiet:
        return QuietDisplay()
    if console.is_terminal:
        return LiveDisplay(console, title)
    return PlainDisplay(console)


class SteadyDisplay:
    """Shows what `display` shows, and goes on when there is no terminal any more.

    Parameters
    ----------
    display
        Where to show it.
    on_lost
        Called when the terminal refuses output.
    """

    def __init__(self, display: Display, on_lost: Callable[[], None]) -> None:
        self._display = display
        self._on_lost = on_lost

    def __enter__(self) -> 'SteadyDisplay':
        self._try(self._display.__enter__)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._try(lambda: self._display.__exit__(kind, error, traceback))

    def show(self, status: RunStatus) -> None:
        """Show `status`."""
        self._try(lambda: self._display.show(status))

    def say(self, text: str) -> None:
        """Print one line."""
        self._try(lambda: self._display.say(text))

    def _try(self, act: Callable[[], object]) -> None:
        try:
            act()
        except OSError:
            self._on_lost()


class QuietDisplay:
    """Shows nothing."""

    def __enter__(self) -> 'QuietDisplay':
        return self

    def __exit__(self, *_: object) -> None:
        """Do nothing."""

    def show(self, status: RunStatus) -> None:
        """Do nothing."""

    def say(self, text: str) -> None:
        """Do nothing."""


class PlainDisplay:
    """Writes a line when the phase changes, and one every few seconds."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._phase: Phase | None = None
        self._next_s = 0.0

    def __enter__(self) -> 'PlainDisplay':
        return self

    def __exit__(self, *_: object) -> None:
        """Do nothing."""

    def show(self, status: RunStatus) -> None:
        """Write `status` if there is news."""
        if status.phase == self._phase and status.wall_time_s < self._next_s:
            return
        self._phase = status.phase
        self._next_s = status.wall_time_s + PLAIN_PERIOD_S
        self.say(plain_line(status))

    def say(self, text: str) -> None:
        """Write a line."""
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)


class LiveDisplay:
    """Redraws a table in place."""

    def __init__(self, console: Console, title: str) -> None:
        self._title = title
        self._live = Live(console=console, auto_refresh=False, transient=False)

    def __enter__(self) -> 'LiveDisplay':
        self._live.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._live.__exit__(kind, error, traceback)

    def show(self, status: RunStatus) -> None:
        """Redraw."""
        self._live.update(status_table(self._title, status), refresh=True)

    def say(self, text: str) -> None:
        """Write a line above the table."""
        self._live.console.print(Text(text))


def plain_line(status: RunStatus) -> str:
    """Return `status` in one line."""
    parts = [f'{clock(status.wall_time_s)} {status.phase.name.lower()}']
    if status.viewpoints_planned:
        seen, planned = status.viewpoints_visited, status.viewpoints_planned
        parts.append(f'waypoint {seen} of {planned}')
    if status.images_expected:
        parts.append(f'{status.images_stored} images stored')
    if status.peak is not None:
        parts.append(peak_text(status.peak))
    if status.flight_time_s:
        parts.append(f'simulated {clock(status.flight_time_s)}{_factor_text(status)}')
    if status.text:
        parts.append(status.text)
    return ', '.join(parts)


def status_table(title: str, status: RunStatus) -> RenderableType:
    """Return `status` as a headline, a table of vehicles and the figures of the fleet."""
    headline = Text.assemble(
        (title, 'bold'), '  ', (status.phase.name, _PHASE_STYLES.get(status.phase, 'bold cyan'))
    )
    rows: list[RenderableType] = [
        headline,
        _vehicle_table((*status.vehicles, *([status.driver] if status.driver else []))),
        _figures(status),
    ]
    if status.text:
        rows.append(Text(status.text, style='red'))
    return Group(*rows)


def _vehicle_table(vehicles: tuple[VehicleStatus, ...]) -> Table:
    table = Table(box=None, pad_edge=False, header_style='dim')
    for column in ('vehicle', 'state', 'waypoint', '', 'photographs', 'battery'):
        table.add_column(column, justify='right' if column in ('battery', 'waypoint') else 'left')
    for vehicle in vehicles:
        count = vehicle.viewpoint_count
        bar = ProgressBar(total=max(count, 1), completed=vehicle.viewpoints_visited, width=20)
        waiting = f' ({vehicle.shots_pending} to store)' if vehicle.shots_pending else ''
        table.add_row(
            vehicle.name,
            Text(_state_text(vehicle.state), style=_STATE_STYLES.get(vehicle.state, 'dim')),
            f'{vehicle.viewpoints_visited} of {count}' if count else '-',
            bar,
            f'{vehicle.shots_taken}{waiting}',
            percent_text(vehicle.battery_fraction),
        )
    return table


def _figures(status: RunStatus) -> Table:
    table = Table.grid(padding=(0, 2))
    table.add_column(style='dim')
    table.add_column()
    table.add_row(
        'images stored', f'{status.images_stored} for {status.images_expected} viewpoints'
    )
    table.add_row('highest reading', '-' if status.peak is None else peak_text(status.peak))
    times = f'{clock(status.flight_time_s)} under way, {clock(status.wall_time_s)} passed'
    table.add_row('time', times + _factor_text(status))
    if status.restarts:
        counts = ', '.join(f'{name} {count}' for name, count in status.restarts.items())
        table.add_row('restarts', Text(counts, style='yellow'))
    return table


def peak_text(peak: DosePeak) -> str:
    """Return the highest reading with its place."""
    place = f'{peak.position.latitude_deg:.5f}, {peak.position.longitude_deg:.5f}'
    return f'{peak.dose_rate_usvh:.3g} uSv/h by {peak.vehicle} at {place}'


def percent_text(fraction: float) -> str:
    """Return a percentage, a dash if it is unknown."""
    return '-' if math.isnan(fraction) else f'{100.0 * fraction:.0f} %'


def _factor_text(status: RunStatus) -> str:
    is_known = not math.isnan(status.real_time_factor)
    return f' ({status.real_time_factor:.1f}x real time)' if is_known else ''


def _state_text(state: FlightState) -> str:
    return state.name.lower().replace('_', ' ')

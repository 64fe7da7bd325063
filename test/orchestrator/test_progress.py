# SPDX-License-Identifier: Apache-2.0
"""What a running mission looks like on the console."""

import io
import math

from rich.console import Console

from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.msg import MissionState, VehicleState
from rocsafe_orchestrator.mission.status import DosePeak, FlightState, RunStatus, VehicleStatus
from rocsafe_orchestrator.mission_commands.progress import (
    LiveDisplay,
    PlainDisplay,
    make_display,
    percent_text,
    plain_line,
    status_table,
)
from rocsafe_orchestrator.mission_state.phase import Phase

PEAK = DosePeak(
    dose_rate_usvh=87.65, vehicle='rav2', position=GeoPosition(53.27985, -9.0633, 98.0)
)
FLYING = RunStatus(
    phase=Phase.FLYING,
    vehicles=(
        VehicleStatus(
            name='rav1',
            state=FlightState.TAKING_OFF,
            viewpoint_count=20,
            viewpoints_visited=7,
            shots_taken=7,
            shots_pending=2,
            battery_fraction=0.834,
        ),
        VehicleStatus(name='rav2'),
    ),
    images_stored=5,
    images_expected=60,
    viewpoints_planned=40,
    viewpoints_visited=7,
    peak=PEAK,
    flight_time_s=125.0,
    wall_time_s=3725.0,
    real_time_factor=21.04,
    restarts={'rav2': 1},
)


def console(*, is_terminal: bool = False) -> Console:
    """Return a console that keeps what it is given."""
    return Console(file=io.StringIO(), width=100, force_terminal=is_terminal, color_system=None)


def text_of(output: Console) -> str:
    """Return what was written."""
    assert isinstance(output.file, io.StringIO)
    return output.file.getvalue()


def test_picture_shows_every_figure() -> None:
    """Phase, waypoint, photographs, battery, highest reading, times and restarts are seen."""
    output = console()
    output.print(status_table('derailment', FLYING))
    shown = text_of(output)
    for figure in (
        'derailment  FLYING',
        'taking off',
        '7 of 20',
        '7 (2 to store)',
        '83 %',
        '5 for 60 viewpoints',
        '87.7 uSv/h by rav2 at 53.27985, -9.06330',
        '02:05 under way, 1:02:05 passed (21.0x real time)',
        'rav2 1',
    ):
        assert figure in shown


def test_plain_line_says_the_same_in_one_line() -> None:
    """Where the output is no terminal a line has the figures of the fleet."""
    assert plain_line(FLYING) == (
        '1:02:05 flying, waypoint 7 of 40, 5 images stored, 87.7 uSv/h by rav2 at 53.27985, '
        '-9.06330, simulated 02:05 (21.0x real time)'
    )


def test_plain_display_writes_on_a_new_phase_and_every_ten_seconds() -> None:
    """A log file is not flooded."""
    output = console()
    display = PlainDisplay(output)
    for wall_time_s in (0.0, 5.0, 9.9, 10.0):
        display.show(RunStatus(phase=Phase.STARTING, wall_time_s=wall_time_s))
    display.show(RunStatus(phase=Phase.PLANNING, wall_time_s=10.1))
    assert text_of(output).splitlines() == ['00:00 starting', '00:10 starting', '00:10 planning']


def test_display_suits_the_console() -> None:
    """A terminal gets a live table, a file plain lines, nobody anything when quiet."""
    assert isinstance(make_display(console(is_terminal=True), '', is_quiet=False), LiveDisplay)
    assert isinstance(make_display(console(), '', is_quiet=False), PlainDisplay)
    output = console(is_terminal=True)
    with make_display(output, '', is_quiet=True) as quiet:
        quiet.show(FLYING)
        quiet.say('hello')
    assert text_of(output) == ''


def test_live_display_leaves_the_last_picture() -> None:
    """The end of a mission stays on the screen."""
    output = console(is_terminal=True)
    with make_display(output, 'derailment', is_quiet=False) as display:
        display.show(FLYING)
        display.say('rav2 was ended by SIGKILL')
        display.show(RunStatus(phase=Phase.FAILED, text='rav1: gone'))
    assert 'rav2 was ended by SIGKILL' in text_of(output)
    assert 'rav1: gone' in text_of(output)


def test_unknown_figures_are_dashes() -> None:
    """What is not known is not shown as a number."""
    assert percent_text(math.nan) == '-'
    output = console()
    output.print(status_table('x', RunStatus(phase=Phase.STARTING)))
    assert 'nan' not in text_of(output).lower()


def test_numbers_of_phases_and_states_are_those_of_the_messages() -> None:
    """The core's enumerations and the messages' constants agree, name by name."""
    for phase in Phase:
        assert getattr(MissionState, phase.name) == phase
    for state in FlightState:
        assert getattr(VehicleState, state.name) == state

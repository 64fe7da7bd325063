# SPDX-License-Identifier: Apache-2.0
"""Lines of a real detector become dated, placed readings, and bad ones are counted by name."""

import math
import os
import pty
import socket

import numpy as np
import pytest
import yaml

from rocsafe_radiation.acquisition.acquisition import NOWHERE, Acquisition, AcquisitionOptions
from rocsafe_radiation.acquisition.line_format import (
    LineColumn,
    LineError,
    LineFormat,
    read_format,
)
from rocsafe_radiation.acquisition.line_source import DatagramSource, SerialSource
from rocsafe_radiation.errors import DetectorLostError
from rocsafe_radiation.readings.survey import LocalReading, survey_of

NOW_S = 1_767_225_600.0
START = (47.0, 8.0, 500.0)


def columns(*names):
    """Return columns: ``quantity`` or ``quantity unit``."""
    parts = [name.partition(' ') for name in names]
    return tuple(LineColumn(quantity=quantity, unit=unit) for quantity, _, unit in parts)


RATE = LineFormat(name='rate', columns=columns('dose_rate uSv/h'), relative_std=0.2)
TIMED = LineFormat(name='timed', columns=columns('uptime s', 'dose_rate uSv/h'), relative_std=0.2)


def test_built_in_formats_can_be_used():
    """Each as its comment says."""
    assert read_format('dose_rate').measurement('0.12').dose_rate_usvh == 0.12
    timed = read_format('timed_dose_rate').measurement('1767225600, 2.0, 100, 1')
    assert (timed.clock_s, timed.counts, timed.window_s) == (NOW_S, 100, 1.0)
    assert timed.dose_rate_std_usvh == pytest.approx(0.2)
    with pytest.raises(ValueError, match="format is 'x': must be one of dose_rate"):
        read_format('x')


@pytest.mark.parametrize(
    ('units', 'line', 'rate_usvh'),
    [
        ('nSv/h', '120', 0.12),
        ('uSv/h', '120', 120.0),
        ('mSv/h', '1.5', 1500.0),
        ('Sv/h', '1e-3', 1000.0),
    ],
)
def test_dose_rates_have_units(units, line, rate_usvh):
    """A factor of a thousand is never guessed."""
    kind = LineFormat(name='x', columns=columns(f'dose_rate {units}'), relative_std=0.1)
    measured = kind.measurement(line)
    assert measured.dose_rate_usvh == pytest.approx(rate_usvh)
    assert measured.dose_rate_std_usvh == pytest.approx(0.1 * rate_usvh)


def test_counts_become_a_dose_rate_by_the_sensitivity():
    """300 counts in 2 s at 15 cps per uSv/h, with their uncertainty; 0 counts are not certain."""
    kind = LineFormat(
        name='x',
        separator='',
        columns=columns('skip', 'counts', 'saturated'),
        window_s=2.0,
        sensitivity_cps_per_usvh=15.0,
    )
    measured = kind.measurement('S01   300  1')
    assert measured.dose_rate_usvh == pytest.approx(10.0)
    assert measured.dose_rate_std_usvh == pytest.approx(10.0 / math.sqrt(300.0))
    assert measured.is_saturated
    nothing = kind.measurement('S01 0 0')
    assert (nothing.dose_rate_usvh, nothing.is_saturated) == (0.0, False)
    assert nothing.dose_rate_std_usvh == pytest.approx(1.0 / 30.0)
    by_minute = LineFormat(
        name='x', columns=columns('count_rate 1/min'), window_s=1.0, sensitivity_cps_per_usvh=10.0
    )
    assert by_minute.measurement('600').dose_rate_usvh == pytest.approx(1.0)


def test_dark_counts_are_no_dose_rate():
    """Neither in a line nor in the survey of many: a tube over 0.10 uSv/h."""
    kind = LineFormat(
        name='tube',
        columns=columns('counts'),
        window_s=1.0,
        sensitivity_cps_per_usvh=2.5,
        dark_rate_cps=0.2,
    )
    assert kind.measurement('0').dose_rate_usvh == 0.0
    two = kind.measurement('2')
    assert (two.dose_rate_usvh, two.live_time_s) == (pytest.approx(0.72), 1.0)
    assert two.dose_rate_std_usvh == pytest.approx(math.sqrt(2.0) / 2.5)
    counts = np.random.default_rng(1).poisson(0.45, 10_000)
    lines = [kind.measurement(str(count)) for count in counts.tolist()]
    survey = survey_of(
        [
            LocalReading(
                position_enu_m=(0.0, 0.0, 30.0),
                dose_rate_usvh=one.dose_rate_usvh,
                dose_rate_std_usvh=one.dose_rate_std_usvh,
                counts=one.counts,
                live_time_s=one.live_time_s,
            )
            for one in lines
        ]
    )
    level = survey.net_counts.sum() / survey.exposures.sum()
    assert level == pytest.approx((counts.mean() - 0.2) / 2.5)


@pytest.mark.parametrize(
    ('content', 'words'),
    [
        ({'columns': [{'quantity': 'dose', 'unit': 'Sv'}]}, 'dose'),
        ({'columns': [{'quantity': 'dose_rate', 'unit': 'R/h'}]}, "is 'R/h': must be one of"),
        ({'columns': [{'quantity': 'counts'}]}, 'must have dose_rate, or count_rate'),
        ({'columns': [{'quantity': 'dose_rate', 'unit': 'uSv/h'}]}, 'relative_std must be set'),
        ({'columns': [{'quantity': 'skip'}], 'separater': ';'}, 'did you mean separator'),
        ({'columns': [], 'window_s': -1}, 'window_s is -1'),
        ({'columns': [], 'measures': 'gas'}, 'measures'),
        (
            {'columns': [{'quantity': q, 'unit': 's'} for q in ('uptime', 'unix_time')]},
            'not both',
        ),
    ],
)
def test_wrong_format_is_refused_in_a_line(tmp_path, content, words):
    """The line names file, format and mistake."""
    path = tmp_path / 'mine.yaml'
    path.write_text(yaml.safe_dump({'formats': [{'name': 'x', **content}]}))
    with pytest.raises(ValueError, match=r'^mine.yaml: formats\[0\]') as refusal:
        read_format('x', path)
    assert words in str(refusal.value)


@pytest.mark.parametrize(
    ('line', 'kind'),
    [
        ('1.0,2.0', 'wrong number of columns'),
        ('abc', 'no number'),
        ('nan', 'out of range'),
        ('inf', 'out of range'),
        ('-0.1', 'out of range'),
        ('1e13', 'out of range'),
    ],
)
def test_bad_line_is_no_measurement(line, kind):
    """Nothing is guessed from it."""
    with pytest.raises(LineError, match=f'^{kind}'):
        RATE.measurement(line)
    assert RATE.measurement('  # a comment') is None
    assert RATE.measurement('') is None


def test_bad_lines_are_counted_and_the_last_is_shown():
    """By kind; a flood without a line end is bounded."""
    acquisition = Acquisition(RATE, AcquisitionOptions(), NOW_S)
    acquisition.add_bytes(b'0.1\nx\n1,2\ny\n\xff\xfe\n', NOW_S)
    acquisition.add_bytes(b'7' * 5000, NOW_S)
    health = acquisition.health(NOW_S)
    assert health.measured == 1
    assert health.bad == {
        'no number': 2,
        'wrong number of columns': 1,
        'no text': 1,
        'too long': 1,
    }
    assert health.last_bad.startswith("too long, in '7777")
    acquisition.add_bytes(b'\n0.2\n', NOW_S)
    assert acquisition.health(NOW_S).measured == 2


def flown(acquisition, seconds, start_s=NOW_S):
    """Let the vehicle fly north, 1e-5 degrees a second, with a fix each 0.2 s."""
    for step in range(round(5 * seconds) + 1):
        time_s = start_s + 0.2 * step
        latitude = START[0] + 1e-5 * (time_s - NOW_S)
        acquisition.add_place(time_s, (latitude, *START[1:]))


def test_line_in_pieces_is_placed_at_the_middle_of_its_window():
    """Dated by arrival less the delay, and placed between two fixes."""
    kind = LineFormat(name='x', columns=columns('dose_rate uSv/h'), relative_std=0.1, window_s=2.0)
    acquisition = Acquisition(kind, AcquisitionOptions(delay_s=0.5), NOW_S)
    flown(acquisition, 3.0)
    acquisition.add_bytes(b'0.', NOW_S + 3.6)
    assert acquisition.finished(NOW_S + 3.6) == []
    acquisition.add_bytes(b'25\r\n', NOW_S + 3.6)
    (done,) = acquisition.finished(NOW_S + 3.6)
    assert done.time_s == pytest.approx(NOW_S + 3.1)
    assert done.place[0] == pytest.approx(START[0] + 2.1e-5, abs=1e-9)
    assert done.measurement.dose_rate_usvh == 0.25


def test_measurement_waits_for_the_next_fix_but_not_for_ever():
    """Without one its place is not known, and that is counted."""
    acquisition = Acquisition(RATE, AcquisitionOptions(place_wait_s=1.0), NOW_S)
    flown(acquisition, 1.0)
    acquisition.add_bytes(b'1\n', NOW_S + 1.1)
    assert acquisition.finished(NOW_S + 1.2) == []
    flown(acquisition, 0.2, NOW_S + 1.2)
    (placed,) = acquisition.finished(NOW_S + 1.3)
    assert placed.place[0] == pytest.approx(START[0] + 1.1e-5, abs=1e-9)
    acquisition.add_bytes(b'2\n', NOW_S + 5.0)
    assert acquisition.finished(NOW_S + 5.9) == []
    (lost,) = acquisition.finished(NOW_S + 6.0)
    assert lost.place is NOWHERE
    flown(acquisition, 1.0, NOW_S + 8.0)
    acquisition.add_bytes(b'3\n', NOW_S + 5.5)
    (between,) = acquisition.finished(NOW_S + 9.0)
    assert between.place is NOWHERE
    assert acquisition.health(NOW_S + 9.0).unplaced == 2


def test_clock_of_the_detector_dates_lines_that_were_late():
    """The offset is that of the line with the least delay; a restart of the clock begins anew."""
    acquisition = Acquisition(TIMED, AcquisitionOptions(), NOW_S)
    flown(acquisition, 30.0)
    for uptime_s, delay_s in ((100.0, 0.3), (101.0, 0.05), (102.0, 3.0)):
        arrived_s = NOW_S + uptime_s - 100.0 + delay_s
        acquisition.add_bytes(f'{uptime_s},1\n'.encode(), arrived_s)
    *_, late = acquisition.finished(NOW_S + 10.0)
    assert late.time_s == pytest.approx(NOW_S + 2.05)
    assert acquisition.health(NOW_S).clock_offset_s == pytest.approx(NOW_S - 100.0 + 0.05)
    acquisition.add_bytes(b'0.5,1\n', NOW_S + 12.0)
    (restarted,) = acquisition.finished(NOW_S + 13.0)
    assert restarted.time_s == pytest.approx(NOW_S + 12.0)


def test_silence_is_told():
    """From the start, and again after good lines; bad ones do not end it."""
    acquisition = Acquisition(RATE, AcquisitionOptions(silent_after_s=5.0), NOW_S)
    assert not acquisition.health(NOW_S + 5.0).is_silent
    acquisition.add_bytes(b'rubbish\n', NOW_S + 5.5)
    assert acquisition.health(NOW_S + 5.5).is_silent
    acquisition.add_bytes(b'1\n', NOW_S + 6.0)
    assert not acquisition.health(NOW_S + 6.0).is_silent
    assert acquisition.health(NOW_S + 20.0).silent_s == pytest.approx(14.0)


def test_serial_port_is_opened_again_and_given_up(tmp_path):
    """A pseudo terminal: its lines, its end, its return, and the last try."""
    master, slave = pty.openpty()
    link, told = tmp_path / 'port', []
    link.symlink_to(os.ttyname(slave))
    source = SerialSource(str(link), 9600, 3, told.append)
    assert source.take(0.0) == []
    os.write(master, b'0.1\n0.2\n')
    assert b''.join(source.take(0.1)) == b'0.1\n0.2\n'
    os.close(master)
    os.close(slave)
    assert source.take(0.2) == []
    assert source.take(1.0) == []
    master, slave = pty.openpty()
    link.unlink()
    link.symlink_to(os.ttyname(slave))
    assert source.take(2.0) == []
    os.write(master, b'0.3\n')
    assert source.take(2.1) == [b'0.3\n']
    link.unlink()
    os.close(master)
    os.close(slave)
    source.take(3.0)
    assert source.take(4.5) == []
    assert source.take(5.0) == []
    assert source.take(5.6) == []
    with pytest.raises(DetectorLostError, match='given up after 3 tries'):
        source.take(10.0)
    words = ' '.join(told)
    assert words.count(': open') == 2
    assert words.count('the connection broke') == 2
    assert 'No such file or directory: try 1 of 3' in words
    source.close()
    with pytest.raises(ValueError, match='the system has no such rate'):
        SerialSource(str(link), 9601, 3, told.append)


def test_datagrams_are_lines_and_stay_on_this_machine():
    """The last line of a datagram needs no end; a network has to be allowed."""
    source = DatagramSource('127.0.0.1', 0, allow_lan=False)
    sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sender.sendto(b'1\n2', ('127.0.0.1', source.port))
    assert source.take(0.0) == [b'1\n2\n']
    assert source.take(0.0) == []
    with pytest.raises(ValueError, match='in use'):
        DatagramSource('127.0.0.1', source.port, allow_lan=False)
    sender.close()
    source.close()
    with pytest.raises(ValueError, match='set allow_lan: true'):
        DatagramSource('0.0.0.0', 0, allow_lan=False)  # noqa: S104
    DatagramSource('0.0.0.0', 0, allow_lan=True).close()  # noqa: S104

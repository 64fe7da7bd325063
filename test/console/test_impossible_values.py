# SPDX-License-Identifier: Apache-2.0
"""A detector, receiver or node that tells an impossible number blinds nobody to all the others."""

import asyncio
import json
import math
import time
from xml.etree import ElementTree as Xml

import pytest
from test.console.caller import Caller
from test.console.stage import TOKEN, Stage, served
from test.console.test_hostile_clients import frames_read

from rocsafe_console.outward.cursor_on_target import events_of
from rocsafe_console.outward.features import COLLECTIONS, items_of
from rocsafe_console.picture.gas import GasNow
from rocsafe_console.picture.picture import Reading
from rocsafe_console.picture.vehicle import VehicleReport

NUMBERS = (math.nan, math.inf, -math.inf, 91.0, -181.0, 1e308, -1e308, 5e-324)


def rate_of(value: float, place: tuple[float, float] = (53.28, -9.0633)) -> Reading:
    """Return a dose rate of the first vehicle."""
    return Reading(
        vehicle='rav1', stamp_s=time.time(), dose_rate_usvh=value, std_usvh=value,
        latitude_deg=place[0], longitude_deg=place[1], detector='nai_3x3',
    )  # fmt: skip


def say(picture, bad: float) -> None:
    """Let the first vehicle and the localizers tell a number in each of their places."""
    now_s = time.time()
    report = {'name': 'rav1', 'state': 255, 'battery_fraction': bad, 'speed_mps': bad}
    place = {'latitude_deg': bad, 'longitude_deg': bad, 'altitude_m': bad}
    picture.on_report(VehicleReport(stamp_s=now_s, **report, **place), now_s)
    picture.on_report(VehicleReport(stamp_s=bad, **{**report, 'name': 'new'}, **place), now_s)
    for fix in ((bad, 1.0, 1.0), (1.0, bad, 1.0), (1.0, 1.0, bad)):
        picture.on_fix('rav1', fix, now_s, now_s)
        picture.on_home('rav1', fix)
    picture.on_fix('rav1', (1.0, 1.0, 1.0), bad, now_s)
    picture.on_dose('rav1', bad, now_s, now_s, is_lower_limit=False)
    picture.on_reading(rate_of(bad), now_s)
    picture.on_reading(rate_of(1e9, (bad, 1.0)), now_s)
    gas = {'vehicle': 'rav1', 'stamp_s': now_s, 'unit': 'ppm', 'sensor': 's', 'std': bad}
    for value, latitude in ((bad, 1.0), (1e9, bad)):
        picture.on_gas(
            GasNow(
                value=value, latitude_deg=latitude, longitude_deg=1.0, calibration_gas='', **gas
            ),
            now_s,
        )
    put = picture.sections.put
    source = {'id': 0, 'half_axes_m': [bad, bad], 'dose_rate_at_1m_usvh': bad, 'probability': ''}
    release = {'id': 0, 'radius_95_m': bad, 'rate': bad}
    places = ([1.0, 1.0], [bad, bad])
    put('sources', {'sources': [{**source, 'place': one} for one in places]})
    releases = [{**release, 'place': one} for one in places]
    put('releases', {'agent': '', 'rate_unit': '', 'releases': releases})
    ring = [[1.0, 1.0], [2.0, bad], [3.0, 3.0], [1.0, 2.0]]
    put('cordons', [{'level_usvh': bad, 'is_mean': False, 'ring': ring}])
    put('region', {'name': '', 'rings': [[]]})


@pytest.mark.parametrize('bad', NUMBERS)
def test_everything_can_still_be_shown_and_sent(tmp_path, bad):
    """To pages, to TAK and to programs of maps; in forms that they can read."""
    stage = Stage(tmp_path)
    stage.begin()
    picture, now_s = stage.context.live.picture, time.time()
    say(picture, bad)
    picture.refresh()
    assert len([frame.pack() for frame in picture.frames(now_s)]) == len(stage.names) + 1
    json.dumps([rate for track in picture.tracks().values() for rate in track if rate == rate])
    for event in events_of(picture, now_s):
        Xml.fromstring(event.to_xml(now_s))  # noqa: S314 - our own
    for name in COLLECTIONS:
        items_of('', name, picture, now_s, {'bbox': '-180,-90,180,90'})


@pytest.mark.parametrize('bad', [math.nan, math.inf, 1e300])
def test_a_rate_that_is_none_hides_no_other(tmp_path, bad):
    """Neither the worst one before it nor those that come after."""
    stage = Stage(tmp_path)
    stage.begin()
    picture, now_s = stage.context.live.picture, time.time()
    picture.worst = None
    for value in (bad, 4.0, bad, 9.0, bad):
        picture.on_reading(rate_of(value), now_s)
    assert picture.worst.dose_rate_usvh == 9.0
    assert picture.newest.dose_rate_usvh == 9.0


def test_a_note_of_any_letters_is_an_event(tmp_path):
    """Letters that XML cannot hold would end the connection to a TAK server."""
    stage = Stage(tmp_path)
    stage.begin()
    text = 'drum\x00\x0b\ud800\ufffe & <b>'
    mark = {'text': text, 'by': 'anna', 'latitude_deg': 1.0, 'longitude_deg': 1.0, 'time_s': 1.0}
    stage.context.live.picture.sections.put('marks', [mark])
    events = events_of(stage.context.live.picture, 1.0)
    told = [Xml.fromstring(event.to_xml(1.0)) for event in events]  # noqa: S314 - our own
    remarks = [event.findtext('detail/remarks') or '' for event in told]
    assert 'drum\ufffd\ufffd\ufffd\ufffd & <b> (anna)' in remarks


@pytest.mark.slow
def test_a_fault_that_nobody_has_foreseen_is_told_and_the_page_goes_on(
    tmp_path, monkeypatch, capsys
):
    """Each page would show an old picture for ever, and say only that it is not live."""
    stage = Stage(tmp_path)
    stage.begin()
    picture = stage.context.live.picture
    whole, faults = picture.frames, iter(range(2))

    def frames(now_s: float) -> list:
        if next(faults, None) is not None:
            raise RuntimeError('nobody has foreseen this')
        return whole(now_s)

    with served(stage) as address:
        caller = Caller(address)
        caller.ask('/api/token', {'token': TOKEN})
        monkeypatch.setattr(picture, 'frames', frames)
        assert asyncio.run(frames_read(caller, stage.step, 3)) == 3
    assert capsys.readouterr().out.count('RuntimeError: nobody has foreseen this') == 1

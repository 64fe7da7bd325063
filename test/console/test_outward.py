# SPDX-License-Identifier: Apache-2.0
"""What other systems read: Cursor on Target and OGC API Features."""

import socket
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import pytest
from shapely.geometry import shape
from test.console.caller import Caller
from test.console.stage import TOKEN, Stage, served

from rocsafe_console.outward.cursor_on_target import STALE_S, events_of
from rocsafe_console.outward.event_target import EventTarget
from rocsafe_console.outward.features import COLLECTIONS, items_of

DEADLINE_S = 20.0


@pytest.fixture
def stage(tmp_path) -> Stage:
    """Return a mission with everything."""
    stage = Stage(tmp_path)
    stage.begin()
    stage.step()
    mark = {'latitude_deg': 53.28, 'longitude_deg': -9.06, 'text': 'a bag', 'by': 'anna'}
    stage.context.live.picture.sections.put('marks', [{**mark, 'time_s': 1.0}])
    return stage


def test_events_have_what_a_receiver_needs(stage):
    """Vehicles, source, release, lines and mark, each with place, kind and end; parsed as XML."""
    now_s = time.time()
    found = [
        ElementTree.fromstring(event.to_xml(now_s))  # noqa: S314 - our own
        for event in events_of(stage.context.live.picture, now_s)
    ]
    kinds = [event.get('type') for event in found]
    assert kinds.count('a-f-A-M-H-Q') == 3
    assert kinds.count('b-m-p-s-m') == 3
    assert kinds.count('u-d-f') == 3
    assert len({event.get('uid') for event in found}) == len(found)
    for event in found:
        point = event.find('point')
        assert 53.0 < float(point.get('lat')) < 54.0
        assert -10.0 < float(point.get('lon')) < -9.0
        assert event.get('time') < event.get('stale')
        assert event.find('detail/contact').get('callsign')
    vehicle = found[0]
    assert float(vehicle.find('point').get('hae')) == 90.0
    assert len(ElementTree.tostring(found[kinds.index('u-d-f')])) < 1400


def test_events_tell_how_a_place_came_about_and_what_is_simulated(stage):
    """As the base schema has `how`, `opex` and errors of one deviation; lines as ATAK has them."""
    picture, now_s = stage.context.live.picture, time.time()

    def told() -> dict[str, ElementTree.Element]:
        events = (event.to_xml(now_s) for event in events_of(picture, now_s))
        return {
            one.get('uid').split('.', 2)[2]: one for one in map(ElementTree.fromstring, events)
        }

    found = told()
    hows = {name: event.get('how') for name, event in found.items()}
    assert (hows['rav1'], hows['source.0'], hows['mark.1']) == ('m-s', 'm-f', 'h-e')
    assert {event.get('opex') for event in found.values()} == {'s'}
    # The half axis of the ellipse of 95 % is 9 m.
    assert float(found['source.0'].find('point').get('ce')) == pytest.approx(
        9.0 / 2.4477, abs=0.05
    )
    assert '95 % within 9.0 m' in found['source.0'].find('detail/remarks').text
    parts = [part.tag for part in found['cordon.1'].find('detail') if part.tag != 'link']
    style = ['strokeColor', 'strokeWeight', 'fillColor', 'contact', 'remarks', 'labels_on']
    assert parts == style
    one = picture.vehicles['rav1']
    one.report = replace(one.report, is_simulated=False)
    found = told()
    assert (found['rav1'].get('how'), found['rav1'].get('opex')) == ('m-g', None)
    assert found['rav2'].get('opex') == 's'
    assert found['source.0'].get('opex') is None
    assert 'simulated' in found['rav2'].find('detail/remarks').text
    assert 'simulated' not in found['rav1'].find('detail/remarks').text


def test_a_ground_vehicle_is_told_as_one(tmp_path):
    """On the ground, not as a rotary aircraft, and with the words for what drives."""
    stage = Stage(tmp_path, vehicles=1, has_rover=True)
    stage.begin()
    found = events_of(stage.context.live.picture, time.time())
    told = {event.callsign: (event.kind, event.remarks.split(',')[0]) for event in found[:2]}
    assert told == {'rav1': ('a-f-A-M-H-Q', 'flying'), 'rgv1': ('a-f-G-E-V', 'driving')}


def test_a_vehicle_that_is_silent_is_not_sent(stage):
    """The receiver would take an old place for a new one."""
    now_s = time.time() + STALE_S + 1.0
    kinds = [event.kind for event in events_of(stage.context.live.picture, now_s)]
    assert 'a-f-A-M-H-Q' not in kinds
    assert 'u-d-f' in kinds


def test_an_estimate_is_told_with_its_age(stage):
    """It is sent until there is another one: the receiver must not take it for one of now."""
    put, value = stage.context.live.picture.sections.put, stage.context.live.picture.sections.value
    now_s = 1.8e9
    for name in ('sources', 'releases'):
        put(name, {**value(name), 'heard_s': now_s - 600.0})
    put('cordons_heard_s', now_s - 600.0)
    events = events_of(stage.context.live.picture, now_s)
    told = [event.remarks for event in events if 'estimated' in event.remarks]
    assert sum('estimated at 07:50:00 UTC' in text for text in told) == 4
    # Nobody has told when the threat zones were computed.
    assert sum('nobody knows when' in text for text in told) == 1
    for name in ('sources', 'releases', 'cordons', 'threat_zones'):
        found = items_of('', name, stage.context.live.picture, now_s, {})['features']
        age_s = None if name == 'threat_zones' else 600.0
        assert {one['properties']['age_s'] for one in found} == {age_s}


@pytest.mark.slow
def test_events_are_sent_as_datagrams(stage):
    """To the address that was given."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(('127.0.0.1', 0))
        receiver.settimeout(DEADLINE_S)
        host, port = receiver.getsockname()
        target = EventTarget(host=host, port=port)
        stage.context.options = replace(stage.context.options, cursor_on_target=target)
        with served(stage):
            data = receiver.recv(65536)
    assert ElementTree.fromstring(data).tag == 'event'  # noqa: S314 - our own


def test_every_collection_is_geojson_by_its_address(stage):
    """From the landing page on, by the links that it gives; geometries are valid."""
    with served(stage) as address:
        caller = Caller(address)
        caller.ask('/api/token', {'token': TOKEN})
        url = caller.ask('/api/links', {})[1]['url'].removeprefix(address.rstrip('/'))
        caller.cookie = ''
        _, landing = caller.ask(url)
        # Some clients, such as OWSLib, put a slash at the end.
        assert caller.ask(f'{url}/')[1] == landing
        data = next(one['href'] for one in landing['links'] if one['rel'] == 'data')
        _, listed = caller.ask(data.removeprefix(address.rstrip('/')))
        assert [one['id'] for one in listed['collections']] == list(COLLECTIONS)
        for one in listed['collections']:
            path = one['links'][0]['href'].removeprefix(address.rstrip('/'))
            status, content = caller.ask(path)
            assert status == 200
            assert content['features'], one['id']
            for feature in content['features']:
                assert shape(feature['geometry']).is_valid
        items = f'{url}/collections/vehicles/items'
        assert caller.ask(f'{items}?limit=10001')[1]['numberReturned'] == 3
        pages = [caller.ask(f'{items}?limit=2')[1]]
        following = next(one['href'] for one in pages[0]['links'] if one['rel'] == 'next')
        pages.append(caller.ask(following.removeprefix(address.rstrip('/')))[1])
        assert [one['numberReturned'] for one in pages] == [2, 1]
        assert [one['numberMatched'] for one in pages] == [3, 3]
        ids = [feature['id'] for page in pages for feature in page['features']]
        assert [caller.ask(f'{items}/{number}')[1]['id'] for number in ids] == ids
        assert caller.ask(f'{items}/4')[0] == 404
        here, elsewhere = '-9.1,53.2,-9.0,53.3', '9.0,53.2,9.1,53.3'
        over_180 = '170,53.2,-9.0,53.3'
        found = [
            caller.ask(f'{items}?bbox={box}')[1]['numberMatched']
            for box in (here, elsewhere, over_180)
        ]
        assert found == [3, 0, 3]
        for wrong in ('bbox=1,2,3', 'bbox=a,b,c,d', 'offset=-1', 'limit=x'):
            assert caller.ask(f'{items}?{wrong}')[0] == 400
        described = next(one for one in landing['links'] if one['rel'] == 'service-desc')
        status, _ = caller.ask(described['href'].removeprefix(address.rstrip('/')))
        kind = caller.headers['Content-Type'].replace(' ', '')
        assert (status, kind) == (200, described['type'])
        assert caller.ask(f'{url}/collections/none/items')[0] == 404
        assert caller.ask(f'{url}/collections/vehicles/items?limit=0')[0] == 400
        assert caller.ask('/ogc/wrong/collections')[0] == 401
        caller.cookie = f'{stage.context.options.cookie}={url.split("/")[2]}'
        body = {'request_id': 'a' * 32, 'verb': 'hold', 'revisions': {'rav1': 1}}
        assert caller.ask('/api/orders', body)[0] == 401

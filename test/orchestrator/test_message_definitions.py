# SPDX-License-Identifier: Apache-2.0
"""Embedded definitions are complete: every type used is defined, once, by its short name."""

import pytest

from rocsafe_orchestrator.recording.message_definitions import DefinitionError, MessageDefinitions

SEPARATOR = '=' * 80


@pytest.fixture
def definitions(tmp_path):
    """A type of three packages, one of them behind another."""
    sources = {
        'a_msgs/msg/Track': 'b_msgs/Point[] points  # b_msgs/Wrong in a comment\nLeg leg\n',
        'a_msgs/msg/State': 'uint8 ON=1\nint8 OFF = -1\n# why\n\nstd_msgs/Header header\n',
        'a_msgs/msg/Leg': 'uint8 LONG=1\nstring<=8 name\nfloat64[<=3] sizes\nb_msgs/Point end\n',
        'b_msgs/msg/Point': 'std_msgs/Header header\nfloat64 x 1.0\n',
        'std_msgs/msg/Header': 'string frame_id\n',
    }
    for name, text in sources.items():
        package, _, short = name.split('/')
        folder = tmp_path / 'share' / package / 'msg'
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f'{short}.msg').write_text(text, encoding='utf-8')
    return MessageDefinitions([tmp_path / 'nowhere', tmp_path])


def test_each_type_used_is_defined_once(definitions):
    """Types used twice appear once; those in comments not at all."""
    parts = definitions.text('a_msgs/msg/Track').split(SEPARATOR + '\n')
    assert parts[0].startswith('b_msgs/Point[] points')
    names = [part.splitlines()[0] for part in parts[1:]]
    assert names == ['MSG: b_msgs/Point', 'MSG: a_msgs/Leg', 'MSG: std_msgs/Header']


def test_header_is_recognised_as_first_field_only(definitions):
    """Only then do serialised messages start with a stamp."""
    assert definitions.starts_with_header('b_msgs/msg/Point')
    assert definitions.starts_with_header('a_msgs/msg/State')
    assert not definitions.starts_with_header('a_msgs/msg/Track')


def test_missing_type_is_named(definitions):
    """The error says what was looked for and where."""
    with pytest.raises(DefinitionError, match=r"'a_msgs/msg/Lost' below .*nowhere"):
        definitions.text('a_msgs/msg/Lost')


def test_own_types_have_a_definition_and_a_hash():
    """The index of this environment, wheels or distribution, is read."""
    pytest.importorskip('rocsafe_interfaces', reason='no ROS 2 here: source it or run make setup')
    found = MessageDefinitions.of_environment()
    text = found.text('rocsafe_interfaces/msg/SurveyPlan')
    assert 'MSG: rocsafe_interfaces/Viewpoint' in text
    assert found.type_hash('rocsafe_interfaces/msg/SurveyPlan').startswith('RIHS01_')

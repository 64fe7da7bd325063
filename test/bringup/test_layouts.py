# SPDX-License-Identifier: Apache-2.0
"""Layouts hold what RViz, Foxglove and Lichtblick read, and topics of kinds that they can show."""

import json
from pathlib import Path

import pytest
import yaml

VIEWS = Path(__file__).resolve().parents[2] / 'src/rocsafe_bringup/view'
pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

# RViz: rviz_default_plugins, plugins_description.xml and the properties that the classes make, in
# its sources of October 2024. A property that it does not know, or an option that is none, it
# leaves out without a word.
_QOS = {
    'Value': str, 'Depth': int, 'History Policy': ('Keep Last', 'Keep All', 'System Default'),
    'Reliability Policy': ('Reliable', 'Best Effort', 'System Default'),
    'Durability Policy': ('Transient Local', 'Volatile', 'System Default'),
}  # fmt: skip
_COLOUR = '0-255; 0-255; 0-255'
RVIZ_DISPLAYS = {
    'rviz_default_plugins/Map': {
        'Topic': _QOS, 'Alpha': float, 'Draw Behind': bool, 'Use Timestamp': bool,
        'Color Scheme': ('map', 'costmap', 'raw'),
    },
    'rviz_default_plugins/MarkerArray': {'Topic': _QOS, 'Namespaces': dict},
    'rviz_default_plugins/Path': {
        'Topic': _QOS, 'Alpha': float, 'Color': _COLOUR, 'Line Style': ('Lines', 'Billboards'),
        'Line Width': float, 'Buffer Length': int,
    },
    'rviz_default_plugins/TF': {
        'Show Names': bool, 'Show Axes': bool, 'Show Arrows': bool, 'Marker Scale': float,
        'Frame Timeout': float,
    },
}  # fmt: skip
RVIZ_OTHERS = {
    'Panels': {'rviz_common/Displays', 'rviz_common/Time', 'rviz_common/Views'},
    'Tools': {'rviz_default_plugins/Interact', 'rviz_default_plugins/MoveCamera'},
    'Views': {'rviz_default_plugins/Orbit', 'rviz_default_plugins/TopDownOrtho'},
}
RVIZ_MESSAGES = {
    'rviz_default_plugins/Map': 'OccupancyGrid',
    'rviz_default_plugins/MarkerArray': 'MarkerArray',
    'rviz_default_plugins/Path': 'Path',
}

# Lichtblick 1.28 (types `Config` of the panels in packages/suite-base/src/panels) and Foxglove
# (foxglove-sdk 0.30, foxglove.layouts), which reads the same names.
PANELS = {
    '3D': {'followTf', 'followMode', 'cameraState', 'scene', 'topics', 'transforms', 'layers'},
    'map': {'center', 'customTileUrl', 'disabledTopics', 'followTopic', 'layer', 'topicColors',
            'zoomLevel', 'maxNativeZoom'},
    'Plot': {'paths', 'showLegend', 'legendDisplay', 'xAxisVal', 'foxglovePanelTitle',
             'lichtblickPanelTitle'},
    'RosOut': {'searchTerms', 'minLogLevel', 'topicToRender', 'nameFilter'},
}  # fmt: skip
PLOT_PATH = {'value', 'enabled', 'timestampMethod', 'color', 'label', 'showLine', 'lineSize'}
CAMERA = {'distance', 'perspective', 'phi', 'target', 'targetOffset', 'targetOrientation',
          'thetaOffset', 'fovy', 'near', 'far'}  # fmt: skip
# Of a topic in the panel 3D, by its message: `BaseSettings` and the settings of each kind.
TOPIC_SETTINGS = {
    'OccupancyGrid': {'visible', 'frameLocked', 'minColor', 'maxColor', 'unknownColor',
                      'invalidColor', 'colorMode', 'alpha'},
    'MarkerArray': {'visible', 'color', 'showOutlines', 'selectedIdVariable', 'namespaces'},
    'Path': {'visible', 'type', 'axisScale', 'arrowScale', 'lineWidth', 'gradient'},
}  # fmt: skip


def spec_of(name):
    """Return the topic of this name, without its vehicle."""
    from rocsafe_ros.interfaces import topics

    vehicle, _, rest = name.lstrip('/').partition('/')
    wanted = {name, rest if vehicle.startswith('rav') else name.lstrip('/')}
    (spec,) = [spec for spec in topics.TOPICS if spec.name in wanted]
    return spec


def assert_fits(value, kind, where):
    """A value is of its kind: a type, one of a few words, a colour, or a table of such."""
    if kind == _COLOUR:
        numbers = [int(part) for part in value.split(';')]
        assert len(numbers) == 3, where
        assert all(0 <= number <= 255 for number in numbers), where
    elif isinstance(kind, tuple):
        assert value in kind, where
    elif isinstance(kind, dict):
        for key, part in value.items():
            assert key in kind, f'{where}: {key}'
            assert_fits(part, kind[key], f'{where}: {key}')
    else:
        assert isinstance(value, (int, float) if kind is float else kind), where


@pytest.fixture(scope='module')
def rviz():
    """The configuration of RViz."""
    return yaml.safe_load((VIEWS / 'rocsafe.rviz').read_text())


def panels():
    """Each panel of the layout for Foxglove: its kind and its settings."""
    layout = json.loads((VIEWS / 'rocsafe_layout.json').read_text())
    return [(name.split('!')[0], config) for name, config in layout['configById'].items()]


def test_rviz_knows_every_class_and_property(rviz):
    """What it does not know it would leave out, and nobody would see why."""
    for display in rviz['Visualization Manager']['Displays']:
        own = {key: value for key, value in display.items()
               if key not in ('Class', 'Name', 'Enabled')}  # fmt: skip
        assert_fits(own, RVIZ_DISPLAYS[display['Class']], display['Name'])
        # Plain lines have no width.
        assert 'Line Width' not in own or own['Line Style'] == 'Billboards'
    manager = rviz['Visualization Manager']
    assert {panel['Class'] for panel in rviz['Panels']} <= RVIZ_OTHERS['Panels']
    assert {tool['Class'] for tool in manager['Tools']} <= RVIZ_OTHERS['Tools']
    assert manager['Views']['Current']['Class'] in RVIZ_OTHERS['Views']


def test_rviz_hears_every_topic(rviz):
    """Of the message that its display draws; a reader asks for no more than is published."""
    from rclpy.qos import DurabilityPolicy

    shown = [one for one in rviz['Visualization Manager']['Displays'] if 'Topic' in one]
    assert len(shown) >= 10
    for display in shown:
        spec = spec_of(display['Topic']['Value'])
        assert spec.message_type.__name__ == RVIZ_MESSAGES[display['Class']]
        is_kept = spec.qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
        assert is_kept or display['Topic']['Durability Policy'] == 'Volatile'


def test_foxglove_knows_every_panel_and_setting():
    """Also of the topics, the camera and the series within."""
    found = panels()
    assert {kind for kind, _ in found} == PANELS.keys()
    for kind, config in found:
        assert config.keys() <= PANELS[kind], kind
        for path in config.get('paths', ()):
            assert path.keys() <= PLOT_PATH
        assert config.get('cameraState', {}).keys() <= CAMERA
        for name, settings in config.get('topics', {}).items():
            assert settings.keys() <= TOPIC_SETTINGS[spec_of(name).message_type.__name__], name


def test_foxglove_shows_every_panel_that_is_set_up():
    """And each one once."""
    layout = json.loads((VIEWS / 'rocsafe_layout.json').read_text())

    def leaves(node):
        return [node] if isinstance(node, str) else leaves(node['first']) + leaves(node['second'])

    assert sorted(leaves(layout['layout'])) == sorted(layout['configById'])
    # Lichtblick refuses a layout without these.
    assert {'configById', 'globalVariables'} <= layout.keys()
    assert isinstance(layout['playbackConfig']['speed'], int | float)


def test_foxglove_plots_fields_that_messages_have():
    """And follows a fix on its map, and shows the log."""
    configs = dict(panels())
    for path in configs['Plot']['paths']:
        topic, _, field = path['value'].partition('.')
        assert field in spec_of(topic).message_type.get_fields_and_field_types()
    for topic in (configs['map']['followTopic'], *configs['map']['topicColors']):
        assert spec_of(topic).message_type.__name__ == 'NavSatFix'
    assert spec_of(configs['RosOut']['topicToRender']).message_type.__name__ == 'Log'

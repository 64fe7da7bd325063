# SPDX-License-Identifier: Apache-2.0
"""Write the layouts of rocsafe_bringup for RViz and for Foxglove or Lichtblick.

    python tools/layouts.py

Names and types of topics come from the table of topics, so that a layout names none that is not
there. Vehicles are called rav1 to rav3, as in the derailment.
"""

import json
import sys
from pathlib import Path
from typing import Any

import yaml

from rocsafe_ros import topics

FOLDER = Path(__file__).resolve().parents[1] / 'src/rocsafe_bringup/view'
VEHICLES = ('rav1', 'rav2', 'rav3')
COLOURS = ('230; 159; 0', '86; 180; 233', '0; 158; 115')
GRIDS = (topics.DOSE_MAP, topics.PLUME)
MARKERS = (topics.CORDONS, topics.SCENE_MARKERS)
_LATCHED = {'Durability Policy': 'Transient Local', 'Reliability Policy': 'Reliable', 'Depth': 1}


def main() -> int:
    """Write both files."""
    FOLDER.mkdir(exist_ok=True)
    rviz, panels = yaml.safe_dump(rviz_layout(), sort_keys=False), panel_layout()
    (FOLDER / 'rocsafe.rviz').write_text(rviz)
    (FOLDER / 'rocsafe_layout.json').write_text(json.dumps(panels, indent=1) + '\n')
    return 0


def rviz_layout() -> dict[str, Any]:
    """Return a configuration of RViz: ground, cordons, routes, flown tracks, frames."""
    grids = [_display('Map', spec.name, {'Alpha': 0.6, 'Draw Behind': True}) for spec in GRIDS]
    markers = [_display('MarkerArray', spec.name, {}) for spec in MARKERS]
    vehicles = [
        display
        for name, colour in zip(VEHICLES, COLOURS, strict=True)
        for display in (
            _display('MarkerArray', f'{name}/{topics.ROUTE_MARKERS.name}', {}),
            _display('Path', f'{name}/{topics.PATH.name}', {'Color': colour, 'Line Width': 0.5}),
        )
    ]
    frames = {'Class': 'rviz_default_plugins/TF', 'Name': 'frames', 'Enabled': True,
              'Marker Scale': 20}  # fmt: skip
    return {
        'Panels': [{'Class': 'rviz_common/Displays', 'Name': 'Displays'}],
        'Visualization Manager': {
            'Displays': [*grids, *markers, *vehicles, frames],
            'Global Options': {'Fixed Frame': 'map', 'Background Color': '48; 48; 48'},
            'Tools': [{'Class': 'rviz_default_plugins/MoveCamera'}],
            'Views': {'Current': {'Class': 'rviz_default_plugins/Orbit', 'Distance': 300,
                                  'Pitch': 1.0, 'Yaw': 4.7}},
        },
    }  # fmt: skip


def _display(kind: str, topic: str, options: dict[str, Any]) -> dict[str, Any]:
    return {
        'Class': f'rviz_default_plugins/{kind}', 'Name': topic, 'Enabled': True,
        'Topic': {'Value': f'/{topic}', **_LATCHED}, **options,
    }  # fmt: skip


def panel_layout() -> dict[str, Any]:
    """Return a layout of Foxglove and Lichtblick: scene, map, dose rates and log."""
    shown = [spec.name for spec in (*GRIDS, *MARKERS)]
    shown += [f'{name}/{spec.name}' for name in VEHICLES
              for spec in (topics.ROUTE_MARKERS, topics.PATH)]  # fmt: skip
    fixes = [f'/{name}/{topics.FIX.name}' for name in VEHICLES]
    rates = [f'/{name}/{topics.RADIATION.name}.dose_rate_usvh' for name in VEHICLES]
    return {
        'configById': {
            '3D!scene': {'followTf': 'map', 'topics': {f'/{t}': {'visible': True} for t in shown}},
            'map!fixes': {'layer': 'map', 'topicColors': {}, 'zoomLevel': 17,
                          'disabledTopics': [], 'followTopic': fixes[0]},
            'Plot!dose': {
                'title': 'dose rate, uSv/h',
                'paths': [{'value': rate, 'enabled': True, 'timestampMethod': 'receiveTime'}
                          for rate in rates],
                'showLegend': True, 'xAxisVal': 'timestamp',
            },
            'RosOut!log': {'minLogLevel': 2},
        },
        'globalVariables': {}, 'userNodes': {}, 'playbackConfig': {'speed': 1},
        'layout': {
            'direction': 'row', 'splitPercentage': 62, 'first': '3D!scene',
            'second': {'direction': 'column', 'first': 'map!fixes', 'splitPercentage': 40,
                       'second': {'direction': 'column', 'first': 'Plot!dose',
                                  'second': 'RosOut!log', 'splitPercentage': 65}},
        },
    }  # fmt: skip


if __name__ == '__main__':
    sys.exit(main())

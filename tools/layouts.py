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

from rocsafe_ros.interfaces import topics

FOLDER = Path(__file__).resolve().parents[1] / 'src/rocsafe_bringup/view'
VEHICLES = ('rav1', 'rav2', 'rav3')
# Okabe and Ito's, which people with any colour vision tell apart: red, green, blue.
COLOURS = ((230, 159, 0), (86, 180, 233), (0, 158, 115))
TRACK_WIDTH_M = 0.5
VIEW_DISTANCE_M = 300
DOSE_TITLE = 'dose rate, uSv/h'
GRIDS = (topics.DOSE_MAP, topics.PLUME)
MARKERS = (topics.CORDONS, topics.THREAT_ZONES, topics.SCENE_MARKERS)
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
    look = {'Alpha': 0.6, 'Color Scheme': 'costmap', 'Draw Behind': True}
    grids = [_display('Map', spec.name, look) for spec in GRIDS]
    markers = [_display('MarkerArray', spec.name, {}) for spec in MARKERS]
    vehicles = [
        display
        for name, colour in zip(VEHICLES, COLOURS, strict=True)
        for display in (
            _display('MarkerArray', f'{name}/{topics.ROUTE_MARKERS.name}', {}),
            _display('Path', f'{name}/{topics.PATH.name}', _track('; '.join(map(str, colour)))),
        )
    ]
    frames = {'Class': 'rviz_default_plugins/TF', 'Name': 'frames', 'Enabled': True,
              'Marker Scale': 20}  # fmt: skip
    return {
        'Panels': [{'Class': f'rviz_common/{one}', 'Name': one} for one in ('Displays', 'Time')],
        'Visualization Manager': {
            'Displays': [*grids, *markers, *vehicles, frames],
            'Global Options': {'Fixed Frame': 'map', 'Background Color': '48; 48; 48'},
            'Tools': [{'Class': 'rviz_default_plugins/MoveCamera'}],
            'Views': {'Current': {'Class': 'rviz_default_plugins/Orbit',
                                  'Distance': VIEW_DISTANCE_M, 'Pitch': 1.0, 'Yaw': 4.7}},
        },
    }  # fmt: skip


def _track(colour: str) -> dict[str, Any]:
    # RViz draws its plain lines one pixel wide, whatever their width.
    return {'Color': colour, 'Line Style': 'Billboards', 'Line Width': TRACK_WIDTH_M}


def _display(kind: str, topic: str, options: dict[str, Any]) -> dict[str, Any]:
    return {
        'Class': f'rviz_default_plugins/{kind}', 'Name': topic, 'Enabled': True,
        'Topic': {'Value': f'/{topic}', **_LATCHED}, **options,
    }  # fmt: skip


def panel_layout() -> dict[str, Any]:
    """Return a layout of Foxglove and Lichtblick: scene, map, dose rates and log."""
    # Low and unknown values leave the ground visible.
    grid = {'visible': True, 'colorMode': 'custom', 'minColor': '#f0e44200',
            'maxColor': '#d55e00c0', 'unknownColor': '#00000000'}  # fmt: skip
    shown = {f'/{spec.name}': grid for spec in GRIDS}
    shown |= {f'/{spec.name}': {'visible': True} for spec in MARKERS}
    colours = {f'/{name}': '#{:02x}{:02x}{:02x}'.format(*colour)
               for name, colour in zip(VEHICLES, COLOURS, strict=True)}  # fmt: skip
    for name, colour in colours.items():
        shown[f'{name}/{topics.ROUTE_MARKERS.name}'] = {'visible': True}
        # Without a type, some versions draw three axes at each position.
        shown[f'{name}/{topics.PATH.name}'] = {
            'visible': True, 'type': 'line', 'lineWidth': TRACK_WIDTH_M,
            'gradient': [f'{colour}ff', f'{colour}ff'],
        }  # fmt: skip
    fixes = [f'/{name}/{topics.FIX.name}' for name in VEHICLES]
    rates = [f'/{name}/{topics.RADIATION.name}.dose_rate_usvh' for name in VEHICLES]
    return {
        'configById': {
            '3D!scene': {
                'followTf': 'map', 'topics': shown,
                # Its axes lie under the ground, and a line leads there from each frame above.
                'transforms': {'frame:earth': {'visible': False}},
                'cameraState': {'distance': VIEW_DISTANCE_M, 'phi': 35, 'thetaOffset': 0},
            },
            'map!fixes': {'layer': 'map', 'zoomLevel': 16,
                          'topicColors': dict(zip(fixes, colours.values(), strict=True)),
                          'disabledTopics': [], 'followTopic': fixes[0]},
            'Plot!dose': {
                # One key of each program; a key that it does not know, it leaves alone.
                'foxglovePanelTitle': DOSE_TITLE, 'lichtblickPanelTitle': DOSE_TITLE,
                'paths': [{'value': rate, 'label': name, 'color': colours[f'/{name}'],
                           'enabled': True, 'timestampMethod': 'receiveTime'}
                          for rate, name in zip(rates, VEHICLES, strict=True)],
                # A floating legend lies over the curves.
                'showLegend': True, 'legendDisplay': 'top', 'xAxisVal': 'timestamp',
            },
            'RosOut!log': {'minLogLevel': 2, 'searchTerms': [], 'topicToRender': '/rosout'},
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

# SPDX-License-Identifier: Apache-2.0
"""Reference pages of what a user calls from Python, made from the docstrings."""

# Page: title, introduction, modules in the order of the page.
_PAGES = {
    'planning': (
        'Planning', 'From a region to checked routes, without ROS.',
        ('rocsafe_planner.region_plan', 'rocsafe_planner.plan.request',
         'rocsafe_planner.plan.survey_options', 'rocsafe_planner.plan.vehicle',
         'rocsafe_planner.plan.plan', 'rocsafe_planner.replanning'),
    ),
    'radiation': (
        'Radiation', 'The field of gamma sources, and sources from readings.',
        ('rocsafe_radiation.physics.source', 'rocsafe_radiation.physics.field',
         'rocsafe_radiation.readings.readings_file', 'rocsafe_radiation.readings.survey',
         'rocsafe_radiation.localization.localize'),
    ),
    'dispersion': (
        'Dispersion', 'Releases of gas and particles, and releases from readings.',
        ('rocsafe_dispersion.plume.release', 'rocsafe_dispersion.plume.steady_plume',
         'rocsafe_dispersion.plume.puffs', 'rocsafe_dispersion.estimation.gas_csv',
         'rocsafe_dispersion.estimation.locate', 'rocsafe_dispersion.estimation.release_options'),
    ),
    'ground': (
        'Ground vehicle', 'Drives over the map of a run, within a budget of dose.',
        ('rocsafe_ground.drive.ground_map', 'rocsafe_ground.drive.drive_plan',
         'rocsafe_ground.drive.planning', 'rocsafe_ground.evidence.evidence_point',
         'rocsafe_ground.drivable.vehicle'),
    ),
    'mapping': (
        'Mapping', 'The function behind the command `rocsafe map`, and settings of the map.',
        ('rocsafe_mapping.command_line.map_command', 'rocsafe_mapping.alignment_options',
         'rocsafe_mapping.drawing_options'),
    ),
    'scene': (
        'Scenes', 'The description of a virtual place.',
        ('rocsafe_scene.scene.scene_file',),
    ),
    'geography': (
        'Geography', 'Positions, frames and areas, which all packages share.',
        ('rocsafe_geo.position', 'rocsafe_geo.frame', 'rocsafe_geo.regions.area',
         'rocsafe_geo.regions.area_files', 'rocsafe_geo.pinhole'),
    ),
}  # fmt: skip


def python_pages() -> dict[str, str]:
    """Return the pages by their paths in the site."""
    return {
        f'reference/python/{name}.md': _page(title, text, modules)
        for name, (title, text, modules) in _PAGES.items()
    }


def _page(title: str, text: str, modules: tuple[str, ...]) -> str:
    blocks = ''.join(f'\n::: {module}\n' for module in modules)
    return f'# {title}\n\n{text}\n{blocks}'

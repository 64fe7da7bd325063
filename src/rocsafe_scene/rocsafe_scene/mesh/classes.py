# SPDX-License-Identifier: Apache-2.0
"""The classes of the labels: number, name and colour."""

from dataclasses import dataclass

from rocsafe_scene.mesh.mesh import Colour


@dataclass(frozen=True, slots=True)
class LabelClass:
    """One class; `colour` is red, green, blue in pictures of labels."""

    number: int
    name: str
    colour: Colour


_TABLE = (
    ('sky', (135, 190, 235)), ('grass', (86, 152, 60)), ('meadow', (140, 188, 92)),
    ('soil', (150, 106, 66)), ('gravel', (196, 178, 140)), ('ballast', (128, 122, 116)),
    ('asphalt', (84, 84, 92)), ('water', (40, 96, 160)), ('spill', (128, 24, 128)),
    ('scorch', (50, 36, 30)), ('rail', (188, 188, 200)), ('sleeper', (112, 84, 58)),
    ('tree', (24, 110, 36)), ('hedge', (60, 136, 66)), ('shrub', (104, 158, 40)),
    ('house', (214, 150, 112)), ('tent', (96, 140, 222)), ('fence', (170, 140, 104)),
    ('locomotive', (252, 140, 20)), ('tank_car', (222, 226, 230)), ('box_car', (176, 72, 44)),
    ('flat_car', (140, 96, 70)), ('flask', (255, 214, 0)), ('car', (92, 92, 220)),
    ('police_car', (30, 60, 200)), ('lorry', (60, 120, 180)), ('fire_engine', (220, 20, 30)),
    ('ambulance', (240, 240, 90)), ('road_tanker', (200, 210, 160)), ('person', (255, 90, 160)),
    ('animal', (240, 220, 200)), ('debris', (160, 90, 200)), ('drum', (20, 170, 190)),
    ('evidence', (255, 255, 0)), ('cordon', (255, 60, 60)), ('marker', (255, 120, 0)),
    ('other', (200, 200, 200)), ('wall', (180, 180, 160)), ('concrete', (190, 190, 186)),
)  # fmt: skip

CLASSES: dict[str, LabelClass] = {
    name: LabelClass(number, name, colour) for number, (name, colour) in enumerate(_TABLE)
}


def class_number(name: str) -> int:
    """Return the number of the class called `name`.

    Raises
    ------
    ValueError
        If there is none.
    """
    if name not in CLASSES:
        raise ValueError(f'class is {name!r}: must be one of {", ".join(CLASSES)}')
    return CLASSES[name].number

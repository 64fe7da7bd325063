# SPDX-License-Identifier: Apache-2.0
"""The scenes by name."""

from collections.abc import Callable, Mapping

from rocsafe_scene.scenery.derailment import derailment_scene
from rocsafe_scene.scenery.meadowland import field_scene
from rocsafe_scene.scenery.scene import Scene


def bare_scene(seed: int) -> Scene:  # noqa: ARG001 - all scenes are made alike
    """Return a meadow with nothing on it."""
    return Scene(())


SCENES: Mapping[str, Callable[[int], Scene]] = {
    'derailment': derailment_scene,
    'field': field_scene,
    'none': bare_scene,
}


def make_scene(name: str, seed: int) -> Scene:
    """Return the scene called `name`.

    Raises
    ------
    ValueError: if there is none.
    """
    if name not in SCENES:
        raise ValueError(f'scene is {name!r}: must be one of {", ".join(SCENES)}')
    return SCENES[name](seed)

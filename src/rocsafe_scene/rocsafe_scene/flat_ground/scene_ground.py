# SPDX-License-Identifier: Apache-2.0
"""The level ground of a scene: its photograph, with meadow around it."""

from rocsafe_scene.flat_ground.ground_photograph import GroundPhotograph
from rocsafe_scene.flat_ground.meadow import Meadow
from rocsafe_scene.ground.ground_patch import GroundBounds, Patch


class SceneGround:
    """Shows a photograph about the mission origin, and meadow where that ends.

    Parameters
    ----------
    photograph
        Of the scene; None for meadow everywhere.
    seed
        Of the meadow.
    """

    def __init__(self, photograph: GroundPhotograph | None, seed: int) -> None:
        self._photograph = photograph
        self._meadow = Meadow(seed)

    def patch(self, bounds: GroundBounds, resolution_m: float) -> Patch:
        """Return a picture of all of `bounds` with texels of about `resolution_m` or less.

        Raises
        ------
        GroundError
            If it would be larger than any camera needs.
        """
        photograph = self._photograph
        if photograph is None:
            return self._meadow.patch(bounds, resolution_m)
        if photograph.covers(bounds):
            return photograph.patch(bounds, resolution_m)
        return photograph.laid_over(self._meadow.patch(bounds, resolution_m), resolution_m)

# SPDX-License-Identifier: Apache-2.0
"""Lines and points of the mission's frame, drawn into an image; what is nearer hides them."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.mesh.lines import resampled
from rocsafe_scene.mesh.mesh import Floats

# Palette of Okabe and Ito (2008), safe for colour-blind readers; blue, green, red.
COLOURS = ((0, 159, 230), (233, 180, 86), (66, 228, 240), (167, 121, 204), (0, 94, 213))
WHITE = (255, 255, 255)
Colour = tuple[int, int, int]
_STEP_M, _SLACK_M = 1.5, 0.6
# Points nearer to the camera than this, metres, are not drawn.
_NEAR_M = 1.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Overlay:
    """Draws into an image.

    Attributes
    ----------
    image : (rows, columns, 3)
        Blue, green, red; drawn over.
    depth_m : (rows, columns)
        Depth of what is seen.
    lens
        Of the camera.
    pose
        Position of the camera, (3,), and its rotation, columns right, down, ahead, (3, 3).
    """

    image: NDArray[np.uint8]
    depth_m: Floats
    lens: PinholeCamera
    pose: tuple[Floats, Floats]

    def line(self, places: Floats, colour: Colour, width_px: int) -> None:
        """Draw the line over `places`, (n, 3)."""
        if len(places) < 2:
            return
        spots = self.project(resampled(places, _STEP_M))
        is_seen = self.is_seen(spots)
        for start in np.flatnonzero(is_seen[:-1] & is_seen[1:]):
            ends = np.rint(16.0 * spots[start : start + 2, :2]).astype(int).tolist()
            cv2.line(self.image, ends[0], ends[1], colour, width_px, cv2.LINE_AA, 4)

    def dots(self, places: Floats, colour: Colour, radius_px: int) -> None:
        """Draw a dot with a white edge at each of `places`, (n, 3)."""
        spots = self.project(places)
        for u, v, _ in spots[self.is_seen(spots)].tolist():
            cv2.circle(self.image, (round(u), round(v)), radius_px, colour, -1, cv2.LINE_AA)
            cv2.circle(self.image, (round(u), round(v)), radius_px, WHITE, 1, cv2.LINE_AA)

    def text(self, place: Floats, text: str, colour: Colour) -> None:
        """Write beside a place, (3,), unless it is out of the image or hidden."""
        spots = self.project(place[None])
        if self.is_seen(spots)[0]:
            spot = (round(spots[0, 0]) + 8, round(spots[0, 1]) - 8)
            for ink, width in (((0, 0, 0), 3), (colour, 1)):
                cv2.putText(
                    self.image, text, spot, cv2.FONT_HERSHEY_SIMPLEX, 0.5, ink, width, cv2.LINE_AA
                )

    def project(self, places: Floats) -> Floats:
        """Return column, row and depth of `places` (n, 3), (n, 3)."""
        position, rotation = self.pose
        optical = (places - position) @ rotation
        depth = optical[:, 2]
        pixels = optical @ self.lens.matrix.T
        safe = np.where(depth > _NEAR_M, depth, np.inf)
        return np.column_stack([pixels[:, 0] / safe, pixels[:, 1] / safe, depth])

    def is_seen(self, spots: Floats) -> BoolArray:
        """Return which projected points are in the image, and hidden by nothing."""
        rows, columns = self.depth_m.shape
        u, v, depth = spots.T
        found = (depth > _NEAR_M) & (u >= 0.0) & (u < columns - 0.5) & (v >= 0.0)
        found &= v < rows - 0.5
        row, column = (np.rint(np.where(found, one, 0.0)).astype(int) for one in (v, u))
        return np.asarray(found & (depth < self.depth_m[row, column] + _SLACK_M))

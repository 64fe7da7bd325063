# SPDX-License-Identifier: Apache-2.0
"""Which picture belongs to which shot, though the clocks of camera and autopilot differ.

Both come in order. While the difference of the clocks is small, or once it is known, a picture
belongs to the shot nearest in time. Before, the difference is looked for at which most of what
waits agrees: the uneven times between shots tell. Pictures without a shot and shots without a
picture stay alone.
"""

from dataclasses import dataclass

from rocsafe_mavlink.camera.camera_trigger import CameraTrigger
from rocsafe_mavlink.camera.source import CameraImage

# Half of the shortest time between two shots.
TOLERANCE_S = 0.5
# Clocks that differ by less are taken to be set by the same source.
SET_ALIKE_S = 1.0
FEWEST_AGREEING = 3
# The difference of two clocks wanders; each pair moves what is believed of it by this share.
DRIFT_SHARE = 0.2
LARGEST_WAITING = 500
LOOKED_AT = 20


@dataclass(frozen=True, slots=True)
class ImagePair:
    """A picture and its shot."""

    shot: CameraTrigger
    picture: CameraImage


class ImagePairing:
    """Pairs what comes of one camera with what its autopilot reports."""

    def __init__(self) -> None:
        self._shots: list[CameraTrigger] = []
        self._pictures: list[CameraImage] = []
        self._offset_s: float | None = None

    @property
    def offset_s(self) -> float | None:
        """Clock of the camera less that of the autopilot; None while it is not known."""
        return self._offset_s

    def add(self, shots: list[CameraTrigger], pictures: list[CameraImage]) -> list[ImagePair]:
        """Take what has come; return the pairs that are sure now, in order of time."""
        self._shots = [*self._shots, *shots][-LARGEST_WAITING:]
        self._pictures = [*self._pictures, *pictures][-LARGEST_WAITING:]
        if self._offset_s is None:
            self._offset_s = self._found_offset()
        return [] if self._offset_s is None else self._paired()

    def _found_offset(self) -> float | None:
        """Return the difference at which most agrees, the smallest of those."""
        shots, pictures = self._shots[:LOOKED_AT], self._pictures[:LOOKED_AT]
        candidates = [picture.unix_s - shot.unix_s for picture in pictures for shot in shots]
        if not candidates:
            return None
        best = max(candidates, key=lambda offset_s: (self._agreeing(offset_s), -abs(offset_s)))
        is_sure = self._agreeing(best) >= FEWEST_AGREEING or abs(best) < SET_ALIKE_S
        return best if is_sure else None

    def _agreeing(self, offset_s: float) -> int:
        shots = self._shots[:LOOKED_AT]
        return sum(
            any(abs(picture.unix_s - offset_s - shot.unix_s) < 0.2 * TOLERANCE_S for shot in shots)
            for picture in self._pictures[:LOOKED_AT]
        )

    def _paired(self) -> list[ImagePair]:
        pairs = []
        for picture in list(self._pictures):
            pair = self._nearest(picture)
            if pair is not None:
                self._shots.remove(pair.shot)
                self._pictures.remove(picture)
                pairs.append(pair)
        return sorted(pairs, key=lambda pair: pair.shot.unix_s)

    def _nearest(self, picture: CameraImage) -> ImagePair | None:
        offset_s = self._offset_s or 0.0
        taken_s = picture.unix_s - offset_s
        shot = min(self._shots, key=lambda shot: abs(shot.unix_s - taken_s), default=None)
        if shot is None or abs(shot.unix_s - taken_s) > TOLERANCE_S:
            return None
        self._offset_s = offset_s + DRIFT_SHARE * (taken_s - shot.unix_s)
        return ImagePair(shot, picture)

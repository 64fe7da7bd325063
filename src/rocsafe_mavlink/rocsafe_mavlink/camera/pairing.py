# SPDX-License-Identifier: Apache-2.0
"""Which image belongs to which trigger, though the clocks of camera and autopilot differ.

Both come in order. Where the clocks agree, or their difference is known, an image belongs to the
trigger nearest in time. Before, the difference is searched with which most images and triggers
agree: the uneven times between triggers make it unique. Images without a trigger and triggers
without an image stay unpaired.
"""

from dataclasses import dataclass

from rocsafe_mavlink.camera.camera_trigger import CameraTrigger
from rocsafe_mavlink.camera.source import CameraImage

# Half of the shortest time between two triggers.
TOLERANCE_S = 0.5
# Clocks that differ by less are assumed to be set by the same source.
SET_ALIKE_S = 1.0
FEWEST_AGREEING = 3
# The difference of two clocks drifts; each pair moves its estimate by this share.
DRIFT_SHARE = 0.2
LARGEST_WAITING = 500
LOOKED_AT = 20


@dataclass(frozen=True, slots=True)
class ImagePair:
    """A trigger and its image."""

    trigger: CameraTrigger
    image: CameraImage


class ImagePairing:
    """Pairs the images of one camera with the triggers of its autopilot."""

    def __init__(self) -> None:
        self._triggers: list[CameraTrigger] = []
        self._images: list[CameraImage] = []
        self._offset_s: float | None = None

    @property
    def offset_s(self) -> float | None:
        """Clock of the camera less that of the autopilot; None while it is not known."""
        return self._offset_s

    def add(self, triggers: list[CameraTrigger], images: list[CameraImage]) -> list[ImagePair]:
        """Take new triggers and images; return the pairs that are certain now, by time."""
        self._triggers = [*self._triggers, *triggers][-LARGEST_WAITING:]
        self._images = [*self._images, *images][-LARGEST_WAITING:]
        if self._offset_s is None:
            self._offset_s = self._found_offset()
        return [] if self._offset_s is None else self._paired()

    def _found_offset(self) -> float | None:
        """Return the difference at which most agrees, the smallest of those."""
        triggers, images = self._triggers[:LOOKED_AT], self._images[:LOOKED_AT]
        candidates = [image.unix_s - trigger.unix_s for image in images for trigger in triggers]
        if not candidates:
            return None
        best = max(candidates, key=lambda offset_s: (self._agreeing(offset_s), -abs(offset_s)))
        is_sure = self._agreeing(best) >= FEWEST_AGREEING or abs(best) < SET_ALIKE_S
        return best if is_sure else None

    def _agreeing(self, offset_s: float) -> int:
        triggers = self._triggers[:LOOKED_AT]
        return sum(
            any(
                abs(image.unix_s - offset_s - trigger.unix_s) < 0.2 * TOLERANCE_S
                for trigger in triggers
            )
            for image in self._images[:LOOKED_AT]
        )

    def _paired(self) -> list[ImagePair]:
        pairs = []
        for image in list(self._images):
            pair = self._nearest(image)
            if pair is not None:
                self._triggers.remove(pair.trigger)
                self._images.remove(image)
                pairs.append(pair)
        return sorted(pairs, key=lambda pair: pair.trigger.unix_s)

    def _nearest(self, image: CameraImage) -> ImagePair | None:
        offset_s = self._offset_s or 0.0
        taken_s = image.unix_s - offset_s
        trigger = min(
            self._triggers, key=lambda trigger: abs(trigger.unix_s - taken_s), default=None
        )
        if trigger is None or abs(trigger.unix_s - taken_s) > TOLERANCE_S:
            return None
        self._offset_s = offset_s + DRIFT_SHARE * (taken_s - trigger.unix_s)
        return ImagePair(trigger, image)

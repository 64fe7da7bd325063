# SPDX-License-Identifier: Apache-2.0
"""Pairing of images with triggers although the clocks of camera and autopilot differ.

Both come in order. Where the clocks agree, or their difference is known, an image belongs to the
trigger nearest in time. Before, the difference is searched with which most images and triggers
agree: the uneven times between triggers make it unique. Images without a trigger and triggers
without an image stay unpaired.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from rocsafe_mavlink.camera.camera_trigger import CameraTrigger
from rocsafe_mavlink.camera.source import CameraImage


@dataclass(frozen=True, slots=True, kw_only=True)
class PairingOptions:
    """Options of the pairing of images and triggers.

    Attributes
    ----------
    tolerance_s
        Largest distance in time of a pair, seconds: half of the shortest time between triggers.
    agreement_s
        Largest distance of pairs while the difference of the clocks is searched, seconds.
    set_alike_s
        Clocks that differ by less are assumed to be set by the same source, seconds.
    fewest_agreeing
        Pairs that must agree for a larger difference of the clocks.
    searched_count
        Images and triggers among which the difference is searched.
    drift_share
        Share by which each pair moves the estimate of the difference, which drifts.
    largest_waiting
        Images, and triggers, that are kept unpaired.
    """

    tolerance_s: float = 0.5
    agreement_s: float = 0.1
    set_alike_s: float = 1.0
    fewest_agreeing: int = 3
    searched_count: int = 20
    drift_share: float = 0.2
    largest_waiting: int = 500


PAIRING = PairingOptions()


@dataclass(frozen=True, slots=True)
class ImagePair:
    """A trigger and its image; `guessed` is the one in the table for which it stands, if any."""

    trigger: CameraTrigger
    image: CameraImage
    guessed: CameraTrigger | None = None


class ImagePairing:
    """Pairs the images of one camera with the triggers of its autopilot.

    Parameters
    ----------
    triggers
        Triggers without an image, of an earlier process.
    offset_s
        Clock of the camera less that of the autopilot, as it found; None: not known.
    """

    def __init__(
        self,
        triggers: Iterable[CameraTrigger] = (),
        offset_s: float | None = None,
    ) -> None:
        self._triggers = [*triggers][-PAIRING.largest_waiting :]
        self._images: list[CameraImage] = []
        self._offset_s = offset_s

    @property
    def offset_s(self) -> float | None:
        """Clock of the camera less that of the autopilot; None while it is not known."""
        return self._offset_s

    @property
    def triggers(self) -> tuple[CameraTrigger, ...]:
        """Triggers without an image."""
        return tuple(self._triggers)

    @property
    def images(self) -> tuple[CameraImage, ...]:
        """Images without a trigger."""
        return tuple(self._images)

    def settle(self, image: CameraImage) -> CameraTrigger | None:
        """Take out an image that gets its place otherwise, and the trigger that it stands for.

        That is the next one that was filled in between two reports; None: there is none.
        """
        self._images.remove(image)
        taken_s = image.unix_s - (self._offset_s or 0.0)
        guessed = [trigger for trigger in self._triggers if trigger.is_interpolated]
        if not guessed:
            return None
        nearest = min(guessed, key=lambda trigger: abs(trigger.unix_s - taken_s))
        self._triggers.remove(nearest)
        return nearest

    def add(self, triggers: list[CameraTrigger], images: list[CameraImage]) -> list[ImagePair]:
        """Take new triggers and images; return the pairs that are certain now, by time."""
        self._triggers = [*self._triggers, *triggers][-PAIRING.largest_waiting :]
        self._images = [*self._images, *images][-PAIRING.largest_waiting :]
        if self._offset_s is None:
            self._offset_s = self._found_offset()
        return [] if self._offset_s is None else self._paired()

    def _found_offset(self) -> float | None:
        """Return the difference of the clocks with which most agree, the smallest of these."""
        triggers = [trigger.unix_s for trigger in self._triggers[: PAIRING.searched_count]]
        images = [image.unix_s for image in self._images[: PAIRING.searched_count]]
        candidates = [image_s - trigger_s for image_s in images for trigger_s in triggers]
        if not candidates:
            return None

        def agreeing(offset_s: float) -> int:
            return sum(
                any(abs(image_s - offset_s - s) < PAIRING.agreement_s for s in triggers)
                for image_s in images
            )

        best_s = max(candidates, key=lambda offset_s: (agreeing(offset_s), -abs(offset_s)))
        is_sure = agreeing(best_s) >= PAIRING.fewest_agreeing or abs(best_s) < PAIRING.set_alike_s
        return best_s if is_sure else None

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
        if trigger is None or abs(trigger.unix_s - taken_s) > PAIRING.tolerance_s:
            return None
        if not trigger.is_interpolated:
            self._offset_s = offset_s + PAIRING.drift_share * (taken_s - trigger.unix_s)
        return ImagePair(trigger, image)

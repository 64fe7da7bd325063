# SPDX-License-Identifier: Apache-2.0
"""Pairing of images with triggers although the clocks of camera and autopilot differ.

Both come in order. Where the clocks agree, or their difference is known, an image belongs to the
trigger nearest in time. Before, the difference is searched with which most images and triggers
agree: the uneven times between triggers make it unique. A camera may also go by the clock of this
machine where the autopilot's differs: its images are compared with the times at which the triggers
were reported, too. Images without a trigger and triggers without an image stay unpaired.
"""

import math
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
    fewest_more
        By how many more agree with it than with any other difference: of evenly spaced triggers
        one fewer agrees one trigger further on, and as many where one of each was lost.
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
    fewest_more: int = 2
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
        # Clock of the camera less ours, where it is set as ours is.
        self._from_ours_s: float | None = None

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
            times = [trigger.unix_s for trigger in self._triggers]
            self._offset_s = self._found_offset(times, PAIRING.agreement_s)
        if self._offset_s is None:
            reported = [trigger.reported_s for trigger in self._reported]
            found_s = self._found_offset(reported, PAIRING.tolerance_s)
            self._take_from_ours(math.inf if found_s is None else found_s)
        is_known = self._offset_s is not None or self._from_ours_s is not None
        return self._paired() if is_known else []

    @property
    def _reported(self) -> list[CameraTrigger]:
        """Triggers of which it is known when they were reported."""
        return [trigger for trigger in self._triggers if not math.isnan(trigger.reported_s)]

    def _take_from_ours(self, offset_s: float) -> None:
        self._from_ours_s = offset_s if abs(offset_s) < PAIRING.set_alike_s else None

    def _found_offset(self, times_s: list[float], agreement_s: float) -> float | None:
        """Return the difference to a clock of triggers with which most agree, the smallest."""
        triggers = times_s[: PAIRING.searched_count]
        images = [image.unix_s for image in self._images[: PAIRING.searched_count]]
        candidates = [image_s - trigger_s for image_s in images for trigger_s in triggers]
        if not candidates:
            return None

        def agreeing(offset_s: float) -> int:
            return sum(
                any(abs(image_s - offset_s - s) < agreement_s for s in triggers)
                for image_s in images
            )

        best_s = max(candidates, key=lambda offset_s: (agreeing(offset_s), -abs(offset_s)))
        if abs(best_s) < PAIRING.set_alike_s:
            return best_s
        # Even times between triggers agree one trigger further, too.
        others = [s for s in candidates if abs(s - best_s) > 2.0 * PAIRING.tolerance_s]
        rival = max(map(agreeing, others), default=0)
        count = agreeing(best_s)
        return (
            best_s
            if count >= PAIRING.fewest_agreeing and count - rival >= PAIRING.fewest_more
            else None
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
        return self._by_autopilot(image) or self._by_ours(image)

    def _by_autopilot(self, image: CameraImage) -> ImagePair | None:
        """Pair by the clock of the autopilot, and follow what the other clocks differ by."""
        if self._offset_s is None:
            return None
        taken_s = image.unix_s - self._offset_s
        trigger = _nearest({one.unix_s: one for one in reversed(self._triggers)}, taken_s)
        if trigger is None:
            return None
        if not trigger.is_interpolated:
            self._offset_s += PAIRING.drift_share * (taken_s - trigger.unix_s)
        if not math.isnan(trigger.reported_s):
            self._take_from_ours(image.unix_s - trigger.reported_s)
        return ImagePair(trigger, image)

    def _by_ours(self, image: CameraImage) -> ImagePair | None:
        """Pair by the times of reports: the clock of the autopilot may not go as ours does."""
        if self._from_ours_s is None:
            return None
        times = {one.reported_s: one for one in reversed(self._reported)}
        trigger = _nearest(times, image.unix_s - self._from_ours_s)
        return None if trigger is None else ImagePair(trigger, image)


def _nearest(triggers: dict[float, CameraTrigger], taken_s: float) -> CameraTrigger | None:
    """Return the trigger nearest to a time by one clock, if it is near enough for a pair."""
    at_s = min(triggers, key=lambda at_s: abs(at_s - taken_s), default=math.inf)
    return triggers[at_s] if abs(at_s - taken_s) <= PAIRING.tolerance_s else None

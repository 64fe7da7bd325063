# SPDX-License-Identifier: Apache-2.0
"""The unknowns of the adjustment: which column of the equations belongs to what."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.projection import LENS_SIZE, POSE_SIZE
from rocsafe_mapping.alignment.adjustment.rotation import turned
from rocsafe_mapping.alignment.adjustment.ties import Index
from rocsafe_mapping.alignment.model.photo import Photo, Pose
from rocsafe_mapping.alignment.model.state import Lens, State
from rocsafe_mapping.alignment_options import AdjustmentOptions

MARK_SIZE = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknowns:
    """Which column of the equations belongs to what.

    Attributes
    ----------
    names
        Photographs whose pose is unknown, six columns each.
    lenses
        Lenses to be found, three columns each, after the poses; with the uncertainty of each focal
        length over itself.
    lifts
        Vehicles whose lift is to be found, one column each, after the lenses; with its uncertainty
        in metres.
    marks
        Number of surveyed marks, two columns each, at the end.
    """

    names: tuple[str, ...]
    lenses: tuple[tuple[str, float], ...]
    lifts: tuple[tuple[str, float], ...] = ()
    marks: int = 0

    @staticmethod
    def of(
        photos: Mapping[str, Photo],
        names: tuple[str, ...],
        marks: int,
        options: AdjustmentOptions,
        *,
        with_shared: bool = True,
    ) -> 'Unknowns':
        """Return the unknowns of some photographs and of a number of marks.

        `with_shared`: also lenses and lifts, which photographs share.
        """
        if not with_shared:
            return Unknowns(names=names, lenses=(), marks=marks)
        stds = {photos[name].lens: photos[name].focal_std_share for name in names}
        heights: dict[str, list[float]] = {}
        for name in names:
            heights.setdefault(photos[name].vehicle, []).append(photos[name].prior.centre[2])
        return Unknowns(
            names=names,
            lenses=tuple((lens, std) for lens, std in sorted(stds.items()) if std > 0.0),
            lifts=tuple(
                (vehicle, options.lift_share * float(np.median(told)))
                for vehicle, told in sorted(heights.items())
            ),
            marks=marks,
        )

    def __len__(self) -> int:
        return self._first_mark + MARK_SIZE * self.marks

    @property
    def _first_lift(self) -> int:
        return POSE_SIZE * len(self.names) + LENS_SIZE * len(self.lenses)

    @property
    def _first_mark(self) -> int:
        return self._first_lift + len(self.lifts)

    def pose_columns(self, names: Sequence[str]) -> Index:
        """Return the first column of each name, -1 where its pose is known."""
        column = {name: POSE_SIZE * number for number, name in enumerate(self.names)}
        return np.array([column.get(name, -1) for name in names], np.int64)

    def lens_columns(self, lenses: Sequence[str]) -> Index:
        """Return the first column of each lens, -1 where it is known."""
        start = POSE_SIZE * len(self.names)
        column = {lens: start + LENS_SIZE * at for at, (lens, _) in enumerate(self.lenses)}
        return np.array([column.get(lens, -1) for lens in lenses], np.int64)

    def lift_columns(self, vehicles: Sequence[str]) -> Index:
        """Return the column of each vehicle's lift, -1 where it is known."""
        column = {name: self._first_lift + at for at, (name, _) in enumerate(self.lifts)}
        return np.array([column.get(vehicle, -1) for vehicle in vehicles], np.int64)

    def mark_columns(self) -> Index:
        """Return the first column of each mark."""
        return self._first_mark + MARK_SIZE * np.arange(self.marks, dtype=np.int64)

    def moved(self, state: State, step: FloatArray) -> State:
        """Return `state` changed by `step`."""
        poses, lenses = dict(state.poses), dict(state.lenses)
        for number, name in enumerate(self.names):
            change = step[POSE_SIZE * number : POSE_SIZE * (number + 1)]
            pose = poses[name]
            poses[name] = Pose(
                centre=pose.centre + change[:3], rotation=turned(change[3:]) @ pose.rotation
            )
        start = POSE_SIZE * len(self.names)
        for number, (name, _) in enumerate(self.lenses):
            change = step[start + LENS_SIZE * number : start + LENS_SIZE * (number + 1)]
            lens = lenses.get(name, Lens())
            lenses[name] = Lens(
                log_focal=lens.log_focal + change[0],
                k1=lens.k1 + change[1],
                k2=lens.k2 + change[2],
            )
        lifts = dict(state.lifts_m)
        for number, (vehicle, _) in enumerate(self.lifts):
            lifts[vehicle] = lifts.get(vehicle, 0.0) + float(step[self._first_lift + number])
        places = step[self._first_mark :].reshape(-1, MARK_SIZE)
        marks = tuple(mark.moved(place) for mark, place in zip(state.marks, places, strict=True))
        return replace(state, poses=poses, lenses=lenses, lifts_m=lifts, marks=marks)

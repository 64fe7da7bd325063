# SPDX-License-Identifier: Apache-2.0
"""All features of the photographs of a map and all pairs that were found among them."""

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence

import numpy as np
from scipy.spatial import cKDTree

from rocsafe_mapping.alignment.matching.features import (
    Features,
    Gray,
    orb_features,
    sift_features,
)
from rocsafe_mapping.alignment.matching.neighbours import Neighbourhood
from rocsafe_mapping.alignment.matching.pair_matching import Pair, View, match, most_alike
from rocsafe_mapping.alignment.model.photo import Photo
from rocsafe_mapping.alignment_options import AlignmentOptions

ReadGray = Callable[[str], Gray]
Key = tuple[str, str]


class PairTable:
    """Features and pairs; grows with the photographs.

    Parameters
    ----------
    read_gray
        Returns the grey picture of a photograph by name.
    options
        Of the alignment.
    """

    def __init__(self, read_gray: ReadGray, options: AlignmentOptions) -> None:
        self.read_gray = read_gray
        self._options = options
        self._photos: dict[str, Photo] = {}
        self._features: dict[str, Features] = {}
        self._sift: dict[str, Features] = {}
        self._neighbours = Neighbourhood(options.neighbours)
        self._pairs: dict[Key, Pair | None] = {}
        self._sift_tried: set[Key] = set()

    @property
    def found(self) -> Mapping[Key, Pair]:
        """Pairs found so far, in order of their names."""
        return {key: pair for key, pair in sorted(self._pairs.items()) if pair is not None}

    def add(self, photo: Photo) -> None:
        """Take in a photograph."""
        self._photos[photo.name] = photo
        if photo.is_located:
            self._neighbours.add(photo)

    def remove(self, name: str) -> None:
        """Forget a photograph and its pairs."""
        self._leave(name)
        self._pairs = {key: pair for key, pair in self._pairs.items() if name not in key}

    def replace(self, photo: Photo) -> None:
        """Take over a new prior of a photograph; failed pairs of it will be tried again."""
        self._leave(photo.name)
        self.add(photo)
        lost = [key for key, pair in self._pairs.items() if pair is None and photo.name in key]
        for key in lost:
            del self._pairs[key]

    def _leave(self, name: str) -> None:
        if self._photos.pop(name).is_located:
            self._neighbours.remove(name)

    def without_features(self) -> tuple[str, ...]:
        """Return the names of the photographs whose features are not known yet."""
        return tuple(sorted(set(self._photos) - set(self._features)))

    def extract(self, name: str) -> None:
        """Find the features of a photograph. Raises what reading it raises."""
        self._features[name] = orb_features(self.read_gray(name), self._options.features)

    def match_new(self, name: str) -> int:
        """Match a photograph with its neighbours that have features; return with how many."""
        if name not in self._features:
            self.extract(name)
        others = [other for other in self._neighbours.of(name) if other in self._features]
        return sum(self._match(*sorted((name, other))) is not None for other in others)

    def match_nearest(self) -> None:
        """Match each photograph with those of the nearest fixes, whatever its footprint.

        One without a fix is matched with those that look most like it.
        """
        known = sorted(name for name, photo in self._photos.items() if photo.is_located)
        keys = self._nearest(known) if len(known) > 1 else set()
        if len(known) < len(self._photos):
            keys |= self._most_alike(set(self._photos) - set(known))
        for key in sorted(keys):
            self._match(*key)

    def _nearest(self, names: Sequence[str]) -> set[Key]:
        """Return the pairs of nearest fixes."""
        places = np.array([self._photos[name].prior.centre[:2] for name in names])
        count = min(self._options.neighbours.nearest + 1, len(names))
        _, near = cKDTree(places).query(places, count)
        return {
            (names[min(one, other)], names[max(one, other)])
            for one, others in enumerate(near.reshape(len(names), count).tolist())
            for other in others
            if other != one
        }

    def _most_alike(self, wanted: Collection[str]) -> set[Key]:
        """Return the pairs of each of the `wanted` photographs with those most like it."""
        for name in self.without_features():
            self.extract(name)
        options = self._options.neighbours
        few = {n: f.first(options.alike_features) for n, f in self._features.items()}
        return most_alike(few, wanted, options.most, self._options.matching)

    def adopt(self, pairs: Sequence[Pair]) -> None:
        """Take over pairs that were found otherwise, in place of all others."""
        self._pairs = {(pair.first, pair.second): pair for pair in pairs}

    def match_all(self) -> None:
        """Match all pairs that the full set of photographs suggests.

        The result depends on the set of photographs, not on the order in which they came.
        """
        for name in self.without_features():
            self.extract(name)
        wanted = self._neighbours.pairs()
        for key in wanted:
            self._match(*key)
        # Pairs that only an early arrival suggested do not count.
        self._pairs = {key: pair for key, pair in self._pairs.items() if key in set(wanted)}
        least = self._options.matching.few_partners
        weak = {name for name in self._photos if len(self.partners(name)) < least}
        for key in wanted:
            if self._pairs[key] is None and key not in self._sift_tried and weak & set(key):
                self._sift_tried.add(key)
                self._pairs[key] = self._match_sift(*key)

    def partners(self, name: str) -> set[str]:
        """Return the names of the photographs that form pairs with one."""
        pairs = [key for key, pair in self._pairs.items() if pair is not None and name in key]
        return {other for key in pairs for other in key} - {name}

    def _match(self, first: str, second: str) -> Pair | None:
        key = (first, second)
        if key not in self._pairs:
            self._pairs[key] = match(self._view(first), self._view(second), 'orb', self._options)
        return self._pairs[key]

    def _match_sift(self, first: str, second: str) -> Pair | None:
        for name in (first, second):
            if name not in self._sift:
                gray = self.read_gray(name)
                self._sift[name] = sift_features(gray, self._options.features)
        views = [
            dataclasses.replace(self._view(name), features=self._sift[name])
            for name in (first, second)
        ]
        return match(views[0], views[1], 'sift', self._options)

    def _view(self, name: str) -> View:
        return View(
            photo=self._photos[name],
            features=self._features[name],
            gray=lambda: self.read_gray(name),
        )

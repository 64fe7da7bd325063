# SPDX-License-Identifier: Apache-2.0
"""A photograph with its pose."""

import json
from dataclasses import asdict, dataclass
from hashlib import sha256
from typing import Any

from rocsafe_geo.position import GeoPosition

Quaternion = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Shot:
    """One photograph.

    Attributes
    ----------
    vehicle
        Name of the vehicle that took it.
    sequence
        Number of the photograph of this vehicle, from 0, without gaps.
    viewpoint_id
        Viewpoint of the plan at which it was taken.
    time_ns
        Time of the exposure in mission time, nanoseconds.
    position
        Measured position of the camera; altitude above the ellipsoid, NaN if unknown.
    horizontal_std_m, vertical_std_m
        Standard deviation of the position, metres; NaN if unknown.
    height_m
        Measured height above the ground, metres; of a real vehicle, above its home.
    quaternion_xyzw
        Measured attitude; rotates the optical frame into east-north-up.
    width_px, height_px
        Size of the image.
    jpeg
        The image file.
    """

    vehicle: str
    sequence: int
    viewpoint_id: int
    time_ns: int
    position: GeoPosition
    horizontal_std_m: float
    vertical_std_m: float
    height_m: float
    quaternion_xyzw: Quaternion
    width_px: int
    height_px: int
    jpeg: bytes

    @property
    def shot_id(self) -> str:
        """Identifier, unique in a mission."""
        return f'{self.vehicle}-{self.sequence:05d}'

    @property
    def sha256(self) -> str:
        """SHA-256 of the image file, 64 hexadecimal digits."""
        return sha256(self.jpeg).hexdigest()


def shot_record(shot: Shot) -> bytes:
    """Return all of `shot` but the image, as JSON."""
    fields = {name: value for name, value in asdict(shot).items() if name != 'jpeg'}
    return json.dumps({**fields, 'sha256': shot.sha256}, indent=1).encode()


def shot_of(record: bytes, jpeg: bytes) -> Shot:
    """Return the shot of `shot_record` and its image.

    Raises
    ------
    ValueError
        If the record is damaged or belongs to another image.
    """
    try:
        fields: dict[str, Any] = json.loads(record)
        digest = fields.pop('sha256')
        fields['position'] = GeoPosition(**fields['position'])
        fields['quaternion_xyzw'] = tuple(fields['quaternion_xyzw'])
        shot = Shot(**fields, jpeg=jpeg)
    except (KeyError, TypeError) as error:
        raise ValueError(f'not a shot record: {error!r}') from error
    if shot.sha256 != digest:
        raise ValueError(f'sha256 of the image is {shot.sha256}: must be {digest}')
    return shot

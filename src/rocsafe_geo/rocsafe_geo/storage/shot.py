# SPDX-License-Identifier: Apache-2.0
"""A photograph with all that is needed to place it."""

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
    vehicle : that took it.
    sequence : of the vehicle, from 0, without gaps.
    viewpoint_id : of the plan it was taken at.
    time_ns : of the exposure, in the time of the mission.
    position : measured, of the camera; altitude above the ellipsoid, NaN if not known.
    horizontal_std_m, vertical_std_m : of it; NaN if not known.
    height_m : measured, above the ground: of a real vehicle, above its home.
    quaternion_xyzw : measured; rotates the optical frame into east-north-up.
    width_px, height_px : of the image.
    jpeg : the image file.
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
        """Unique in a mission."""
        return f'{self.vehicle}-{self.sequence:05d}'

    @property
    def sha256(self) -> str:
        """Of the image file, 64 hexadecimal digits."""
        return sha256(self.jpeg).hexdigest()


def shot_record(shot: Shot) -> bytes:
    """Return all of `shot` but the image, as JSON."""
    fields = {name: value for name, value in asdict(shot).items() if name != 'jpeg'}
    return json.dumps({**fields, 'sha256': shot.sha256}, indent=1).encode()


def shot_of(record: bytes, jpeg: bytes) -> Shot:
    """Return the shot of `shot_record` and its image.

    Raises
    ------
    ValueError: if the record is damaged or belongs to another image.
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

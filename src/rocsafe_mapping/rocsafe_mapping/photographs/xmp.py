# SPDX-License-Identifier: Apache-2.0
"""The pose of a photograph as XMP, in the two dialects that photogrammetry programs read.

``drone-dji``: yaw clockwise from north, pitch -90 straight down, heights with a sign.
``Camera`` (Pix4D): pitch 0 straight down, accuracies, focal length in millimetres.
"""

import math
import struct
from xml.sax.saxutils import quoteattr

import numpy as np

from rocsafe_geo.pinhole import rotation_enu_from_optical, rotation_of_quaternion
from rocsafe_mapping.photographs.shot import ShotRecord

MARK = b'http://ns.adobe.com/xap/1.0/\x00'
APP1 = 0xE1
FILM_WIDTH_MM = 36.0
PACKET = """<?xpacket begin="\ufeff" id="W5M0MpCehiHzreSzNTczkc9d"?>
<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF
 xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description rdf:about=""
 xmlns:drone-dji="http://www.dji.com/drone-dji/1.0/"
 xmlns:Camera="http://pix4d.com/camera/1.0"
 xmlns:rocsafe="https://rocsafe.invalid/xmp/1.0/"
{values}/></rdf:RDF></x:xmpmeta>
<?xpacket end="w"?>"""


def xmp_segment(record: ShotRecord) -> bytes:
    """Return the APP1 segment with the XMP of `record`, for a JPEG file."""
    block = MARK + xmp_packet(record).encode()
    return bytes((0xFF, APP1)) + struct.pack('>H', len(block) + 2) + block


def xmp_packet(record: ShotRecord) -> str:
    """Return the XMP of `record` as it stands in any kind of file."""
    values = ''.join(f' {name}={quoteattr(text)}\n' for name, text in xmp_values(record).items())
    return PACKET.format(values=values)


def xmp_values(record: ShotRecord) -> dict[str, str]:
    """Return the properties by prefix and name; what is not known is left out."""
    camera = record.camera
    numbers = {
        'drone-dji:AbsoluteAltitude': (record.altitude_m, '+.3f'),
        'drone-dji:RelativeAltitude': (record.height_agl_m, '+.3f'),
        'Camera:AboveGroundAltitude': (record.height_agl_m, '.3f'),
        'Camera:PerspectiveFocalLength': (
            camera.fx_px * FILM_WIDTH_MM / camera.width_px, '.5f',
        ),
        'Camera:GPSXYAccuracy': (_std(record.position_covariance_m2, 0, 4), '.3f'),
        'Camera:GPSZAccuracy': (_std(record.position_covariance_m2, 8, 8), '.3f'),
        'rocsafe:FocalLengthPixels': (
            camera.fx_px if camera.focal_std_share == 0.0 else math.nan, '.6f',
        ),
        **_angles(record),
    }  # fmt: skip
    values = {
        name: format(value, form)
        for name, (value, form) in numbers.items()
        if math.isfinite(value)
    }
    centre = (camera.cx_px + 0.5) / camera.width_px, (camera.cy_px + 0.5) / camera.height_px
    millimetres = (
        centre[0] * FILM_WIDTH_MM,
        (centre[1] * FILM_WIDTH_MM * camera.height_px / camera.width_px),
    )
    values['Camera:PrincipalPoint'] = f'{millimetres[0]:.5f},{millimetres[1]:.5f}'
    return values


def attitude_rad(record: ShotRecord) -> tuple[float, float, float] | None:
    """Return yaw (from east, anticlockwise), pitch and roll, None if they are not known.

    They are those of `rocsafe_geo.pinhole.rotation_enu_from_optical`.
    """
    try:
        rotation = rotation_of_quaternion(record.orientation_xyzw)
    except ValueError:
        return None
    body = rotation @ rotation_enu_from_optical(0.0).T
    pitch = -math.asin(float(np.clip(body[2, 0], -1.0, 1.0)))
    yaw = math.atan2(body[1, 0], body[0, 0])
    return yaw, pitch, math.atan2(body[2, 1], body[2, 2])


def _angles(record: ShotRecord) -> dict[str, tuple[float, str]]:
    attitude = attitude_rad(record)
    if attitude is None:
        return {}
    yaw, pitch, roll = (math.degrees(angle) for angle in attitude)
    heading = math.remainder(90.0 - yaw, 360.0)
    return {
        'drone-dji:GimbalYawDegree': (heading, '+.4f'),
        'drone-dji:GimbalPitchDegree': (-90.0 - pitch, '+.4f'),
        'drone-dji:GimbalRollDegree': (roll, '+.4f'),
        'drone-dji:FlightYawDegree': (heading, '+.4f'),
        'drone-dji:FlightPitchDegree': (0.0, '+.4f'),
        'drone-dji:FlightRollDegree': (0.0, '+.4f'),
        'Camera:Yaw': (heading % 360.0, '.4f'),
        'Camera:Pitch': (-pitch, '.4f'),
        'Camera:Roll': (roll, '.4f'),
    }


def _std(covariance: tuple[float, ...], first: int, second: int) -> float:
    variance = 0.5 * (covariance[first] + covariance[second])
    return math.sqrt(variance) if 0.0 < variance < math.inf else math.nan

# SPDX-License-Identifier: Apache-2.0
"""Whoever knows the things of a scene, named by a parameter and asked once.

So things of a virtual environment shield, and this package knows of none.
"""

from collections.abc import Callable
from functools import lru_cache

from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.field_parameters.provider import provider_of
from rocsafe_radiation.physics.shielding import Shielding

# File, seed and origin of the mission -> what stands in the way.
ShieldingProvider = Callable[[str, int, GeoPosition], Shielding]


# A scene takes seconds to make: options that are checked and then used make it once.
@lru_cache(maxsize=1)
def provided_shielding(name: str, file: str, seed: int, origin: GeoPosition) -> Shielding:
    """Return what `name`, a ``module:function``, says of the scene of `file`.

    Raises
    ------
    ValueError: in one line, if there is no such function or it cannot say.
    """
    provider: ShieldingProvider = provider_of('shielding', name)
    try:
        return provider(file, seed, origin)
    except Exception as error:
        raise ValueError(f'shielding_file = {file!r}: {error}') from error

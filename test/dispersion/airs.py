# SPDX-License-Identifier: Apache-2.0
"""Air, winds and releases that tests of dispersion share."""

from rocsafe_dispersion.plume.release import Release
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.wind_field import ProfileWind
from rocsafe_geo.wind.wind_vector import WindVector

LAYER = SurfaceLayer(friction_velocity_mps=0.35, roughness_m=0.03)
SPEED_MPS = float(LAYER.speed_mps(10.0))
EASTWARDS = WindVector(towards_east_mps=SPEED_MPS, towards_north_mps=0.0)
WIND = ProfileWind(layer=LAYER, wind=EASTWARDS)
RELEASE = Release(place_m=(0.0, 0.0), height_m=1.0, rate_g_s=1.0)

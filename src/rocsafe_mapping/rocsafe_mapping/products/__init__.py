# SPDX-License-Identifier: Apache-2.0
"""The files of a finished map: GeoTIFF, tiles, pictures, quality, errors, labels."""

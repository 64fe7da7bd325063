# SPDX-License-Identifier: Apache-2.0
"""Image store and mosaic of ROCSAFE."""

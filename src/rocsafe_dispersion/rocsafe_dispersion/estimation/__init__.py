# SPDX-License-Identifier: Apache-2.0
"""Where a release is and how strong, from readings."""

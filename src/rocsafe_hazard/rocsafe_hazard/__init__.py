# SPDX-License-Identifier: Apache-2.0
"""What radiation and dispersion share: spool of readings, requests for an assessment, grids."""

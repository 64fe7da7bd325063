# SPDX-License-Identifier: Apache-2.0
"""Chemical and biological releases: wind, plumes, detectors and source estimation."""

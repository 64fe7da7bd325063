# SPDX-License-Identifier: Apache-2.0
"""Files of a drive, for people, maps and autopilots."""

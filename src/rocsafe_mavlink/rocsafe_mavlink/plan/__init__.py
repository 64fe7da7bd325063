# SPDX-License-Identifier: Apache-2.0
"""The plan of a flight of one vehicle: its mission, its fence, its way home, its limits."""

# SPDX-License-Identifier: Apache-2.0
"""A real vehicle and the station that talks to it."""

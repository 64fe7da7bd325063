# SPDX-License-Identifier: Apache-2.0
"""The plan: routes, times, separation."""

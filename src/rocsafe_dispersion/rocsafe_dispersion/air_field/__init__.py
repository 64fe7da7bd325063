# SPDX-License-Identifier: Apache-2.0
"""The simulated air of a mission: wind, releases, and what the vehicles' sensors read."""

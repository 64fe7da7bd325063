# SPDX-License-Identifier: Apache-2.0
"""What lies on the simulated ground, and how it is painted."""

# SPDX-License-Identifier: Apache-2.0
"""Lower bounds: how short the longest route could be at best."""

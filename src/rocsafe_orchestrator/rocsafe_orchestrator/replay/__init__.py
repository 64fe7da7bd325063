# SPDX-License-Identifier: Apache-2.0
"""A recorded run fed to the nodes that estimate and map, as the vehicles fed them."""

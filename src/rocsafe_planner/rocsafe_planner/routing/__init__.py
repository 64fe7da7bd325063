# SPDX-License-Identifier: Apache-2.0
"""Methods that assign viewpoints to vehicles and order them, and bounds for them."""

# SPDX-License-Identifier: Apache-2.0
"""Parameters and settings file of the simulated field, and the field made from them."""

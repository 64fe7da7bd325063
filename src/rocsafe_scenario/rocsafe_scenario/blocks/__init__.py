# SPDX-License-Identifier: Apache-2.0
"""The blocks of a scenario file, each with its keys, units, limits and defaults."""

# SPDX-License-Identifier: Apache-2.0
"""The command that localises sources in a file of readings."""

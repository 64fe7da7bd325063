# SPDX-License-Identifier: Apache-2.0
"""Which processes a mission has, with their arguments and files."""

# SPDX-License-Identifier: Apache-2.0
"""What a run leaves: read back from its files, summed up, reported."""

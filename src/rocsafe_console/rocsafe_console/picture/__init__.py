# SPDX-License-Identifier: Apache-2.0
"""What the page shows: the present state of a mission, and its encoding."""

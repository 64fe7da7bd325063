# SPDX-License-Identifier: Apache-2.0
"""The table of a campaign, its statistics and its page."""

# SPDX-License-Identifier: Apache-2.0
"""Units of time. Clocks count whole nanoseconds; durations are seconds."""

NS_PER_S = 1_000_000_000
# No vehicle waits longer for its start, or for a battery.
LONGEST_WAIT_S = 86_400.0

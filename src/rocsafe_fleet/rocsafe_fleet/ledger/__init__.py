# SPDX-License-Identifier: Apache-2.0
"""What the agents know together, and the packets that spread it."""

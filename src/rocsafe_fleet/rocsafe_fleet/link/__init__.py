# SPDX-License-Identifier: Apache-2.0
"""Ways of packets between agents on different hosts."""

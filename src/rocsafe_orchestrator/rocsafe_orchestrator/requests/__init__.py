# SPDX-License-Identifier: Apache-2.0
"""What a mission asks of other nodes, and their answers."""

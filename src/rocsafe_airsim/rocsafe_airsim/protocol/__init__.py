# SPDX-License-Identifier: Apache-2.0
"""MessagePack-RPC over TCP: bytes, calls, connections."""

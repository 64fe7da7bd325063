# SPDX-License-Identifier: Apache-2.0
"""MAVLink messages as bytes: framing, signing, limits."""

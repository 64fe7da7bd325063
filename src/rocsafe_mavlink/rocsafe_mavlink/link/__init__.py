# SPDX-License-Identifier: Apache-2.0
"""Links to vehicles: endpoints, transports, peers."""

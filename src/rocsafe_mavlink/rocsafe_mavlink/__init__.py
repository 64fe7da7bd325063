# SPDX-License-Identifier: Apache-2.0
"""Real autopilots behind the interface of a ROCSAFE vehicle: the only user of pymavlink."""

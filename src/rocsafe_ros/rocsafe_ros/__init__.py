# SPDX-License-Identifier: Apache-2.0
"""What every ROCSAFE node shares: parameters, topics, conversions, life cycle."""

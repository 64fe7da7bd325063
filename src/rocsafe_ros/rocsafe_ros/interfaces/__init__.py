# SPDX-License-Identifier: Apache-2.0
"""Names, types and qualities of service of all topics, services and actions."""

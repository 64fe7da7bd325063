# SPDX-License-Identifier: Apache-2.0
"""All photographs of a map, aligned and drawn; what changed between two maps."""

# SPDX-License-Identifier: Apache-2.0
"""Structure from motion: poses of photographs that look in any direction, from what they show."""

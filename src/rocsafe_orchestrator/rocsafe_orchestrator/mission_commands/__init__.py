# SPDX-License-Identifier: Apache-2.0
"""Commands that fly a mission, or make its products again."""

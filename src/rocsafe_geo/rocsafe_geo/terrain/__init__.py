# SPDX-License-Identifier: Apache-2.0
"""Heights of the ground."""

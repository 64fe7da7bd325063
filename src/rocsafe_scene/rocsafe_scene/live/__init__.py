# SPDX-License-Identifier: Apache-2.0
"""A live view of a scene with what moves in it."""

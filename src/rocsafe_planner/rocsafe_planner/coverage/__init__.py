# SPDX-License-Identifier: Apache-2.0
"""Viewpoints of a survey, and the ground that their photographs show."""

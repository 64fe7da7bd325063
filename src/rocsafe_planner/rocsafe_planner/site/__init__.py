# SPDX-License-Identifier: Apache-2.0
"""The site of a survey: what is asked for, and the viewpoints in it."""

# SPDX-License-Identifier: Apache-2.0
"""A vehicle with its sensors."""

# SPDX-License-Identifier: Apache-2.0
"""Painting of the ground: noise, marks, and the canvas they are painted on."""

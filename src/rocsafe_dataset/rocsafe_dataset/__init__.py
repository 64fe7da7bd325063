# SPDX-License-Identifier: Apache-2.0
"""Labelled pictures of scenes, for training and testing detectors."""

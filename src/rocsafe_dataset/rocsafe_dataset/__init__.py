# SPDX-License-Identifier: Apache-2.0
"""Labelled images of scenes, for training and testing detectors."""

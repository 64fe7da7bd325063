# SPDX-License-Identifier: Apache-2.0
"""What is on a picture: boxes, outlines and masks."""

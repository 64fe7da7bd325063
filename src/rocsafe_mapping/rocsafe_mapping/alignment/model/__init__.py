# SPDX-License-Identifier: Apache-2.0
"""What is known and what is sought: photographs, poses, lenses, the ground."""

# SPDX-License-Identifier: Apache-2.0
"""Triangle meshes, surfaces, classes and simple shapes."""

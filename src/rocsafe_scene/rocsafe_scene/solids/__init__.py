# SPDX-License-Identifier: Apache-2.0
"""The solid things of a scene: obstacles for vehicles, and values for other packages."""

# SPDX-License-Identifier: Apache-2.0
"""Things of a scene as meshes."""

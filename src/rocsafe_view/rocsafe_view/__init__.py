# SPDX-License-Identifier: Apache-2.0
"""What the pages of ROCSAFE share: number formats, colours, map, charts, templates and style."""

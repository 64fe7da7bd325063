# SPDX-License-Identifier: Apache-2.0
"""What other systems read: Cursor on Target, GeoJSON."""

# SPDX-License-Identifier: Apache-2.0
"""An independent check of plans."""

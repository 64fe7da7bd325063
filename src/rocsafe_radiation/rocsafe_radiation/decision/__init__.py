# SPDX-License-Identifier: Apache-2.0
"""When the evidence is enough, and where to measure next."""

# SPDX-License-Identifier: Apache-2.0
"""How the runs of a campaign are carried out."""

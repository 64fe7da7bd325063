# SPDX-License-Identifier: Apache-2.0
"""Values of the survey problem: vehicles, viewpoints, airspace and the time of legs."""

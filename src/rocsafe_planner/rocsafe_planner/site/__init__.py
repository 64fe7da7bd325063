# SPDX-License-Identifier: Apache-2.0
"""The site of a survey: the request in a plane, and its viewpoints."""

# SPDX-License-Identifier: Apache-2.0
"""A drive: from the products of a survey to a route that was checked."""

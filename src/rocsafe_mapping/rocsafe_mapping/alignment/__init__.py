# SPDX-License-Identifier: Apache-2.0
"""Photographs to poses, from what they show of the same ground. Pure.

`steps` shows the method on one page; `block` holds the photographs of a map while they come in.
Rooms, in the order of the steps: `matching` (features, neighbours, pairs), `initial` (graph of
pairs, first poses), `adjustment` (least squares, ground heights, clocks). `model` has the values
that all of them share. Constants stand in `rocsafe_mapping.alignment_options`.
"""

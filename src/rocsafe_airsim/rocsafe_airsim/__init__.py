# SPDX-License-Identifier: Apache-2.0
"""AirSim's API over the vehicles of ROCSAFE: unmodified client scripts fly them.

The names of methods and fields, and the frame (north, east, down), are those of AirSim's clients
(microsoft/AirSim 1.8, Cosys-AirSim 3).
"""

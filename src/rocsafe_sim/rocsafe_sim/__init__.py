# SPDX-License-Identifier: Apache-2.0
"""Simulated time and simulated vehicles, with their batteries, cameras and sensor errors.

A vehicle has three layers: `SimulatedVehicle` (room ``vehicle``) obeys commands and flies; `Rav`
(room ``rav``) adds sensors, cameras and files to it; `VehicleInterface` gives a `Rav` its topics,
services and action. The nodes ``rav`` and ``fleet`` hold one or many of these.
"""

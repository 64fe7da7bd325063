// SPDX-License-Identifier: Apache-2.0
// Depth alone, for shadows and for the canopy.
#version 330
in float depth;
out vec4 bits;

void main() {
    uint raw = floatBitsToUint(depth);
    bits = vec4((raw >> 16) & 255u, (raw >> 8) & 255u, raw & 255u, raw >> 24) / 255.0;
}

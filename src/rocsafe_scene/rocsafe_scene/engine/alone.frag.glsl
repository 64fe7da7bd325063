// SPDX-License-Identifier: Apache-2.0
// Instance numbers alone.
#version 330
uniform ivec4 meta;             // class, instance, 0, 0
out vec4 bits;

void main() {
    uint number = uint(meta.y);
    bits = vec4((number >> 16) & 255u, (number >> 8) & 255u, number & 255u, 255u) / 255.0;
}

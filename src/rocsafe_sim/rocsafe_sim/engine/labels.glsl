// SPDX-License-Identifier: Apache-2.0
// Floats and numbers travel as raw bits in 8-bit targets, lossless.

layout(location = 0) out vec4 picture;
layout(location = 1) out vec4 depth_bits;
layout(location = 2) out vec4 label_bits;
layout(location = 3) out vec4 normal_bits;

vec4 as_bytes(uint bits) {
    return vec4((bits >> 16) & 255u, (bits >> 8) & 255u, bits & 255u, bits >> 24) / 255.0;
}

void write_labels(float depth, int number, int kind, vec3 n) {
    depth_bits = as_bytes(floatBitsToUint(depth));
    label_bits = as_bytes(uint(number) | uint(kind) << 24);
    normal_bits = vec4(0.5 + 0.5 * n, 1.0);
}

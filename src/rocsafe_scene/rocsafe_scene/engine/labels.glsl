// SPDX-License-Identifier: Apache-2.0
// Floats and numbers travel as raw bits in 8-bit targets, lossless.

#ifdef LABELS
vec4 picture;                   // Goes nowhere, so that nothing it is made of is computed.
#else
layout(location = 0) out vec4 picture;
#endif
layout(location = 1) out vec4 depth_bits;
layout(location = 2) out vec4 label_bits;
layout(location = 3) out vec4 normal_bits;

vec4 as_bytes(uint bits) {
    return vec4((bits >> 16) & 255u, (bits >> 8) & 255u, bits & 255u, bits >> 24) / 255.0;
}

// Depth is that of the projection: 1 / w, of cameras with perspective.
void write_labels(int number, int kind, vec3 n) {
    depth_bits = as_bytes(floatBitsToUint(1.0 / gl_FragCoord.w));
    label_bits = as_bytes(uint(number) | uint(kind) << 24);
    normal_bits = vec4(0.5 + 0.5 * n, 1.0);
}
